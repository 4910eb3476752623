"""One run of a controller through given signals: its advance angles, or its fault."""

from __future__ import annotations

from contextlib import nullcontext
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import CandidateFault, refused_command
from drivegate_models.contract.outer_loop.signals import Nameplate, Sense
from drivegate_models.loop.exchange import COMPLETED, NOT_FINITE, STOPPED
from drivegate_models.loop.scripted_steps import ScriptedSteps

if TYPE_CHECKING:
    from drivegate.containment.shared_progress import SharedProgress


def prepared_steps(
    controller: Controller,
    nameplate: Nameplate,
    signals: NDArray[np.float64],
    progress: SharedProgress | None = None,
) -> ScriptedSteps:
    """Reset a controller and make ready to step it."""
    controller.reset(nameplate)
    return ScriptedSteps(
        signals,
        step_address=controller.step_address,
        state_address=controller.state_address,
        phases=nameplate.phases,
        control_period=nameplate.control_period,
        sense=progress.sense if progress is not None else None,
        sensed_currents=progress.phase_currents if progress is not None else None,
        progress=progress.steps if progress is not None else None,
    )


def advance(steps: ScriptedSteps, controller: Controller, begin: int = 0, end: int | None = None) -> None:
    """Make steps, which have to follow on those made before."""
    status, step = steps.advance(begin, end)
    if status == COMPLETED:
        return
    if status == STOPPED and controller.fault is not None:
        raise CandidateFault(controller.fault)
    sense = _last_sense(steps)
    finite = status != NOT_FINITE
    raise CandidateFault(refused_command(steps.command[0], finite=finite, step=step, sense=sense))


def scripted_angles(
    controller: Controller,
    nameplate: Nameplate,
    signals: NDArray[np.float64],
    progress: SharedProgress | None = None,
) -> NDArray[np.float64]:
    """Reset a controller, step it through given signals and collect its advance angles."""
    with progress.run() if progress is not None else nullcontext():
        steps = prepared_steps(controller, nameplate, signals, progress)
        advance(steps, controller)
    return steps.angles


def _last_sense(steps: ScriptedSteps) -> Sense:
    record = steps.sense[0]
    scalars = {name: float(record[name]) for name in Sense._fields if name != "phase_currents"}
    currents = steps.currents[: int(record["phase_count"])]
    return Sense(phase_currents=tuple(currents.tolist()), **scalars)
