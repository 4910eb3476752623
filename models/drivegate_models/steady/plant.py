"""What steady states need of a plant, found by the type of the drive's constants.

Compiled callers are compiled for one kind of drive at a time, and see only its functions.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any, Final, TypeAlias

import numba
from numba.extending import overload

if TYPE_CHECKING:
    from drivegate_models.half_bridge.plant.drive import Drive
    from drivegate_models.half_bridge.plant.phases import Phases
    from drivegate_models.star.plant.drive import StarDrive
    from drivegate_models.star.plant.phases import StarPhases

AnyDrive: TypeAlias = "Drive | StarDrive"
"""Constants of a drive of any kind."""
AnyPhases: TypeAlias = "Phases | StarPhases"
"""State of a drive of any kind."""


def _function(kind: type, name: str) -> Any:
    """Return a function of the plant of a kind of drive, whose package has them in `plant.phases` and `periodic`."""
    package = kind.__module__.partition(".plant.")[0]
    modules = (import_module(f"{package}.{module}") for module in ("plant.phases", "periodic"))
    return next(vars(module)[name] for module in modules if name in vars(module))


def _of_any_drive(name: str) -> Any:
    """Return a function that calls its namesake of the plant of its first argument, compiled or not."""

    def call(drive: Any, *arguments: Any) -> Any:
        return _function(type(drive), name)(drive, *arguments)

    def chosen(drive: Any, *arguments: Any) -> Any:
        del arguments
        if not isinstance(drive, numba.types.NamedTuple):
            return None
        function = _function(drive.instance_class, name)

        def of_plant(drive: Any, *arguments: Any) -> Any:
            return function(drive, *arguments)

        return of_plant

    call.__name__ = call.__qualname__ = name
    overload(call, jit_options={"forceinline": True}, strict=False)(chosen)
    return call


def make_phases(drive: AnyDrive, longest_advance: float = 0.0) -> Any:
    """Return phases at rest, as `make_phases` of the drive's plant does.

    Parameters
    ----------
    drive : AnyDrive
        The drive.
    longest_advance : float
        Longest advance whose segments are to be kept (s); 0 keeps none.

    Returns
    -------
    Phases or StarPhases
        With room for every segment that the drive can produce in such an advance.
    """
    return _function(type(drive), "make_phases")(drive, longest_advance)


advance_phases: Final = _of_any_drive("advance_phases")
"""Advance all phases exactly."""
periodic_start: Final = _of_any_drive("periodic_start")
"""Find the periodic state and leave it, at the first phase's window start."""
torque_period: Final = _of_any_drive("torque_period")
"""Return the period of the torque in a periodic state (s)."""
averaged_cycles: Final = _of_any_drive("averaged_cycles")
"""Return the number of electrical cycles that a search averages where no periodic state exists."""
least_conceivable: Final = _of_any_drive("least_conceivable")
"""Return a current reference below which the drive cannot give a torque (A)."""
