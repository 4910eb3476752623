"""RIP-4 follows and judges the torque on the drive as it is: with the windings and the link of that time."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.harness.contracts.duty.checks.conftest import CHECKS, Run, judged, with_column, with_command

from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.run import DUTY_RATIOS, LEGS
from drivegate.contracts.duty.scenarios.building import share_scenario
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.contract.duty.signals import LEG_OFF
from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.pm_ac.plant import dc_link
from drivegate_models.pm_ac.plant.advance import make_phases
from drivegate_models.pm_ac.plant.drive import alignment_of, drifted
from drivegate_models.pm_ac.plant.linked_advance import advance_linked_period


def true_extremes(record: DutyRecord) -> NDArray[np.float64]:
    """Return the least and greatest torque in each control period of a whole run on its link, shape (n, 2)."""
    run, drive, length = record.run, record.plant, record.scenario.control_period_s
    phases, totals = make_phases(follows_torque=True), np.zeros(ledger.ENTRIES)
    dc_link.charge_link(phases.dc_link, float(run.column("link")[0]))
    # The legs are off until the first command acts.
    ratios = np.array([np.zeros(3), *np.stack([run.commands[name] for name in DUTY_RATIOS], axis=1)])
    legs = np.array([np.zeros(3, np.int64), *np.stack([run.commands[name] for name in LEGS], axis=1)])
    found = np.zeros((len(run.trace), 2))
    for k, (angle, speed, temperature) in enumerate(
        zip(*(run.column(name).tolist() for name in ("angle", "speed", "winding_temperature")), strict=True)
    ):
        thermal = record.document.thermal
        warmth = 1.0 if thermal is None else thermal.resistance_at(temperature, 1.0)
        totals[:] = 0.0
        plant, alignment = drifted(drive, warmth, 1.0), alignment_of(drive.modulator.updates, k)
        given = (drive.link_voltage, ratios[k], legs[k], np.nan, alignment, length, totals)
        assert advance_linked_period(plant, phases, angle, speed, *given) == COMPLETED
        losses = totals[ledger.CORE_SOURCE] + totals[ledger.SWITCHING]
        phases.dc_link.state[dc_link.PENDING] = losses / length
        found[k] = phases.torque_bounds
    assert float(phases.rotor_currents[1]) == pytest.approx(float(run.column("quadrature")[-1]), abs=1e-9)
    return found


@pytest.mark.parametrize(
    ("name", "share", "temperature_c"),
    [
        pytest.param("pm-ac-hub", 0.9, 100.0, id="hot windings"),
        pytest.param("pm-ac-chopper", -0.12, None, id="a link between the thresholds of its chopper"),
    ],
)
def test_the_torque_is_followed_on_the_drive_as_it_is(
    name: str, share: float, temperature_c: float | None, run: Run
) -> None:
    drive = load_drive(name)
    assert isinstance(drive, PmAcDocument)
    cool = share_scenario(drive.replaced(settling_s=0.2), 0.5 * drive.rating.base_speed_rpm, share)
    record = run(cool.replaced(winding_temperature_c=temperature_c))
    # A run that heats the windings so far begins cool, and would take long.
    record = replace(record, scenario=cool)
    margin = judged("RIP-4", record)
    assert margin is not None
    assert margin.met, margin.measured
    find_moment = CHECKS["RIP-4"].moment
    assert find_moment is not None
    moment = find_moment(record)
    assert moment is not None
    greatest, least = (np.array(course.values) for course in moment.courses)
    first = round(moment.start_s / cool.control_period_s)
    true = true_extremes(record)[first : first + len(least)]
    swing = np.ptp(true)
    assert least == pytest.approx(true[:, 0], abs=0.03 * swing)
    assert greatest == pytest.approx(true[:, 1], abs=0.03 * swing)


def test_a_link_that_its_chopper_swings_is_not_judged(run: Run) -> None:
    drive = load_drive("pm-ac-chopper")
    assert isinstance(drive, PmAcDocument)
    record = run(share_scenario(drive.replaced(settling_s=0.2), 0.5 * drive.rating.base_speed_rpm, 0.5))
    assert judged("RIP-4", record) is not None
    assert judged("RIP-4", with_column(record, "chopper_power", lambda values: values + 1.0)) is None


def test_what_the_diodes_alone_make_is_no_modulation(run: Run) -> None:
    """ACC-1 accuses a bridge that is off, RIP-4 does not."""
    drive = load_drive("pm-ac-interior")
    record = run(share_scenario(drive, 0.5 * drive.rating.base_speed_rpm, 0.5))
    assert judged("RIP-4", record) is not None
    for leg in LEGS:
        record = with_command(record, leg, lambda states: np.full_like(states, LEG_OFF))
    assert judged("RIP-4", record) is None


def test_no_regulator_answers_for_steps_of_a_coarse_counter(run: Run, interior: PmAcDocument) -> None:
    margin = judged("RIP-4", run(share_scenario(interior.replaced(counter_levels=100), -350.0, -0.9)))
    assert margin is not None
    assert margin.met, margin.measured


def test_no_regulator_answers_for_pulses_that_the_modulator_omits(run: Run, interior: PmAcDocument) -> None:
    drive = interior.replaced(minimum_pulse_s=5e-6)
    base = drive.rating.base_speed_rpm
    margin = judged("RIP-4", run(share_scenario(drive, base, 0.6)))
    assert margin is not None
    assert margin.met, margin.measured
    # At 94 % of the voltage, pulses and gaps of 3 % of the period are left out.
    assert judged("RIP-4", run(share_scenario(drive, 1.5 * base, 0.6))) is None
