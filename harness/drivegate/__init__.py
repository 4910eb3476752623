"""Verification and benchmarking harness for controllers of permanent-magnet brushless drives.

This is the only public package of the distribution. Importing it is cheap: nothing heavy is loaded
until it is used.
"""

from typing import TYPE_CHECKING, Any

from drivegate.conformance import conformance_tests
from drivegate.native.numba_controller import NumbaController
from drivegate_models.signals import Command, Nameplate, Sense

if TYPE_CHECKING:
    from drivegate.native.numba_loading import phase_current

__all__ = [
    "Command",
    "Nameplate",
    "NumbaController",
    "Sense",
    "__version__",
    "conformance_tests",
    "phase_current",
]

__version__ = "0.1.0"


def __getattr__(name: str) -> Any:
    """Import what needs numba, when it is asked for."""
    if name != "phase_current":
        raise AttributeError(f"module 'drivegate' has no attribute '{name}'")
    from drivegate.native.numba_loading import phase_current

    return phase_current
