"""What a self-test on drawn drives says: shares with their intervals, and the worst of each failed check."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from math import inf
from pathlib import Path
from typing import Any

from drivegate.contracts.catalogue import contract_named
from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.results.proportion import CONFIDENCE, proportion
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_lab.drawn.kinds import DRAWN_KINDS
from drivegate_lab.selftest.drawn.folder import KIND, SCHEMA
from drivegate_lab.selftest.drawn.tasks import FailedCheck, GateRow
from drivegate_lab.selftest.run import SelftestEffort


@dataclass(frozen=True)
class JudgedDrive:
    """A drawn drive, and what has become of the reference on it."""

    number: int
    """Its number."""
    drive: DriveDocument
    """The drive."""
    rejected: int
    """Number of drives drawn before it whose rating no controller can meet."""
    rows: tuple[GateRow, ...]
    """One for each seed."""
    file: Path
    """The file of the drive."""

    @property
    def passed(self) -> bool:
        """Whether the reference passes with every seed."""
        return all(row.passed for row in self.rows)


def summarised(
    kind: str,
    effort: SelftestEffort,
    drawing_seed: int,
    drives: Sequence[JudgedDrive],
    faults: Sequence[str],
    trials: Mapping[tuple[int, str], Mapping[str, Any]],
) -> dict[str, Any]:
    """Write a whole self-test on drawn drives as plain data."""
    passed = sum(drive.passed for drive in drives)
    caught = [trial["caught"] for trial in trials.values() if applies(trial)]
    return {
        "schema": SCHEMA,
        "kind": KIND,
        "drive_kind": kind,
        "candidate": contract_named(DRIVE_KINDS[kind].contract).usual_candidate,
        "passed": passed == len(drives),
        "exit_code": 0 if passed == len(drives) else 1,
        "effort": effort.name,
        "seeds": effort.seeds,
        "search": effort.search,
        "drawing_seed": drawing_seed,
        "confidence": CONFIDENCE,
        "rejected_draws": sum(drive.rejected for drive in drives),
        "reference": _share(passed, len(drives)),
        "failures": _failures(drives),
        "trials": _share(sum(caught), len(caught)),
        "faults": [_fault(name, trials) for name in faults],
        "drives": [_drive(drive) for drive in drives],
    }


def applies(trial: Mapping[str, Any]) -> bool:
    """Return True if a fault does something on the drive of a trial."""
    return trial.get("does_not_apply") is None


def _share(happened: int, of: int) -> dict[str, Any]:
    found = proportion(happened, of)
    return {"count": happened, "of": of, "share": found.estimate, "interval": [found.low, found.high]}


def _failures(drives: Sequence[JudgedDrive]) -> list[dict[str, Any]]:
    """Return for each reason how many drives it fails, and the worst of them."""
    found: dict[str, list[tuple[JudgedDrive, GateRow, FailedCheck]]] = {}
    for drive in drives:
        for row in (row for row in drive.rows if not row.passed):
            for check in row.failed or (_otherwise(row),):
                found.setdefault(check.check, []).append((drive, row, check))
    failures = [_failure(reason, entries) for reason, entries in found.items()]
    return sorted(failures, key=lambda failure: (-len(failure["numbers"]), failure["reason"]))


def _otherwise(row: GateRow) -> FailedCheck:
    """Make of a verdict that no check has given what a failed check is shown with."""
    return FailedCheck(row.verdict, None, row.message, "", "")


def _failure(reason: str, entries: Sequence[tuple[JudgedDrive, GateRow, FailedCheck]]) -> dict[str, Any]:
    drive, row, check = min(entries, key=lambda entry: inf if entry[2].margin is None else entry[2].margin)
    worst = {
        "number": drive.number,
        "seed": row.seed,
        "file": str(drive.file),
        "per_unit": DRAWN_KINDS[drive.drive.kind].per_unit(drive.drive),
        **asdict(check),
    }
    return {
        "reason": reason,
        "numbers": sorted({judged.number for judged, _, _ in entries}),
        "worst": {key: value for key, value in worst.items() if key != "check"},
    }


def _fault(name: str, trials: Mapping[tuple[int, str], Mapping[str, Any]]) -> dict[str, Any]:
    own = {number: trial for (number, tried), trial in trials.items() if tried == name}
    tried = {number: trial for number, trial in own.items() if applies(trial)}
    missed = [number for number, trial in tried.items() if not trial["caught"]]
    return {
        "name": name,
        # Of controllers of duty ratios, the machine decides which check must catch a fault.
        "named_check": " or ".join(dict.fromkeys(str(trial["check"]) for trial in own.values())),
        **_share(len(tried) - len(missed), len(tried)),
        "missed_on": missed,
        "does_not_apply_on": {
            f"{number:03d}": trial["does_not_apply"] for number, trial in own.items() if not applies(trial)
        },
        "caught_by_others_on": [number for number in missed if own[number]["also_failing"]],
    }


def _drive(judged: JudgedDrive) -> dict[str, Any]:
    drive = judged.drive
    return {
        "number": judged.number,
        "name": drive.name,
        "file": str(judged.file),
        "rejected_draws": judged.rejected,
        "passed": judged.passed,
        "phases": drive.machine.phases,
        "pole_pairs": drive.machine.pole_pairs,
        "emf_shape": drive.machine.emf_shape,
        "rated_power_w": drive.rating.rated_power_w,
        "supply_voltage_v": drive.inverter.supply_voltage_v,
        "base_speed_rpm": drive.rating.base_speed_rpm,
        "per_unit": DRAWN_KINDS[drive.kind].per_unit(drive),
        "seeds": [row.document() for row in judged.rows],
    }
