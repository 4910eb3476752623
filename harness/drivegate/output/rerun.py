"""Commands that a page prints for its own folder: they go to the folder in which the check ran, and run there."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from shlex import quote
from typing import Any, Final

from drivegate.output.result_file import counterexample_name
from drivegate.output.wording import drive_option
from drivegate_cases.documents.wording import one_line

PLACES: Final = "places"
"""Key of a result's times with the ways between its report and the folder in which it was checked."""
_BUILT_IN: Final = "builtin"
"""Kind of candidates whose name is no path."""


def places_of(report: Path, working: Path | None = None) -> dict[str, str]:
    """Return the ways between the folder of a report and the working folder, by default the present one."""
    here = working or Path.cwd()
    return {"to_working_folder": os.path.relpath(here, report), "to_report": os.path.relpath(report, here)}


def moved_to(result: Mapping[str, Any], file: Path, report: Path) -> dict[str, Any]:
    """Return a result that was read from a file for a report in another folder, from which the ways are others."""
    timing = dict(result.get("timing") or {})
    places = timing.pop(PLACES, None)
    back = places.get("to_working_folder") if isinstance(places, Mapping) else None
    working = file.resolve().parent / back if isinstance(back, str) else None
    if working is not None and working.is_dir():
        timing[PLACES] = places_of(report.resolve(), working.resolve())
    return {**result, "timing": timing}


def replay_command(document: Mapping[str, Any], check: str, *, plot: bool = False) -> str:
    """Write what runs the counterexample of a check again, in the folder of the report."""
    file, back = counterexample_name(check), _way_back(document)
    if back:
        file = str(Path(str(document["timing"][PLACES]["to_report"])) / file)
    candidate = quote(one_line(str(document["candidate"]["specification"])))
    drawn = f" --plot {check}.svg" if plot else ""
    return f"{back}drivegate replay {quote(one_line(file))} --candidate {candidate}{drawn}"


def check_command(document: Mapping[str, Any]) -> str:
    """Write what checks the candidate of a result again, in the folder of the report."""
    candidate = quote(one_line(str(document["candidate"]["specification"])))
    return f"{_way_back(document)}drivegate check {candidate}{drive_option(document)}"


def _way_back(document: Mapping[str, Any]) -> str:
    """Write the change to the folder in which paths of the command lead to their files; empty where it has no path."""
    places = (document.get("timing") or {}).get(PLACES)
    drive = str((document.get("drive") or {}).get("specification") or "")
    is_path = document["candidate"].get("kind") != _BUILT_IN or "." in drive or "/" in drive
    if not isinstance(places, Mapping) or not is_path:
        return ""
    return f"cd {quote(one_line(str(places['to_working_folder'])))} && "
