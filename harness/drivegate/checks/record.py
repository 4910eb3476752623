"""What checks of any contract see of one finished run."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.step_costs import NO_COSTS, StepCosts
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.steady.plant import AnyDrive


class Run(Protocol):
    """The observation of a run, whatever its contract."""

    @property
    def digest(self) -> int:
        """Digest of all commands, bit for bit."""


@dataclass(frozen=True)
class Record:
    """A finished run with what belongs to it."""

    scenario: Scenario
    """The scenario."""
    run: Run
    """The observation; each contract has its own type."""
    declaration: Declaration
    """What the candidate declares about itself."""
    repeated_digests: tuple[int, ...] = ()
    """Digests of further runs of the same scenario; empty where it ran once."""
    costs: StepCosts = NO_COSTS
    """Greatest costs of a step on an emulated target."""
    allowed_costs: StepCosts = NO_COSTS
    """What the candidate's manifest allows of them."""
    parting: str = ""
    """Where one of these runs first differs from this one, in words; empty where none does."""

    @cached_property
    def drive(self) -> AnyDrive:
        """The plant that the run was made on."""
        return self.scenario.drive.plant(self.scenario.scales)


class NotRun(Exception):
    """Raised where something is read that only the run shows."""


class Unseen:
    """Stand-in for what a run shows: reading anything but what is already known raises `NotRun`."""

    def __init__(self, **known: Any) -> None:
        self.__dict__.update(known)

    def __getattr__(self, name: str) -> Any:
        raise NotRun(name)
