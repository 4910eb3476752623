"""How long a step of a controller of duty ratios takes, on the Senses of a recorded run."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.checks.check import Record
from drivegate.checks.every_contract import TIMED_STEPS
from drivegate.containment.messages import AnyController
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.run import duty_nameplate, refusal_of
from drivegate.contracts.given_steps import GivenSteps, step_seconds
from drivegate_models.contract.duty.records import duty_sense_record
from drivegate_models.contract.layout import DUTY
from drivegate_models.machine.rotor_frame import phase_currents, shaft_angles


def given_duty_steps(controller: AnyController, nameplate: Any) -> GivenSteps:
    """Reset a controller for steps through given Senses."""
    return GivenSteps(controller, nameplate, DUTY, refusal_of)


def duty_step_seconds(controller: AnyController, record: Record) -> float:
    """Measure the time of a step on what was sensed in a run (s)."""
    assert isinstance(record, DutyRecord), "such steps are those of a run with duty ratios"
    currents = _currents(record)
    steps = given_duty_steps(
        controller, duty_nameplate(record.scenario, follows_current=record.follows_current)
    )
    return step_seconds(steps, _senses(record, len(currents)), currents)


def _currents(record: DutyRecord) -> NDArray[np.float64]:
    """Make the phase currents from those of the rotor frame, shape (n, 3) (A)."""
    direct, quadrature, angle = (
        record.run.column(name)[:TIMED_STEPS].copy() for name in ("direct", "quadrature", "angle")
    )
    return phase_currents(direct, quadrature, angle)


def _senses(record: DutyRecord, count: int) -> NDArray[Any]:
    senses = np.repeat(duty_sense_record(np.zeros(3)), count)
    taken = {name: record.run.column(name)[:count] for name in ("time", "speed", "link", "angle")}
    wanted = "torque_reference" if record.steady[0].torque_reference is not None else "speed_reference"
    senses["time"], senses["speed"], senses["supply_voltage"] = taken["time"], taken["speed"], taken["link"]
    senses["angle"] = shaft_angles(taken["angle"], record.document.machine.pole_pairs)
    senses["reference"] = record.run.column(wanted)[:count]
    if record.follows_current and wanted == "torque_reference":
        torques, places = np.unique(senses["reference"], return_inverse=True)
        senses["reference"] = np.array([record.quadrature_reference(torque) for torque in torques])[places]
    return senses
