"""What the comparison of two candidates step by step came to, whatever their contract."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Generic, TypeVar

from drivegate.candidates.fault import Fault

FIRST: Final = "first"
SECOND: Final = "second"
FoundT = TypeVar("FoundT")


@dataclass(frozen=True)
class StepComparison(Generic[FoundT]):
    """What the comparison of two candidates came to."""

    steps: int
    """Number of steps at which both answered alike."""
    difference: FoundT | None = None
    """The first difference, as the contract has it."""
    fault: Fault | None = None
    """The fault of one of them."""
    faulted: str | None = None
    """Which one."""
