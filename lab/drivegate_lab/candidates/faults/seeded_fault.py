"""What the faulty controllers of both contracts have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument

NEEDS_ANGLE: Final = "its controller needs a position sensor"
"""Why a fault does nothing on a drive without one."""


@dataclass(frozen=True)
class FaultOnDrive:
    """What a fault is on one drive."""

    check: str
    """Identifier of the check that must catch it there."""
    sentence: str
    """What is wrong with the controller, with the drive's numbers."""
    shown_by: str
    """What a scenario must have to show it; empty where loaded steady runs do."""
    idle_because: str | None
    """Why it does nothing on the drive; None where it does something."""


@dataclass(frozen=True)
class SeededFault(ABC):
    """A built-in controller with one known fault."""

    name: str
    """Its name; as a candidate it is named ``faulty:`` and this."""
    sentence: str
    """What is wrong with it."""
    check: str = ""
    """Identifier of the check that must catch it; empty for a controller that is right."""
    base: str = "reference"
    """Name of the controller without the fault."""
    kind: str = ""
    """What kind of fault it is; the self-test counts by kind."""
    factors: tuple[tuple[str, float], ...] = ()
    """Constants of the controller's state that are multiplied after every reset."""
    keeps: tuple[str, ...] = ()
    """What a reset leaves as it is in the controller's state, or in the fault's own."""

    def check_on(self, _drive: DriveDocument) -> str:
        """Return the identifier of the check that must catch it on a drive."""
        return self.check

    @abstractmethod
    def on(self, drive: DriveDocument) -> FaultOnDrive:
        """Return what the fault is on a drive; some need the compiled oracle for it."""

    def scale(self, controller: Any) -> None:
        """Multiply constants in the record of a controller's state, just reset."""
        for name, factor in self.factors:
            # Not in place: a count of periods stays a whole number.
            controller[name] = controller[name] * factor

    def keep(self, before: Any, state: Any) -> None:
        """Copy what a reset is not to change from the state before it to the one after it."""
        for name in self.keeps:
            if name in state.dtype.names:
                state[name] = before[name]
