"""What a run in closed loop is made of: the plant, its conditions and observations, and the controller's addresses."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.loop import observation
from drivegate_models.loop.schedule import Schedule
from drivegate_models.loop.sensing.sensors import Sensors
from drivegate_models.machine.load import Load


class SteppedController(NamedTuple):
    """A controller that has been reset, with what its steps fill; valid in one process alone."""

    step_address: int
    """Address of its step function."""
    state_address: int
    """Address of its state."""
    progress: NDArray[np.int64] | None = None
    """Receives the number of steps begun, shape (1,)."""
    kept: NDArray[Any] | None = None
    """Receives the commands of the first n steps, shape (n,) of the contract's command. A loop of duty ratios needs
    space for all steps, including those before the run."""


@dataclass(frozen=True, kw_only=True)
class LoopInputs:
    """What a run is made of, whatever the contract of its controller."""

    drive: Any
    """Constants of machine and inverter, a named tuple of the plant's own type."""
    load: Load
    """Torque and inertia at the shaft."""
    schedule: Schedule
    """External conditions over time. For duty ratios the supply is half of the link voltage, and the speed is the
    reference."""
    control_period: float
    """Time between two steps of the controller (s)."""
    duration: float
    """Length of the run (s), rounded to control periods."""
    initial_speed: float = 0.0
    """Speed of the shaft at the start (rad/s)."""
    initial_angle: float = 0.0
    """Electrical angle of the rotor at the start, from the first phase's axis to the d axis (rad)."""
    clock_start: float = 0.0
    """Time in the controller's first Sense (s)."""


@dataclass(frozen=True, kw_only=True)
class CurrentLoopInputs(LoopInputs):
    """A run of a controller that commands a current reference and an advance angle."""

    base_speed: float
    """Speed below which no advance is allowed (rad/s); steps below it are only observed."""
    sensors: Sensors | None = None
    """Sensors between plant and controller, made for this run; ideal by default."""
    windows: Sequence[tuple[float, float]] = ()
    """Start and end of each observed window (s)."""
    power_window: float = 0.0
    """Averaging time of the controller's estimate of its input power (s); 0 for the last period alone."""
    mean_time: float = observation.MEAN_TIME
    """Averaging time of the current sum, whose extreme means are observed in each window (s)."""
    trace_every: int = 0
    """Record every n-th control period in the trace; 0 for none."""
