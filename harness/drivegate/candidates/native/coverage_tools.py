"""The tools that read counters and write reports, which are run like a compiler: isolated, and within bounds."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import shutil
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import bounded_reason
from drivegate.candidates.native.bounded_command import Bounds, run_bounded
from drivegate.candidates.reached_code import Line, SourceFile
from drivegate.isolation.layers import Places, isolated_command, requested_layers
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.regular_file import made_content, require_made
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

LCOV: Final = "coverage.info"
COBERTURA: Final = "coverage.xml"
"""Names of the files that services read."""

TRACE: Final = "trace.json"
_READING: Final = Bounds(120.0)
_DIGEST: Final = re.compile(r"^(DA:\d+,\d+),\S+$", re.MULTILINE)
"""A line's count in a file of LCOV, with a digest of its text."""


def work_folder(candidate: Candidate) -> Path:
    """Make the folder of the tools in that of what a candidate's processes have counted."""
    assert candidate.instrumented is not None, "it was counted"
    # The processes write into the folder above, and must not know the name.
    return Path(tempfile.mkdtemp(prefix="work-", dir=candidate.instrumented.folder))


def hand_over(work: Path, output: Path) -> None:
    """Copy the files that services read into a folder."""
    take_over(work / COBERTURA, output)
    # Digests of lines are hexadecimal from gcovr, and genhtml refuses all but its own.
    listed = _DIGEST.sub(r"\1", made_content(work / LCOV).decode(errors="replace"))
    write_atomically(output / LCOV, listed)


def take_over(file: Path, folder: Path) -> None:
    """Copy a file that a candidate's process or a tool has made into a folder, unless it is a link or a device."""
    try:
        require_made(file)
        shutil.copy(file, folder)
    except OSError as error:
        reason = one_line(error.strerror or str(error))
        raise InputError(
            f"{one_line(file.name)}, which --coverage reads, cannot be copied: {reason}; the candidate must leave "
            "alone what it has not opened"
        ) from error


def require_package(name: str, option: str) -> None:
    """Refuse an option whose tool is not installed."""
    if importlib.util.find_spec(name) is None:
        raise InputError(
            f"{option} needs the tool {name}, which is not installed; python -m pip install 'drivegate[coverage]'"
        )


def run_tool(words: Sequence[str], folder: Path, readable: Iterable[Path], writable: Path, name: str) -> str:
    """Run a tool in a folder to its end, and return what it printed."""
    places = Places(tuple(str(place.resolve()) for place in (folder, *readable)), (str(writable.resolve()),))
    environment = {"LC_ALL": "C.UTF-8", "TMPDIR": str(writable)}
    command = isolated_command(words, requested_layers(), places)
    ended = run_bounded(command, folder=folder, environment=environment, bounds=_READING)
    if ended.status != 0:
        printed = [line for line in ended.output.splitlines() if line.strip()]
        reason = bounded_reason(printed[-1]) if printed else f"it ended with status {ended.status}"
        raise InputError(
            f"--coverage: {name} cannot read what the candidate's processes counted: {reason}; leave the option out"
        )
    return ended.output


def gcovr(words: Sequence[str], folder: Path, readable: Iterable[Path], writable: Path) -> None:
    # A file of settings in the candidate's folder is for its own tests.
    run_tool(
        [sys.executable, "-P", "-m", "gcovr", "--config", os.devnull, *words],
        folder,
        readable,
        writable,
        "gcovr",
    )


def files_of_trace(trace: Path, folder: Path) -> tuple[SourceFile, ...]:
    """Read the files that gcovr's JSON lists, whose paths begin in a folder."""
    document = json.loads(made_content(trace))
    return tuple(
        _file(file, folder) for file in sorted(document["files"], key=lambda file: str(file["file"]))
    )


def _file(file: Mapping[str, Any], folder: Path) -> SourceFile:
    name = str(file["file"])
    text = (folder / name).read_text(encoding="utf-8", errors="replace").splitlines()
    lines: dict[int, Line] = {}
    for entry in file["lines"]:
        if entry.get("gcovr/excluded") or entry.get("gcovr/noncode"):
            continue
        branches = tuple(
            int(branch["count"]) for branch in entry.get("branches", ()) if not branch.get("gcovr/excluded")
        )
        number = int(entry["line_number"])
        # A line has an entry for each function that it is part of.
        before = lines.get(number, Line(number, 0))
        lines[number] = Line(number, max(before.count, int(entry["count"])), before.branches + branches)
    return SourceFile(name, tuple(text), tuple(lines[number] for number in sorted(lines)))
