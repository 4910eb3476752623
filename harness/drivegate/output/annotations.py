"""The result as workflow commands of GitHub Actions, which shows each as an annotation of the job."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from drivegate.output.distinct_faults import distinct_faults, in_runs
from drivegate.output.explanations import explanations
from drivegate.results.result import STALE_WAIVERS, counted_levels
from drivegate_cases.documents.wording import one_line

ANNOTATIONS_FILE: Final = "annotations.txt"

_IN_MESSAGE: Final = str.maketrans({"%": "%25", "\r": "%0D", "\n": "%0A"})
_IN_TITLE: Final = _IN_MESSAGE | str.maketrans({":": "%3A", ",": "%2C"})


def write_annotations(result: dict[str, Any], folder: Path) -> Path:
    """Write the annotations of a result document into a folder."""
    path = folder / ANNOTATIONS_FILE
    path.write_text("".join(f"{line}\n" for line in workflow_commands(result)), encoding="utf-8")
    return path


def workflow_commands(result: dict[str, Any]) -> list[str]:
    """Make one command for each fault and for each check that is not simply met."""
    name = result["candidate"]["name"]
    counted = counted_levels(result.get("fail_on"))
    lines = [
        _command("error", f"{name} {fault['kind']}{in_runs(count)}", fault["message"])
        for fault, count in distinct_faults(result["faults"])
    ]
    explained = explanations(result)
    for check in result["checks"]:
        level = _level(check, counted)
        if level:
            message = "; ".join(filter(None, (explained.get(check["id"]), check["message"])))
            lines.append(_command(level, f"{name} {check['id']} {check['verdict']}", message))
    lines += [
        _command("error", f"{name} {entry['check']} against the baseline", entry["message"])
        for entry in result["baseline"] or ()
        if entry["level"] in counted and entry["verdict"] == "fail"
    ]
    return lines


def _level(check: dict[str, Any], counted: tuple[str, ...]) -> str:
    """Tell how serious a check's outcome is; empty where there is nothing to tell."""
    verdict = check["verdict"]
    if verdict in ("pass", "not applicable"):
        return ""
    if verdict in STALE_WAIVERS or (check["level"] in counted and verdict not in ("contested", "waived")):
        return "error"
    return "notice" if verdict == "waived" else "warning"


def _command(level: str, title: str, message: str) -> str:
    return (
        f"::{level} title={one_line(title).translate(_IN_TITLE)}::{one_line(message).translate(_IN_MESSAGE)}"
    )
