"""A faulty controller: a built-in one with one known fault, and the check that must catch it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from drivegate_lab.candidates.faults import sizes
from drivegate_lab.candidates.faults.seeded_fault import FaultOnDrive, SeededFault
from drivegate_lab.candidates.faults.sizes import Size
from drivegate_lab.kernels.faults.current import state as faults

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument

_QUANTITIES: Final = {
    "k1": sizes.K1,
    "angle_tolerance": sizes.ANGLE_TOLERANCE,
    "settling": sizes.SETTLING,
    "base": sizes.BASE,
    "highest": sizes.HIGHEST,
    "overspeed": sizes.OVERSPEED,
    "current_limit": sizes.CURRENT_LIMIT,
    "decision_period": sizes.DECISION_PERIOD,
}


@dataclass(frozen=True)
class Mutation(SeededFault):
    """One faulty controller of the contract `current`; the sizes in its texts stand by name."""

    believes: tuple[tuple[str, float], ...] = ()
    """Keys of the nameplate that it takes for a constant, with that constant."""
    constants: tuple[tuple[str, Size], ...] = ()
    """Constants of `CONTROLLER_STATE` that are others after every reset."""
    fault: int = faults.NO_FAULT
    """What its steps do wrong, from `drivegate_lab.kernels.faults.current.state`."""
    size: float | Size = 0.0
    extent: float | Size = 0.0
    """How large the fault is, in the units that the fault has; many faults have no second size."""
    region: tuple[Size, ...] = ()
    """Speeds from which and up to which the fault shows; empty where it shows at any."""
    numbers: tuple[tuple[str, Size], ...] = ()
    """Other sizes in the texts, by name."""
    idle_because: Callable[[DriveDocument], str | None] | None = None
    """State why the fault does nothing on a drive, or None where it does something."""
    shares: bool = False
    """Whether a new instance begins with what the last one has left of `keeps`."""
    shown_by: str = ""
    """What a scenario must have to show the fault; empty where loaded steady runs do."""

    def on(self, drive: DriveDocument) -> FaultOnDrive:
        """Return what the fault is on a drive, with the drive's own numbers in the texts."""
        named = {**_QUANTITIES, "size": self.size, "extent": self.extent, **dict(self.numbers)}
        named |= dict(zip(("first", "last"), self.region, strict=False))
        written = {name: _Written(size, drive) for name, size in named.items() if isinstance(size, Size)}
        return FaultOnDrive(
            self.check,
            self.sentence.format_map(written),
            self.shown_by.format_map(written),
            None if self.idle_because is None else self.idle_because(drive),
        )


def of_kind(kind: str, *mutations: Mutation) -> tuple[Mutation, ...]:
    """Return the kind of several mutations."""
    return tuple(replace(mutation, kind=kind) for mutation in mutations)


def number_on(size: float | Size, drive: DriveDocument) -> float:
    """Return a size as the controller takes it."""
    return size.number(drive) if isinstance(size, Size) else size


@dataclass(frozen=True)
class _Written:
    """A size that is computed where a text names it, since some take an oracle."""

    size: Size
    drive: DriveDocument

    def __format__(self, _: str) -> str:
        return self.size.words(self.drive)
