"""The face that every kind of candidate shows to the closed loop, whatever language it is written in."""

from typing import Protocol

from drivegate.candidates.fault import Fault
from drivegate_models.contract.outer_loop.signals import Nameplate


class Controller(Protocol):
    """One instance of a candidate, ready to be stepped by address from compiled code."""

    @property
    def step_address(self) -> int:
        """Address of a C function of the type of `drivegate_step`."""

    @property
    def state_address(self) -> int:
        """Address to pass to that function as its state; 0 where the state is kept elsewhere."""

    @property
    def fault(self) -> Fault | None:
        """What ended the last run, if the controller itself knows."""

    def reset(self, nameplate: Nameplate) -> None:
        """Prepare for a run."""
