"""What the engine tells while it works; one loop follows these, `drivegate.output.event_loop`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from drivegate.results.result import CheckResult
from drivegate_cases.drive.drive_document import DriveDocument


@dataclass(frozen=True)
class CheckStarted:
    """A candidate's check begins."""

    candidate_name: str
    """The candidate."""
    planned_runs: int
    """Number of runs at most."""
    drive: DriveDocument | None = None
    """The drive that it is judged on; None of a part of a comparison."""


@dataclass(frozen=True)
class Compiling:
    """The kernels are being compiled, which is done once for each installation and takes a minute."""


@dataclass(frozen=True)
class RunDone:
    """Some runs have been made."""

    done: int
    """Runs accounted for so far."""
    planned: int
    """Number of runs at most."""
    scenario: str
    """Name of the last scenario."""
    worst: str
    """Check with the least margin so far, with that margin; empty before there is one."""


@dataclass(frozen=True)
class Shrinking:
    """A failure has been made as simple as it could be had."""

    check: str
    """Identifier of the check that fails; empty before the first one is done."""
    done: int
    """Failures that are done with."""
    planned: int
    """Number of failures."""


@dataclass(frozen=True)
class WitnessesHeard:
    """Known good controllers have been run where a check fails."""

    check: str
    """Identifier of the check."""
    done: int
    """Failures that are done with."""
    planned: int
    """Number of failures."""


@dataclass(frozen=True)
class CheckFinished:
    """A candidate's check has ended."""

    result: CheckResult
    """The result."""


Event: TypeAlias = CheckStarted | Compiling | RunDone | Shrinking | WitnessesHeard | CheckFinished
