"""What is done with one drawn drive, in any process: the usual controller's gate, and trials of faulty ones."""

from __future__ import annotations

import pickle
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any, Final

from drivegate.contracts.catalogue import contract_of
from drivegate.drives.choice import drive_for
from drivegate.output.event_loop import finished
from drivegate.output.progress import Display
from drivegate.studies.selftest.correct_designs import CorrectDesign
from drivegate.studies.selftest.detection import FaultRow
from drivegate.studies.selftest.drawn.gate_row import GateRow, gate_row
from drivegate.studies.selftest.run import SelftestEffort, design_check, try_faults
from drivegate.studies.selftest.seeded_fault import SeededFault, chosen_faults
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import HarnessFault, InputError

_TOLD: Final = 300
"""Letters that are told of the beginning and of the end of an error's text."""


def packed(effort: SelftestEffort, drives: Mapping[int, DriveDocument]) -> bytes:
    """Make what all tasks need ready to be sent to workers."""
    return pickle.dumps((replace(effort, workers=1), dict(drives)), pickle.HIGHEST_PROTOCOL)


def run_gate(package: bytes, number: int) -> list[GateRow]:
    """Check the usual controller of its kind on a drive with every seed."""
    effort = _effort(package, number)
    return [_gate(seed, effort) for seed in range(effort.seeds)]


def run_faults(package: bytes, item: tuple[int, tuple[str, ...]]) -> list[dict[str, Any]]:
    """Put faulty controllers before their checks on a drive, one after another in the same process."""
    number, names = item
    effort = _effort(package, number)
    left = list(chosen_faults(names, drive_for(None, effort.drive)))
    outcomes: list[dict[str, Any]] = []
    while left:
        try:
            for row in try_faults(tuple(left), effort):
                outcomes.append(_outcome(row))
                del left[0]
        except (OSError, MemoryError):
            raise
        except Exception as error:
            outcomes.append(_broken(left.pop(0), error))
    return outcomes


def _outcome(row: FaultRow) -> dict[str, Any]:
    return {
        "fault": row.name,
        "check": row.check,
        "caught": row.caught,
        "runs": row.runs,
        "also_failing": list(row.also_failing),
        "message": "; ".join(row.faults),
        "does_not_apply": row.idle_because,
    }


def _broken(fault: SeededFault, error: Exception) -> dict[str, Any]:
    """Tell of a trial that came to no end; a fault that was not judged is not caught."""
    outcome = {"caught": False, "runs": 0, "also_failing": [], "message": _why(error), "does_not_apply": None}
    return {"fault": fault.name, "check": fault.check} | outcome


def _gate(seed: int, effort: SelftestEffort) -> GateRow:
    """Check the usual controller; a drive that it cannot be judged on is an outcome too, and ends nothing else."""
    try:
        usual = contract_of(drive_for(None, effort.drive)).usual_candidate
        return gate_row(finished(design_check(CorrectDesign(usual), seed, effort), Display()))
    except (OSError, MemoryError):
        raise
    except Exception as error:
        verdict = "refused" if isinstance(error, InputError) else "harness fault"
        return GateRow(seed, verdict, passed=False, message=_why(error))


def _why(error: Exception) -> str:
    """Tell an error on one line, of a long text its beginning and its end."""
    text = str(error) if isinstance(error, (InputError, HarnessFault)) else f"{type(error).__name__}: {error}"
    words = " ".join(text.split())
    return words if len(words) <= 2 * _TOLD else f"{words[:_TOLD]} … {words[-_TOLD:]}"


def _effort(package: bytes, number: int) -> SelftestEffort:
    effort, drives = _unpacked(package)
    return replace(effort, drive=drives[number])


@lru_cache(maxsize=1)
def _unpacked(package: bytes) -> tuple[SelftestEffort, dict[int, DriveDocument]]:
    effort, drives = pickle.loads(package)
    return effort, drives
