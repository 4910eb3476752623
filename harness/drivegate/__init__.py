"""Verification and benchmarking harness for controllers of permanent-magnet brushless drives.

This is the only public package of the distribution. Importing it is cheap: nothing heavy is loaded
until it is used.
"""

import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

# Of `python -m drivegate`, Python searches the present folder first, which may hold a stranger's candidate. The first
# argument is -m until the module has been found; where another one is, its own package imports this one.
if (
    sys.argv[:1] == ["-m"]
    and any(word.removeprefix("-m").partition(".")[0] == __name__ for word in sys.orig_argv)
    and not sys.flags.safe_path
):
    del sys.path[0]

from drivegate.candidates.native.numba_controller import NumbaController
from drivegate.testing.conformance import conformance_tests
from drivegate.version import __version__
from drivegate_models.contract.current.signals import Command, Nameplate, Sense
from drivegate_models.contract.duty.signals import (
    CURRENT_REFERENCE,
    LEG_HIGH,
    LEG_LOW,
    LEG_OFF,
    LEG_PWM,
    SPEED_REFERENCE,
    TORQUE_REFERENCE,
    DutyCommand,
    DutyNameplate,
    DutySense,
)
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.native.numba_loading import phase_current
    from drivegate.interactive.functions import check, compare, load_drive, replay, simulate
    from drivegate.interactive.results import CheckResult, Comparison, Replayed, Simulation

__all__ = [
    "CURRENT_REFERENCE",
    "LEG_HIGH",
    "LEG_LOW",
    "LEG_OFF",
    "LEG_PWM",
    "SPEED_REFERENCE",
    "TORQUE_REFERENCE",
    "CheckResult",
    "Command",
    "Comparison",
    "DutyCommand",
    "DutyNameplate",
    "DutySense",
    "InputError",
    "Nameplate",
    "NumbaController",
    "Replayed",
    "Sense",
    "Simulation",
    "__version__",
    "check",
    "compare",
    "conformance_tests",
    "load_drive",
    "phase_current",
    "replay",
    "simulate",
]

_FUNCTIONS: Final = "drivegate.interactive.functions"
_LATE: Final = {
    "phase_current": "drivegate.candidates.native.numba_loading",
    **dict.fromkeys(("check", "compare", "load_drive", "replay", "simulate"), _FUNCTIONS),
    **dict.fromkeys(("CheckResult", "Comparison", "Replayed", "Simulation"), "drivegate.interactive.results"),
}
"""Modules of what is imported when it is requested."""


def __getattr__(name: str) -> Any:
    """Import what needs more than this package, when it is requested."""
    if name not in _LATE:
        raise AttributeError(f"module 'drivegate' has no attribute '{name}'")
    return getattr(import_module(_LATE[name]), name)
