"""A run in closed loop of any contract: commands of a candidate in a process of its own are played back here."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

from numpy.typing import NDArray

from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import CandidateFault, placed, refused_command
from drivegate.containment.contained_controller import ContainedController, PlayedCommands
from drivegate.containment.messages import AnyController
from drivegate.containment.protocol import CloseLoop
from drivegate.containment.restarting import Restarter
from drivegate_models.errors import HarnessFault
from drivegate_models.loop.duty_command import BAD_LEG
from drivegate_models.loop.exchange import COMPLETED, NOT_FINITE, STOPPED
from drivegate_models.loop.loop_inputs import LoopInputs, SteppedController

Wrap: TypeAlias = Callable[[Controller], Controller]
"""Puts something between the closed loop and a controller, which passes every step on."""


def run_loop(
    order: CloseLoop,
    controller: AnyController,
    nameplate: Any,
    steps: int,
    refusal_of: Callable[[Any, int], str],
    *,
    observed: LoopInputs | None = None,
    kept: NDArray[Any] | None = None,
    wrap: Wrap | None = None,
) -> Any:
    """Reset a controller, run it in closed loop for a number of steps, and return what the loop observed.

    A candidate's instance runs in its own process, beside a plant that is there to close the loop; what is observed is
    what the plant here comes to by the same commands. A fault of the controller is raised.

    `refusal_of`: from a command and the status that it ended the run with, returns why. `observed`: inputs of the plant
    here, with what the candidate's process is not to know; by default those of the order. `kept`: receives the command
    of each step.
    """
    controller.reset(nameplate)
    by_address = controller.run(order, steps) if isinstance(controller, ContainedController) else controller
    stepped = by_address if wrap is None else wrap(by_address)
    restarter = Restarter(stepped, nameplate)
    prepared = order.prepare(
        order.inputs if observed is None else observed,
        SteppedController(stepped.step_address, stepped.state_address, kept=kept),
        restarter.restarts(order.restart_steps),
    )
    run = prepared.run()
    if restarter.failures:
        # Taken out, since what is raised keeps this frame, and with it the restarter.
        raise restarter.failures.pop()
    if run.status != COMPLETED:
        exchange, step = prepared.exchange, int(run.steps)
        sense = order.layout.sensed(exchange.sense[0], exchange.sensed_currents)
        fault = by_address.fault
        if run.status == STOPPED and fault is not None:
            raise CandidateFault(placed(fault, step, sense))
        if run.status not in (STOPPED, NOT_FINITE, BAD_LEG):
            raise HarnessFault(f"the plant ended with status {run.status} at step {step}, {sense.time:g} s")
        reason = refusal_of(exchange.command[0], run.status)
        raise CandidateFault(refused_command(reason, step, sense))
    # Where played commands end in another state of the plant, the candidate has changed its own process.
    if isinstance(by_address, PlayedCommands) and (fault := by_address.disturbed(prepared.records)):
        raise CandidateFault(fault)
    return run
