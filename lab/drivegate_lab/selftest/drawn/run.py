"""A self-test on drawn drives from its request to its document, going on from what is kept."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from drivegate.containment.backend import Backend, done_by
from drivegate.contracts.catalogue import contract_named
from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.gate.warm_up import compile_missing
from drivegate.output.progress import Display, with_rate
from drivegate.results.result import finite
from drivegate_cases.drive.drive_document import load_drive
from drivegate_lab.drawn.drawing import DrawnDrive
from drivegate_lab.drawn.kinds import DRAWN_KINDS
from drivegate_lab.selftest.drawn.folder import SUMMARY, DrivesFolder
from drivegate_lab.selftest.drawn.summary import JudgedDrive, summarised
from drivegate_lab.selftest.drawn.tasks import packed, row_from, run_faults, run_gate
from drivegate_lab.selftest.run import SelftestEffort

_TOGETHER: Final = 8
"""Most faulty controllers that one task tries."""


@dataclass(frozen=True)
class DrivesRequest:
    """What a self-test on drawn drives is to do."""

    kind: str
    """Kind of the drives, one of `drivegate_lab.drawn.kinds.DRAWN_KINDS`."""
    drives: int
    """Number of drives."""
    drawing_seed: int
    """Seed that they are drawn with."""
    faults: tuple[str, ...]
    """Names of the faulty controllers that are tried on each drive that the controller without a fault
    passes."""
    effort: SelftestEffort
    """How much is searched."""
    output: Path
    """Folder of drives and results."""


def selftest_on_drives(request: DrivesRequest, display: Display) -> dict[str, Any]:
    """Judge the kind's usual controller on every drive, and the faulty ones where it passes."""
    began = time.monotonic()
    kind = DRIVE_KINDS[request.kind]
    with DrivesFolder(request.output, request.kind, request.drawing_seed, request.effort) as folder:
        compile_missing([load_drive(kind.default_drive)])
        drawn = _drawn(request, folder, display)
        package = packed(request.effort, {number: drive.document for number, drive in drawn.items()})
        backend = Backend(workers=request.effort.workers)
        made = _judge_usual(
            contract_named(kind.contract).usual_candidate, list(drawn), package, backend, folder, display
        )
        judged = [
            JudgedDrive(
                number, drive.document, drive.rejected, _rows(folder, number), folder.drive_path(number)
            )
            for number, drive in drawn.items()
        ]
        passed = [drive.number for drive in judged if drive.passed]
        items = [(number, name) for number in passed for name in request.faults]
        made += _try_faults(items, package, backend, folder, display)
        trials = {item: folder.kept(*item) or {} for item in items}
        document = summarised(
            request.kind, request.effort, request.drawing_seed, judged, request.faults, trials
        )
        folder.write(folder.place / SUMMARY, folder.as_json(finite(document)))
    timing = {"seconds": time.monotonic() - began, "made": made}
    return document | {"output": str(request.output), "timing": timing}


def _drawn(request: DrivesRequest, folder: DrivesFolder, display: Display) -> dict[int, DrawnDrive]:
    """Draw all drives again, which takes a moment, and write those that are not there."""
    report_progress = with_rate(display, "drawing", request.drives, "drives")
    report_progress(0, 0)
    drawn = {}
    for number in range(1, request.drives + 1):
        drawn[number] = DRAWN_KINDS[request.kind].draw(request.drawing_seed, number)
        folder.keep_drive(number, drawn[number])
        report_progress(number, 0)
    return drawn


def _judge_usual(
    name: str,
    numbers: Sequence[int],
    package: bytes,
    backend: Backend,
    folder: DrivesFolder,
    display: Display,
) -> int:
    left = [number for number in numbers if folder.kept(number) is None]
    done = before = len(numbers) - len(left)
    report_progress = with_rate(display, name, len(numbers), "drives")
    report_progress(done, before)
    for number, rows in done_by(backend, run_gate, package, left):
        folder.keep(number, {"number": number, "seeds": [row.document() for row in rows]})
        done += 1
        report_progress(done, before)
        for row in (row for row in rows if not row.passed):
            why = ", ".join(check.check for check in row.failed) or row.message
            display.announce(f"drive {number:03d}, seed {row.seed}: {row.verdict}{why and f', {why}'}")
    return done - before


def _try_faults(
    items: Sequence[tuple[int, str]], package: bytes, backend: Backend, folder: DrivesFolder, display: Display
) -> int:
    if not items:
        return 0
    left = [item for item in items if folder.kept(*item) is None]
    done = before = len(items) - len(left)
    report_progress = with_rate(display, "faulty controllers", len(items), "trials")
    report_progress(done, before)
    for (number, _names), outcomes in done_by(backend, run_faults, package, _together(left)):
        for outcome in outcomes:
            folder.keep(number, outcome, outcome["fault"])
        done += len(outcomes)
        report_progress(done, before)
    return done - before


def _together(items: Sequence[tuple[int, str]]) -> list[tuple[int, tuple[str, ...]]]:
    """Put a few trials of one drive together, since most of a short one is starting a process."""
    by_drive: dict[int, list[str]] = {}
    for number, name in items:
        by_drive.setdefault(number, []).append(name)
    return [
        (number, tuple(names[start : start + _TOGETHER]))
        for number, names in by_drive.items()
        for start in range(0, len(names), _TOGETHER)
    ]


def _rows(folder: DrivesFolder, number: int) -> tuple[Any, ...]:
    kept = folder.kept(number)
    assert kept is not None, "every drive has been judged"
    return tuple(row_from(row) for row in kept["seeds"])
