"""The interface of every kind of candidate to the closed loop, and a controller whose step is compiled code."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from drivegate.candidates.fault import Fault

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from drivegate_cases.drive.drive_document import DriveDocument


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

    def reset(self, nameplate: Any) -> None:
        """Prepare for a run, with the nameplate of its contract."""


@runtime_checkable
class KnowsDrive(Protocol):
    """A controller that is included, and follows from more of its drive than a nameplate has."""

    def show_drive(self, drive: DriveDocument) -> None:
        """Take the drive that the next runs are on."""


def show_drive(controller: object, drive: DriveDocument) -> None:
    """Show a controller its whole drive before a reset, where it takes that; no candidate of a user does."""
    if isinstance(controller, KnowsDrive):
        controller.show_drive(drive)


class CompiledController:
    """The step and the state of one instance; a subclass resets the state.

    `step_address`, `state_address`: addresses of the compiled step and of the state; valid as long as this object
    lives.
    """

    def __init__(self, step: Any, state: NDArray[Any]) -> None:
        self._step, self._state = step, state
        self.step_address: int = step.address
        self.state_address: int = state.ctypes.data

    @property
    def fault(self) -> Fault | None:
        """What ended the last run; None where the compiled code answers every step."""
        return None
