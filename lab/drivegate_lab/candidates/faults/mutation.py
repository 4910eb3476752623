"""A faulty controller: a built-in one with one known fault, and the check that must catch it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final, Literal

from drivegate_lab.candidates.faults import sizes
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
class Mutation:
    """One faulty controller."""

    name: str
    """Its name; as a candidate it is named ``faulty:`` and this."""
    sentence: str
    """What is wrong with it; the sizes in it stand by name, and `text_on` writes those of a drive."""
    check: str = ""
    """Identifier of the check that must catch it; empty for a controller that is right."""
    base: Literal["reference", "published"] = "reference"
    """The built-in controller that it is made from."""
    kind: str = ""
    """What kind of fault it is; the self-test counts by kind."""
    factors: tuple[tuple[str, float], ...] = ()
    """Constants of `CONTROLLER_STATE` that are multiplied after every reset."""
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
    keeps: tuple[str, ...] = ()
    """What a reset leaves in `CONTROLLER_STATE`, or of the fault's own memory in `FAULTY_STATE`."""
    shares: bool = False
    """Whether a new instance begins with what the last one has left of `keeps`."""
    shown_by: str = ""
    """What a scenario must have to show the fault, with sizes as in `sentence`; empty where loaded steady
    runs do."""


def of_kind(kind: str, *mutations: Mutation) -> tuple[Mutation, ...]:
    """Return the kind of several mutations."""
    return tuple(replace(mutation, kind=kind) for mutation in mutations)


def number_on(size: float | Size, drive: DriveDocument) -> float:
    """Return a size as the controller takes it."""
    return size.number(drive) if isinstance(size, Size) else size


def text_on(mutation: Mutation, text: str, drive: DriveDocument) -> str:
    """Write a drive's own numbers into a text of a mutation."""
    named = {**_QUANTITIES, "size": mutation.size, "extent": mutation.extent, **dict(mutation.numbers)}
    named |= dict(zip(("first", "last"), mutation.region, strict=False))
    return text.format_map(
        {name: _Told(size, drive) for name, size in named.items() if isinstance(size, Size)}
    )


def idle_on(mutation: Mutation, drive: DriveDocument) -> str | None:
    """State why a fault does nothing on a drive; None where it does something."""
    return None if mutation.idle_because is None else mutation.idle_because(drive)


@dataclass(frozen=True)
class _Told:
    """A size that is computed where a text names it, since some take an oracle."""

    size: Size
    drive: DriveDocument

    def __format__(self, _: str) -> str:
        return self.size.words(self.drive)
