"""The closed loop of this kind of drive."""

from __future__ import annotations

from functools import partial
from typing import Final

from drivegate_models.half_bridge.plant.drive import drifted
from drivegate_models.half_bridge.plant.phases import advance_phases, make_phases, stored_energy, torque_range
from drivegate_models.loop import closed_loop
from drivegate_models.loop.closed_loop import Plant, plant_of
from drivegate_models.loop.loop_kernel import PlantKernels

PLANT: Final[Plant] = plant_of(
    PlantKernels(
        make_phases=make_phases,
        advance_phases=advance_phases,
        stored_energy=stored_energy,
        drifted=drifted,
        torque_range=torque_range,
    )
)
"""Decoupled phases on half-bridge legs."""

run_closed_loop = partial(closed_loop.run_closed_loop, PLANT)
"""Run a controller, already reset, against this plant; see `drivegate_models.loop.closed_loop.run_closed_loop`."""
