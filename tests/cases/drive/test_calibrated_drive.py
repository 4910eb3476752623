"""The stored drive is the calibrated one, within stated tolerances."""

from __future__ import annotations

from math import degrees

import pytest
from paper_calibration import (
    ROUNDING,
    calibrate,
    calibration_drive,
    published_facts,
)

from drivegate_cases.drive.drive_document import load_drive


def test_stored_constants_are_the_fitted_ones_rounded() -> None:
    stored = load_drive("paper-5-phase").plant()
    fitted = calibrate().constants
    assert stored.emf_constant == pytest.approx(fitted.emf_constant, rel=0.003)
    assert stored.inductance == pytest.approx(fitted.inductance, rel=0.003)
    assert stored.resistance == fitted.resistance
    flat_edges = stored.emf_angles[1:3]
    assert degrees(flat_edges[1] - flat_edges[0]) == pytest.approx(degrees(fitted.emf_flat), abs=0.5)


def test_stored_drive_meets_the_published_facts_as_they_are_rounded() -> None:
    """Each residual stays within half of the published figure's last digit."""
    ideal = load_drive("paper-5-phase").plant()._replace(hysteresis_band=0.0, core_loss_conductance=0.0)
    halves = [ROUNDING["worst_ripple_angle"], ROUNDING["middle_angle"], ROUNDING["rated_power"]]
    for fact, half in zip(published_facts(ideal), halves, strict=True):
        assert abs(fact.residual) < half, f"{fact.name}: {fact.ours:g} {fact.unit}, not {fact.published:g}"


def test_what_the_fit_takes_as_published_is_the_stored_drive_s() -> None:
    stored = load_drive("paper-5-phase").plant()
    assumed = calibration_drive(calibrate().constants)
    for name in ("phases", "pole_pairs", "half_supply_voltage", "window", "current_limit"):
        assert getattr(stored, name) == pytest.approx(getattr(assumed, name)), name
