"""What is done with one drawn drive, in any process: the usual controller's gate, and trials of faulty ones."""

from __future__ import annotations

import pickle
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from typing import Any, Final

from drivegate.contracts.catalogue import contract_of
from drivegate.drives.kinds import drive_for
from drivegate.output.event_loop import finished
from drivegate.output.progress import Display
from drivegate.results.document import CheckSection, ResultDocument
from drivegate.scenarios.facts import facts_in_short
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_lab.candidates.faults.seeded_fault import SeededFault
from drivegate_lab.selftest.matrix import FaultRow
from drivegate_lab.selftest.run import SelftestEffort, design_check, try_faults
from drivegate_lab.selftest.subjects import CorrectDesign, chosen_faults
from drivegate_models.errors import HarnessFault, InputError

_TOLD: Final = 300
"""Letters that are shown of the beginning and of the end of an error's text."""


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
    drive = drive_for(None, effort.drive)
    left = list(chosen_faults(names, drive))
    outcomes: list[dict[str, Any]] = []
    while left:
        try:
            for row in try_faults(tuple(left), effort):
                outcomes.append(_outcome(row))
                del left[0]
        except (OSError, MemoryError):
            raise
        except Exception as error:
            outcomes.append(_broken(left.pop(0), drive, error))
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


def _broken(fault: SeededFault, drive: DriveDocument, error: Exception) -> dict[str, Any]:
    """Describe a trial that came to no end; a fault that was not judged is not caught."""
    outcome = {"caught": False, "runs": 0, "also_failing": [], "message": _why(error), "does_not_apply": None}
    return {"fault": fault.name, "check": fault.check_on(drive)} | outcome


def _gate(seed: int, effort: SelftestEffort) -> GateRow:
    """Check the usual controller; a drive that it cannot be judged on is an outcome too, and ends nothing else."""
    try:
        usual = contract_of(drive_for(None, effort.drive)).usual_candidate
        return _gate_row(finished(design_check(CorrectDesign(usual), seed, effort), Display()))
    except (OSError, MemoryError):
        raise
    except Exception as error:
        verdict = "refused" if isinstance(error, InputError) else "harness fault"
        return GateRow(seed, verdict, passed=False, message=_why(error))


def _why(error: Exception) -> str:
    """State an error on one line, of a long text its beginning and its end."""
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


@dataclass(frozen=True)
class FailedCheck:
    """A required check that failed."""

    check: str
    """Its identifier."""
    margin: float | None
    """Its least margin."""
    measured: str
    """What was measured in the simplest counterexample."""
    limit: str
    """The limit."""
    facts: str
    """The facts of the simplest counterexample."""
    contested: bool = False
    """Whether no known good controller meets it either, so that it does not count against a candidate."""


@dataclass(frozen=True)
class GateRow:
    """The verdict on a candidate with one seed."""

    seed: int
    """Seed of the search."""
    verdict: str
    """As in `drivegate.results.document.ResultDocument`, or ``refused`` where the drive cannot be judged on."""
    passed: bool
    """Whether the candidate passes."""
    runs: int = 0
    """Number of runs made."""
    failed: tuple[FailedCheck, ...] = ()
    """The required checks that failed."""
    message: str = ""
    """What ended the check otherwise, in one sentence; empty where nothing did."""

    def document(self) -> dict[str, Any]:
        """Write the row as plain data."""
        return asdict(self)


def _gate_row(result: ResultDocument) -> GateRow:
    """Take from a whole check what is kept of it."""
    return GateRow(
        seed=result.seed,
        verdict=result.verdict,
        passed=result.exit_code == 0 and result.verdict != "contested",
        runs=result.runs,
        failed=tuple(_failed(result.checks)),
        message=result.faults[0].message if result.faults else "",
    )


def row_from(document: Mapping[str, Any]) -> GateRow:
    """Read a row that was kept."""
    return GateRow(**{**document, "failed": tuple(FailedCheck(**check) for check in document["failed"])})


def _failed(outcomes: Sequence[CheckSection]) -> list[FailedCheck]:
    return [
        FailedCheck(
            check=outcome.id,
            margin=outcome.margin,
            measured=outcome.measured if outcome.found is None else outcome.found.measured,
            limit=outcome.limit,
            contested=outcome.verdict == "contested",
            facts="" if outcome.counterexample is None else facts_in_short(outcome.counterexample),
        )
        for outcome in outcomes
        if outcome.level == "required" and outcome.verdict in ("fail", "contested")
    ]
