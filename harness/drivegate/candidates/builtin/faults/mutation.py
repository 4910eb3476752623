"""A faulty controller: a built-in one with one known fault, and the check that must catch it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from drivegate.candidates.builtin.faults import sizes
from drivegate.candidates.builtin.faults.sizes import Size
from drivegate_models.faults.current import state as faults

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
    """One faulty controller.

    Attributes
    ----------
    name : str
        Its name; as a candidate it is named ``faulty:`` and this.
    kind : str
        What kind of fault it is; the self-test counts by kind.
    sentence : str
        What is wrong with it; the sizes in it stand by name, and `told_on` writes those of a drive.
    check : str
        Identifier of the check that must catch it; empty for a controller that is right.
    base : {"reference", "published"}
        The built-in controller that it is made from.
    factors : tuple of (str, float)
        Constants of `CONTROLLER_STATE` that are multiplied after every reset.
    believes : tuple of (str, float)
        Keys of the nameplate that it takes for a constant, with that constant.
    constants : tuple of (str, Size)
        Constants of `CONTROLLER_STATE` that are others after every reset.
    fault : int
        What its steps do wrong, from `drivegate_models.faults.current.state`.
    size, extent : float or Size
        How large the fault is, in the units that the fault has; many faults have no second size.
    region : tuple of Size
        Speeds from which and up to which the fault shows; empty where it shows at any.
    told : tuple of (str, Size)
        Other sizes in the texts, by name.
    idle_because : callable or None
        Tells why the fault does nothing on a drive, or None where it does something.
    keeps : tuple of str
        What a reset leaves in `CONTROLLER_STATE`, or of the fault's own memory in `FAULTY_STATE`.
    shares : bool
        Whether a new instance begins with what the last one has left of `keeps`.
    shown_by : str
        What a scenario must have to show the fault, with sizes as in `sentence`; empty where loaded steady runs do.
    """

    name: str
    kind: str
    sentence: str
    check: str
    base: Literal["reference", "published"] = "reference"
    factors: tuple[tuple[str, float], ...] = ()
    believes: tuple[tuple[str, float], ...] = ()
    constants: tuple[tuple[str, Size], ...] = ()
    fault: int = faults.NO_FAULT
    size: float | Size = 0.0
    extent: float | Size = 0.0
    region: tuple[Size, ...] = ()
    told: tuple[tuple[str, Size], ...] = ()
    idle_because: Callable[[DriveDocument], str | None] | None = None
    keeps: tuple[str, ...] = ()
    shares: bool = False
    shown_by: str = ""


def number_on(size: float | Size, drive: DriveDocument) -> float:
    """Give a size as the controller takes it."""
    return size.number(drive) if isinstance(size, Size) else size


def told_on(mutation: Mutation, text: str, drive: DriveDocument) -> str:
    """Write a drive's own numbers into a text of a mutation."""
    named = {**_QUANTITIES, "size": mutation.size, "extent": mutation.extent, **dict(mutation.told)}
    named |= dict(zip(("first", "last"), mutation.region, strict=False))
    return text.format_map(
        {name: _Told(size, drive) for name, size in named.items() if isinstance(size, Size)}
    )


def idle_on(mutation: Mutation, drive: DriveDocument) -> str | None:
    """Tell why a fault does nothing on a drive; None where it does something."""
    return None if mutation.idle_because is None else mutation.idle_because(drive)


@dataclass(frozen=True)
class _Told:
    """A size that is computed where a text names it, since some take an oracle."""

    size: Size
    drive: DriveDocument

    def __format__(self, _: str) -> str:
        return self.size.words(self.drive)
