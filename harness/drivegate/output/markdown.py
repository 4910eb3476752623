"""The result as Markdown, for the summary that CI servers show beside a job."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any, Final

from drivegate.output.distinct_faults import distinct_faults, in_runs
from drivegate.output.result_file import counterexample_name
from drivegate.results.wording import printed_margin, runs_in_short
from drivegate_cases.documents.wording import one_line

SUMMARY_FILE: Final = "summary.md"

_SPECIAL = re.compile(r"([\\`*_\[\]<>|~#&@])")


def write_markdown(result: dict[str, Any], folder: Path) -> Path:
    """Write the summary of a result document into a folder."""
    path = folder / SUMMARY_FILE
    path.write_text(markdown(result), encoding="utf-8")
    return path


def escaped(text: object) -> str:
    """Write any text so that Markdown shows it as it is, on one line."""
    return _SPECIAL.sub(r"\\\1", one_line(str(text)))


def markdown(result: dict[str, Any]) -> str:
    """Make the summary of a result document."""
    candidate = result["candidate"]
    lines = [
        f"# {escaped(candidate['name'])}: {escaped(result['verdict'])}",
        "",
        f"{runs_in_short(result)}, effort {escaped(result['effort'])}, "
        f"seed {result['seed']}, drivegate {escaped(result['provenance']['drivegate'])}.",
        "",
        *_causes(result),
        "| check | level | verdict | margin | message |",
        "|---|---|---|---:|---|",
    ]
    for check in result["checks"]:
        margin = printed_margin(result, check)
        cells = (check["id"], check["level"], check["verdict"], margin, check["message"])
        lines.append(f"| {' | '.join(map(escaped, cells))} |")
    lines += _faults(result["faults"])
    lines += _comparisons(result["baseline"] or [])
    failed = [check for check in result["checks"] if check["counterexample"] is not None]
    if failed:
        lines += ["", "## Counterexamples", ""]
    for check in failed:
        file = counterexample_name(check["id"])
        lines.append(
            f"- {escaped(check['id'])}: {escaped(check['counterexample']['name'])}, in [{file}]({file})"
        )
        lines += _account(result, check)
    return "\n".join(lines) + "\n"


def _causes(result: dict[str, Any]) -> list[str]:
    if all(check["counterexample"] is None for check in result["checks"]):
        return []
    # It brings the oracle, which a result without failures does not need.
    from drivegate.output.causes import causes_of

    lines = [f"- {escaped(cause)}" for cause in causes_of(result)]
    return [*lines, ""] if lines else []


def _account(result: dict[str, Any], check: dict[str, Any]) -> list[str]:
    # It brings the oracle, which a result without failures does not need.
    from drivegate.output.account import account_of

    return [f"  {escaped(sentence)}" for sentence in account_of(result, check)]


def _comparisons(entries: list[dict[str, Any]]) -> list[str]:
    if not entries:
        return []
    lines = ["", "## Against the baseline", "", "| check | level | verdict | message |", "|---|---|---|---|"]
    for entry in entries:
        cells = (entry["check"], entry["level"], entry["verdict"], entry["message"])
        lines.append(f"| {' | '.join(map(escaped, cells))} |")
    return lines


def _faults(faults: list[dict[str, Any]]) -> list[str]:
    if not faults:
        return []
    listed = (
        f"- {escaped(fault['kind'])}{in_runs(count)}: {escaped(fault['message'])}"
        for fault, count in distinct_faults(faults)
    )
    return ["", "## Faults", "", *listed]
