"""How long a step of a controller of duty ratios takes, on the Senses of a recorded run."""

from __future__ import annotations

from statistics import median
from time import perf_counter
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.fault import CandidateFault
from drivegate.checks.record import Record
from drivegate.checks.timing import TIMED_STEPS
from drivegate.containment.contained_controller import ContainedController
from drivegate.containment.messages import AnyController
from drivegate.containment.orders import GiveDutySenses
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.run import duty_nameplate
from drivegate_models.contract.duty.records import DUTY_SENSE
from drivegate_models.loop.given_duty_steps import given_duty_steps, make_duty_steps
from drivegate_models.machine.rotor_frame import phase_currents, shaft_angles

_ROUNDS: Final = 5


def duty_step_seconds(controller: AnyController, record: Record) -> float:
    """Measure the time of a step on what was sensed in a run (s)."""
    assert isinstance(record, DutyRecord), "such steps are those of a run with duty ratios"
    currents = _currents(record)
    senses = _senses(record, len(currents))
    nameplate: Any = duty_nameplate(record.scenario)
    times = []
    # The first round compiles where nothing has.
    for _ in range(_ROUNDS + 1):
        controller.reset(nameplate)
        # What it takes to hand Senses over and commands back, the first step has too.
        alone = _seconds(controller, senses[:1], currents[:1])
        rest = _seconds(controller, senses[1:], currents[1:])
        times.append((rest - alone) / (len(senses) - 1))
    return max(median(times[1:]), 0.0)


def _seconds(controller: AnyController, senses: NDArray[Any], currents: NDArray[np.float64]) -> float:
    if isinstance(controller, ContainedController):
        order = GiveDutySenses(senses, currents)
        started = perf_counter()
        answered = controller.answers(order)
        elapsed = perf_counter() - started
        if answered.fault is not None:
            raise CandidateFault(answered.fault)
        return elapsed
    given = given_duty_steps(controller.step_address, controller.state_address, senses, currents)
    started = perf_counter()
    make_duty_steps(given)
    return perf_counter() - started


def _currents(record: DutyRecord) -> NDArray[np.float64]:
    """Make the phase currents from those of the rotor frame, shape (n, 3) (A)."""
    direct, quadrature, angle = (
        record.run.column(name)[:TIMED_STEPS].copy() for name in ("direct", "quadrature", "angle")
    )
    return phase_currents(direct, quadrature, angle)


def _senses(record: DutyRecord, count: int) -> NDArray[Any]:
    senses = np.zeros(count, DUTY_SENSE)
    taken = {name: record.run.column(name)[:count] for name in ("time", "speed", "link", "angle")}
    wanted = "torque_reference" if record.steady[0].torque_reference is not None else "speed_reference"
    senses["time"], senses["speed"], senses["supply_voltage"] = taken["time"], taken["speed"], taken["link"]
    senses["angle"] = shaft_angles(taken["angle"], record.document.machine.pole_pairs)
    senses["reference"] = record.run.column(wanted)[:count]
    senses["hall"] = senses["encoder_count"] = -1
    return senses
