"""After a step of the link the torque is steady as soon as after one of its reference."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from tests.harness.contracts.duty.checks.conftest import CHECKS, Run, judged, with_column

from drivegate.contracts.duty.checks.link_steps import REMAINING_SHARE, decisive_link_step
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import supply_step_scenario, torque_of, torque_scenario
from drivegate.contracts.recorded_trace import deciding_moment
from drivegate_cases.drive.pm_ac.document import PmAcDocument


@pytest.fixture(scope="session")
def stepped(run: Run, interior: PmAcDocument) -> DutyRecord:
    """Give a steady torque below base speed, while the link falls and rises."""
    speed = 0.7 * interior.rating.base_speed_rpm
    held = torque_scenario(interior, speed, (torque_of(interior, speed, 0.9),))
    return run(supply_step_scenario(held, interior, (1.0, 0.85, 1.15)))


def _off(record: DutyRecord, error: float, periods: int) -> DutyRecord:
    """Add an error to the torque in some control periods after the last step of the link."""
    begin = record.steady[-1].dwell.start
    place = round(begin / record.scenario.control_period_s)

    def change(torque: Any) -> Any:
        changed = torque.copy()
        changed[place + 5 : place + periods] += error
        return changed

    return with_column(record, "torque", change)


def test_the_torque_of_a_good_controller_moves_only_until_its_first_answer_acts(stepped: DutyRecord) -> None:
    step, margin = decisive_link_step(stepped), judged("STP-1", stepped)
    assert step is not None
    assert margin is not None
    assert margin.value > 0.9
    # For a period the old duty ratios act: the voltage of each axis is too high by the relative step of the link.
    drive, window, step_share = stepped.plant, stepped.steady[-1], 0.3 / 0.85
    electrical = drive.pole_pairs * window.speed
    volts = (
        step_share
        * stepped.scenario.control_period_s
        * np.array(
            [
                drive.resistance * window.direct
                - electrical * drive.quadrature_inductance * window.quadrature,
                drive.resistance * window.quadrature
                + electrical * (drive.direct_inductance * window.direct + drive.magnet_flux),
            ]
        )
    )
    direct, quadrature = volts / (drive.direct_inductance, drive.quadrature_inductance)
    saliency = drive.direct_inductance - drive.quadrature_inductance
    moved = (
        drive.magnet_flux + saliency * window.direct
    ) * quadrature + saliency * window.quadrature * direct
    allowed = stepped.limits.torque_error_nm + REMAINING_SHARE * 1.5 * drive.pole_pairs * moved
    assert step.allowed == pytest.approx(allowed, rel=0.15)


@pytest.mark.parametrize(("share", "is_met"), [(0.9, True), (1.1, False), (-1.1, False)])
def test_what_is_left_is_judged_on_both_sides_of_its_limit(
    stepped: DutyRecord, share: float, is_met: bool
) -> None:
    step = decisive_link_step(stepped)
    assert step is not None
    late = _off(stepped, share * step.allowed, 40)
    margin = judged("STP-1", late)
    assert margin is not None
    assert margin.met == is_met, margin.measured
    assert "1.2 ms after the link steps from " in margin.measured
    moment = deciding_moment(CHECKS["STP-1"], late, margin)
    assert moment.point is not None
    assert moment.origin_s is not None
    assert moment.origin_s < moment.point.time_s < moment.end_s
    assert abs(moment.point.value - moment.levels[0].value) == pytest.approx(
        abs(share) * step.allowed, rel=0.2
    )


def test_what_is_over_within_the_time_of_a_step_is_allowed(stepped: DutyRecord) -> None:
    margin = judged("STP-1", _off(stepped, 1.0, 12))
    assert margin is not None
    assert margin.met


def test_a_loop_that_declares_its_bandwidth_has_its_time(stepped: DutyRecord) -> None:
    late = _off(stepped, 1.0, 40)
    slow = replace(late, declaration=replace(late.declaration, current_bandwidth=500.0))
    met = [margin is not None and margin.met for margin in (judged("STP-1", late), judged("STP-1", slow))]
    assert met == [False, True]


def test_where_the_lower_voltage_does_not_suffice_nothing_is_judged(
    stepped: DutyRecord, interior: PmAcDocument
) -> None:
    base = interior.rating.base_speed_rpm
    held = torque_scenario(interior, base, (torque_of(interior, base, 0.9),))
    scenario = supply_step_scenario(held, interior, (1.0, 0.85, 1.15))
    at_limit = replace(stepped, scenario=scenario)
    assert np.isfinite(at_limit.run.column("torque")).all()
    assert judged("STP-1", at_limit) is None
