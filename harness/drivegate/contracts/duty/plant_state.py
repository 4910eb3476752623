"""The plant's own state at one step of a recorded run, which sensors may show otherwise."""

from __future__ import annotations

from math import degrees
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.containment.contained_controller import CommandPlayer
from drivegate.contracts.duty.plant_run import duty_run
from drivegate.contracts.duty.run import PrepareDutyLoop
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.machine.rotor_frame import phase_currents
from drivegate_models.units import RPM


def plant_state(
    prepare: PrepareDutyLoop, scenario: Scenario, commands: NDArray[Any], step: int
) -> dict[str, Any]:
    """Find the plant at the start of a step: speed, angle and link, and currents at the end of the step before."""
    run = duty_run(prepare, scenario, CommandPlayer(commands))
    speed, angle, link = (float(run.column(name)[step]) for name in ("speed", "angle", "link"))
    direct, quadrature = (
        float(run.column(name)[step - 1]) if step else 0.0 for name in ("direct", "quadrature")
    )
    currents = phase_currents(np.array([direct]), np.array([quadrature]), np.array([angle]))[0]
    return {
        "speed": speed,
        "speed_rpm": speed * RPM,
        "electrical_angle_deg": degrees(angle),
        "phase_currents": currents.tolist(),
        "direct_current": direct,
        "quadrature_current": quadrature,
        "link_voltage": link,
    }
