"""The closed loop of drives with one half-bridge leg per independent phase."""

from __future__ import annotations

from typing import Final

from drivegate_models.half_bridge.plant.drive import drifted
from drivegate_models.half_bridge.plant.phases import advance_phases, make_phases
from drivegate_models.loop import closed_loop
from drivegate_models.loop.closed_loop import ClosedLoopRun, PreparedLoop
from drivegate_models.loop.loop_inputs import CurrentLoopInputs, SteppedController
from drivegate_models.loop.loop_kernel import PlantKernels
from drivegate_models.loop.restarting import Restarts
from drivegate_models.machine.ledger import stored_energy
from drivegate_models.machine.torque import torque_range

PLANT: Final = PlantKernels(
    make_phases=make_phases,
    advance_phases=advance_phases,
    stored_energy=stored_energy,
    drifted=drifted,
    torque_range=torque_range,
)
"""Decoupled phases on half-bridge legs."""


def prepared_loop(
    inputs: CurrentLoopInputs, controller: SteppedController, restarts: Restarts | None = None
) -> PreparedLoop[ClosedLoopRun]:
    """Prepare a run against this plant; see `drivegate_models.loop.closed_loop.prepared_loop`."""
    return closed_loop.prepared_loop(PLANT, inputs, controller, restarts)
