"""The plant functions for steady states, selected by the type of the drive's constants.

Compiled callers are compiled for one kind of drive at a time, with its functions only.
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
AnyPhases: TypeAlias = "Phases | StarPhases"


def _function(kind: type, name: str) -> Any:
    """Return a function of a kind of drive by name, from the modules `plant.phases` and `periodic` of its package."""
    package = kind.__module__.partition(".plant.")[0]
    modules = (import_module(f"{package}.{module}") for module in ("plant.phases", "periodic"))
    return next(vars(module)[name] for module in modules if name in vars(module))


def _of_any_drive(name: str) -> Any:
    """Return a function that calls the function of the same name for its first argument's plant, compiled or not."""

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
    """Return phases at rest, by the function `make_phases` of the drive's plant.

    `longest_advance`: maximum length of an advance whose segments are stored (s), with space for every segment that the
    drive can produce in that time; 0 to store none.
    """
    return _function(type(drive), "make_phases")(drive, longest_advance)


advance_phases: Final = _of_any_drive("advance_phases")
periodic_start: Final = _of_any_drive("periodic_start")
"""Find the periodic state, and store it at the first phase's window start."""
torque_period: Final = _of_any_drive("torque_period")
"""Return the period of the torque in a periodic state (s)."""
averaged_cycles: Final = _of_any_drive("averaged_cycles")
"""Return the number of electrical cycles that a search averages if there is no periodic state."""
least_conceivable: Final = _of_any_drive("least_conceivable")
"""Return a current reference below which the drive cannot produce a torque (A)."""
