"""The calibration rederives the motor from the published facts, firmly enough to be worth the name."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, radians

import pytest
from paper_calibration import (
    ROUNDING,
    Calibration,
    MotorConstants,
    PublishedFigures,
    calibrate,
    calibration_drive,
    comparison,
    geometry_check,
    published_facts,
    table_lines,
)

from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.steady.oracle import greatest_torque_at_limit
from drivegate_models.steady.steady_state import steady_state


@pytest.fixture(scope="module")
def calibration() -> Calibration:
    return calibrate()


def test_fitted_motor_meets_the_published_facts(calibration: Calibration) -> None:
    angle_1500, angle_1200, power = calibration.facts
    assert angle_1500.ours == pytest.approx(52.0, abs=1e-3)
    assert angle_1200.ours == pytest.approx(40.0, abs=1e-3)
    assert power.ours == pytest.approx(1500.0, abs=1e-3)
    assert max(abs(residual) for residual in calibration.torque_residuals) < 1e-8
    for fact in calibration.facts:
        assert fact.residual == fact.ours - fact.published
        assert fact.unit


def test_fitted_constants(calibration: Calibration) -> None:
    constants = calibration.constants
    assert constants.emf_constant == pytest.approx(0.3381, abs=2e-4)
    assert constants.inductance == pytest.approx(2.888e-3, abs=2e-6)
    assert degrees(constants.emf_flat) == pytest.approx(98.5, abs=0.1)
    assert constants.resistance == 0.08


def test_the_same_input_gives_the_same_fit(calibration: Calibration) -> None:
    assert calibrate() == calibration


@pytest.mark.parametrize("constants", [(0.30, 2.0e-3, 120.0), (0.345, 3.1e-3, 85.0)])
def test_a_known_motor_is_found_again(constants: tuple[float, float, float]) -> None:
    """Facts made from known constants lead back to them, so the fit has one answer and finds it."""
    emf_constant, inductance, flat = constants
    known = MotorConstants(emf_constant, inductance, radians(flat))
    drive = calibration_drive(known)
    speed_per_rpm = radians(6.0)
    figures = PublishedFigures(
        worst_ripple_torque=steady_state(drive, 1500 * speed_per_rpm, 26.0, radians(52.0)).torque,
        middle_torque=steady_state(drive, 1200 * speed_per_rpm, 26.0, radians(40.0)).torque,
        rated_power=greatest_torque_at_limit(drive, 500.0 * speed_per_rpm).torque * 500 * speed_per_rpm,
    )
    found = calibrate(figures).constants
    assert found.emf_constant == pytest.approx(emf_constant, rel=1e-5)
    assert found.inductance == pytest.approx(inductance, rel=1e-5)
    assert found.emf_flat == pytest.approx(known.emf_flat, rel=1e-4)


def test_sensitivities_state_what_is_firm(calibration: Calibration) -> None:
    assert [row.cause for row in calibration.sensitivities] == [*ROUNDING, "resistance"]
    assert 5.0 < calibration.condition < 50.0
    # The flat top's width is the least firm: a half digit of each figure moves it by some 18 degrees in all.
    assert 10.0 < degrees(calibration.spread.emf_flat) < 25.0
    assert calibration.spread.inductance < 0.02 * calibration.constants.inductance
    assert calibration.spread.emf_constant < 0.1 * calibration.constants.emf_constant


def test_a_sensitivity_is_the_shift_of_a_fit(calibration: Calibration) -> None:
    figures = PublishedFigures()
    moved = calibrate(replace(figures, middle_angle=figures.middle_angle + ROUNDING["middle_angle"]))
    row = next(row for row in calibration.sensitivities if row.cause == "middle_angle")
    shift = moved.constants.inductance - calibration.constants.inductance
    assert row.inductance == pytest.approx(shift, rel=1e-6)


def test_resistance_hardly_matters(calibration: Calibration) -> None:
    other = calibrate(resistance=0.06).constants
    assert other.emf_constant == pytest.approx(calibration.constants.emf_constant, rel=0.005)
    assert other.inductance == pytest.approx(calibration.constants.inductance, rel=0.01)
    assert other.emf_flat == pytest.approx(calibration.constants.emf_flat, rel=0.005)


def test_geometry_asks_for_an_ordinary_flux_density(calibration: Calibration) -> None:
    geometry = calibration.geometry
    assert geometry.series_turns == 52
    assert geometry.flux_density == pytest.approx(0.756, abs=0.002)
    assert geometry_check(2.0 * 52 * 0.77 * 0.100 * 0.043).flux_density == pytest.approx(0.77, rel=1e-12)


def test_facts_of_another_motor_carry_their_residuals() -> None:
    rounded = calibration_drive(MotorConstants(0.339, 2.88e-3, radians(98.0)))
    residuals = [fact.residual for fact in published_facts(rounded)]
    assert residuals == pytest.approx([-0.10, -0.14, 3.70], abs=0.02)


def test_the_stored_drive_agrees_with_its_calibration() -> None:
    compared = comparison(load_drive("paper-5-phase"))
    assert compared["agrees"]
    text = "\n".join(table_lines(compared))
    assert all(fact["name"] in text for fact in compared["facts"])
    assert " no " not in text


def test_a_drive_that_no_longer_follows_from_the_facts_is_reported() -> None:
    altered = load_drive("paper-5-phase").replaced(inductance_h=3.2e-3)
    compared = comparison(altered)
    assert not compared["agrees"]
    assert not compared["constants"]["inductance"]["agrees"]
    assert " no  inductance (mH)" in "\n".join(table_lines(compared))
