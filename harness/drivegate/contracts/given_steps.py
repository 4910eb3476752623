"""Steps of a controller without a plant, whatever its contract: recorded to the last bit, or on given Senses."""

from __future__ import annotations

from collections.abc import Callable
from statistics import median
from time import perf_counter
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.controller import CompiledController, Controller
from drivegate.candidates.fault import CandidateFault, Fault, placed, refused_command
from drivegate.checks.every_contract import TIMED_STEPS
from drivegate.containment.candidate_process import Answered
from drivegate.containment.contained_controller import ContainedController
from drivegate.containment.messages import AnyController
from drivegate.containment.protocol import GiveSenses
from drivegate_models.contract.layout import Layout
from drivegate_models.loop.exchange import COMPLETED, STOPPED
from drivegate_models.loop.given_steps import MAKE_STEPS, given_senses
from drivegate_models.loop.loop_inputs import SteppedController
from drivegate_models.loop.step_recording import recorder_of, recording_step

RefusalOf: TypeAlias = Callable[[Any, int], str]
"""From a command and the status that it ended the steps with, returns why."""
_ROUNDS: Final = 5


class RecordingController(CompiledController):
    """A controller that records every step of another one, which has been reset."""

    def __init__(self, inner: Controller, rows: NDArray[Any], *, every: int = 1, skipped: int = 0) -> None:
        """Record every n-th step after the skipped ones into rows of `loop.step_recording.row_layout`."""
        addresses = inner.step_address, inner.state_address
        super().__init__(recording_step(), recorder_of(rows, *addresses, every=every, skipped=skipped))
        self._inner = inner
        self._rows = rows

    @property
    def fault(self) -> Fault | None:
        """What ended the last run, if the inner controller knows."""
        return self._inner.fault

    @property
    def steps(self) -> int:
        """Number of steps that are recorded."""
        return int(self._state[0]["count"])

    def reset(self, nameplate: Any) -> None:
        """Reset the inner controller."""
        self._inner.reset(nameplate)
        # A reset may make another controller.
        self._state[0]["step_address"] = self._inner.step_address
        self._state[0]["state_address"] = self._inner.state_address


def sensed_phases(currents: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]:
    """Return the phase currents that were sensed, shape (n, m) (A), as a column for each phase."""
    return {f"sensed_phase_{number}_a": values for number, values in enumerate(currents.T, start=1)}


class GivenSteps:
    """A controller that is reset, and then stepped through Senses that are given in pieces.

    `last_answers`, shape (n,): commands of the last piece up to a fault, as records of the contract.
    """

    def __init__(
        self, controller: AnyController, nameplate: Any, layout: Layout, refusal_of: RefusalOf
    ) -> None:
        self._controller = controller
        self._nameplate = nameplate
        self._layout = layout
        self._refusal_of = refusal_of
        self._steps = 0
        self.last_answers: NDArray[Any] = np.empty(0, layout.command)
        self.restart()

    def restart(self) -> None:
        """Reset the controller; the steps go on."""
        self._controller.reset(self._nameplate)

    def answers(self, senses: NDArray[Any], currents: NDArray[np.float64]) -> NDArray[Any]:
        """Make a step for each Sense, and return the commands, shape (n,); a fault is raised."""
        answered = self._made(senses, currents)
        commands = answered.commands
        if answered.status == COMPLETED:
            self._steps += len(senses)
            return commands
        is_wrong = answered.status != STOPPED
        # A process that was killed after its last step, or that miscounts them, has not failed after the last Sense.
        row = min(len(commands) - is_wrong, len(senses) - 1)
        self.last_answers = commands[:row]
        sense = self._layout.sensed(senses[row], currents[row])
        raise CandidateFault(self._placed(answered, self._steps + row, sense))

    def _made(self, senses: NDArray[Any], currents: NDArray[np.float64]) -> Answered:
        controller = self._controller
        if isinstance(controller, ContainedController):
            return controller.answers(GiveSenses(senses, currents))
        kept = np.zeros(len(senses), self._layout.command)
        given = given_senses(
            SteppedController(controller.step_address, controller.state_address, kept=kept), senses, currents
        )
        status, count = MAKE_STEPS[self._layout.name](given)
        fault = controller.fault if status == STOPPED else None
        return Answered(kept[: count + (status not in (COMPLETED, STOPPED))], int(status), b"", fault)

    def _placed(self, answered: Answered, step: int, sense: Any) -> Fault:
        """Add to what ended the steps where it happened."""
        if answered.fault is not None:
            return placed(answered.fault, step, sense)
        command = answered.commands[-1] if answered.status != STOPPED else None
        return refused_command(self._refusal_of(command, answered.status), step, sense)


def step_seconds(steps: GivenSteps, senses: NDArray[Any], currents: NDArray[np.float64]) -> float:
    """Measure the time of a step (s), from outside of the process that runs it.

    The time to pass Senses and commands on is left out: the first step, taken alone, has it too.
    """
    senses, currents = senses[:TIMED_STEPS], currents[:TIMED_STEPS]
    times = []
    # The first round compiles where nothing has.
    for _ in range(_ROUNDS + 1):
        steps.restart()
        alone = _seconds(steps, senses[:1], currents[:1])
        times.append((_seconds(steps, senses[1:], currents[1:]) - alone) / max(len(senses) - 1, 1))
    return max(median(times[1:]), 0.0)


def _seconds(steps: GivenSteps, senses: NDArray[Any], currents: NDArray[np.float64]) -> float:
    started = perf_counter()
    steps.answers(senses, currents)
    return perf_counter() - started
