"""The closed loop of this kind of drive."""

from __future__ import annotations

from drivegate_models.half_bridge.plant.drive import drifted
from drivegate_models.half_bridge.plant.phases import advance_phases, make_phases, stored_energy, torque_range
from drivegate_models.loop.closed_loop import PlantKernels, closed_loop_of

run_closed_loop = closed_loop_of(
    PlantKernels(
        make_phases=make_phases,
        advance_phases=advance_phases,
        stored_energy=stored_energy,
        drifted=drifted,
        torque_range=torque_range,
    )
)
"""Run a controller, already reset, against the plant; see `drivegate_models.loop.closed_loop.closed_loop_of`."""
