"""What a run of a controller of duty ratios is made of."""

from __future__ import annotations

from dataclasses import dataclass

from drivegate_models.loop.loop_inputs import LoopInputs
from drivegate_models.loop.schedule import Course
from drivegate_models.pm_ac.failure import Failure
from drivegate_models.pm_ac.mean_voltages import MeanVoltages
from drivegate_models.pm_ac.sensing import DutySensors
from drivegate_models.pm_ac.turning import Turning
from drivegate_models.pm_ac.winding import Winding


@dataclass(frozen=True, kw_only=True)
class DutyLoopInputs(LoopInputs):
    """A run of a controller that commands duty ratios.

    In control periods before the run, and after each restart, all legs are off, and the controller is stepped with
    `enable` 0.
    """

    sensors: DutySensors | None = None
    """Sensors between plant and controller; ideal by default."""
    resting: int = 0
    """Number of control periods before the run at standstill, which come first."""
    waiting: int = 0
    """Number of those at the initial speed, and of those that begin with each restart."""
    torque_reference: Course | None = None
    """Torque reference, instead of the schedule's speed (N m)."""
    failure: Failure | None = None
    """A failure during the run; none by default."""
    released: int | None = None
    """Number of the control period from which a held shaft turns freely; by default it is held throughout."""
    turning: Turning | None = None
    """Turns of the shaft before the run, in which the controller is stepped; none by default."""
    winding: Winding | None = None
    """The thermal node of the windings; their resistance is constant by default."""
    mean_voltages: MeanVoltages | None = None
    """Sensor of the means of the terminals' voltages; none by default."""
