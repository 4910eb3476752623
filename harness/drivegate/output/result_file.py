"""The result as JSON, and a file for every counterexample."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any, Final

from drivegate.candidates.fault import bounded_line

RESULT_FILE: Final = "result.json"
COUNTEREXAMPLES: Final = "counterexamples"
FAULTS: Final = "faults"

_NUMBERS: Final = re.compile(r"\[\n\s+(?:[-+.\deE]+|null)(?:,\n\s+(?:[-+.\deE]+|null))*\n\s+\]")


def as_json(document: dict[str, Any]) -> str:
    """Write a document as the text of a file; a list of numbers is on one line."""
    text = json.dumps(document, indent=2, ensure_ascii=True, allow_nan=False)
    # Within a string a line end would be an escape.
    return (
        _NUMBERS.sub(lambda listed: " ".join(listed[0].split()).replace("[ ", "[").replace(" ]", "]"), text)
        + "\n"
    )


def write_result_files(result: dict[str, Any], folder: Path) -> None:
    """Write a result document, and every counterexample into a file of its own."""
    (folder / RESULT_FILE).write_text(as_json(result), encoding="utf-8")
    for document in counterexamples(result):
        path = folder / counterexample_name(document["check"])
        path.parent.mkdir(exist_ok=True)
        path.write_text(as_json(document), encoding="utf-8")
    for place, fault in enumerate(result["faults"], 1):
        if fault.get("scenario") is not None:
            path = folder / fault_scenario_name(place)
            path.parent.mkdir(exist_ok=True)
            path.write_text(as_json(fault["scenario"]), encoding="utf-8")


def fault_scenario_name(place: int) -> str:
    """Name the file with the scenario of a fault, counted from 1, in the folder of the report."""
    return f"{FAULTS}/{place}.json"


def counterexample_name(check: str) -> str:
    """Name the file of a counterexample, in the folder of the report."""
    return f"{COUNTEREXAMPLES}/{check}.json"


def counterexamples(result: dict[str, Any]) -> list[dict[str, Any]]:
    # Typed documents take a while to import, and most checks end without a counterexample.
    from drivegate.results.counterexample import KIND, Counterexample
    from drivegate_cases.documents.document import parse_document

    versions = {key: value for key, value in result["provenance"].items() if key != "content_hash"}
    documents, drive = [], result.get("drive")
    for check in result["checks"]:
        if check["counterexample"] is None:
            continue
        found = check["found"] or {"margin": check["margin"], "measured": check["measured"]}
        content = {
            "schema": Counterexample.schema_current,
            "kind": KIND,
            "check": check["id"],
            "requirement": bounded_line(check["requirement"]),
            "limit": bounded_line(check["limit"]),
            "margin": found["margin"],
            "measured": bounded_line(found["measured"]),
            "seed": result["seed"],
            "size": found.get("size"),
            "candidate": {
                "name": bounded_line(result["candidate"]["name"]),
                "hash": result["candidate"]["hash"],
            },
            "drive": drive and {key: drive[key] for key in ("name", "kind", "hash")},
            "versions": versions,
            "scenario": check["counterexample"],
        }
        if check.get("row") is not None:
            content["row"] = check["row"]
        where = f"the counterexample to {check['id']}"
        documents.append(parse_document(content, Counterexample, where).to_mapping())
    return documents
