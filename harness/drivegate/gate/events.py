"""What the engine reports while it works; one loop follows these, `drivegate.output.event_loop`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, TypeAlias

if TYPE_CHECKING:
    from drivegate.results.document import ResultDocument
    from drivegate_cases.drive.drive_document import DriveDocument

DriveFrom: TypeAlias = Literal["user", "manifest", "default"]
"""Who named a drive."""


@dataclass(frozen=True)
class CheckPlan:
    """How a candidate is checked."""

    drive: DriveDocument
    drive_from: DriveFrom
    effort: str
    """``quick``, ``default`` or ``nightly``."""
    seed: int
    workers: int
    isolation: tuple[str, ...] | None = None
    """The layers that isolate the candidate's processes; None for a built-in controller, which has none."""


@dataclass(frozen=True)
class CheckStarted:
    candidate_name: str
    planned_runs: int | None
    """Number of runs at most; None of a check, whose runs are planned once its drive is known to be within reach."""
    plan: CheckPlan | None = None
    """How it is checked; None of a part of a comparison."""


@dataclass(frozen=True)
class Compiling:
    """The kernels are being compiled, which is done once for each installation and takes a minute."""

    kinds: tuple[str, ...]


@dataclass(frozen=True)
class Running:
    """The first run of a check begins."""

    planned_runs: int
    """Number of runs at most."""


@dataclass(frozen=True)
class RunDone:
    done: int
    planned: int
    """Number of runs at most."""
    scenario: str
    """Name of the last scenario."""
    worst: str
    """Check with the least margin so far, with that margin; empty before there is one."""


@dataclass(frozen=True)
class _FailureDone:
    check: str
    """Identifier of the check that fails; empty before the first one is done."""
    done: int
    planned: int


class Shrinking(_FailureDone):
    """A failure has been made as simple as it could be had."""


class WitnessesHeard(_FailureDone):
    """Known good controllers have been run where a check fails."""


@dataclass(frozen=True)
class Recording:
    """What the report shows is recorded: runs, and how the candidate behaves."""


@dataclass(frozen=True)
class CheckFinished:
    result: ResultDocument


Event: TypeAlias = (
    CheckStarted | Compiling | Running | RunDone | Shrinking | WitnessesHeard | Recording | CheckFinished
)
