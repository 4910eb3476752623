"""Verification and benchmarking harness for controllers of permanent-magnet brushless drives.

This is the only public package of the distribution. Importing it is cheap: nothing heavy is loaded
until it is used.
"""

from typing import TYPE_CHECKING, Any

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

if TYPE_CHECKING:
    from drivegate.candidates.native.numba_loading import phase_current

__all__ = [
    "CURRENT_REFERENCE",
    "LEG_HIGH",
    "LEG_LOW",
    "LEG_OFF",
    "LEG_PWM",
    "SPEED_REFERENCE",
    "TORQUE_REFERENCE",
    "Command",
    "DutyCommand",
    "DutyNameplate",
    "DutySense",
    "Nameplate",
    "NumbaController",
    "Sense",
    "__version__",
    "conformance_tests",
    "phase_current",
]


def __getattr__(name: str) -> Any:
    """Import what needs numba, when it is requested."""
    if name != "phase_current":
        raise AttributeError(f"module 'drivegate' has no attribute '{name}'")
    from drivegate.candidates.native.numba_loading import phase_current

    return phase_current
