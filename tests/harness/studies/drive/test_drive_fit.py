"""A drive's constants come back from torques that were made with them, and the published ones from the paper's."""

from dataclasses import replace
from math import isinf, isnan, pi
from typing import Any

import numpy as np
import pytest
from paper_calibration import calibrate

from drivegate.drives.rating import drive_with
from drivegate.studies.drive.fit import MeasuredTorque, fit_document, read_measured
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_models.errors import InputError

PAPER = load_drive("paper-5-phase")
TRUE = {
    "emf_constant_v_s_per_rad": 0.3,
    "inductance_h": 2.5e-3,
    "resistance_ohm": 0.12,
    "emf_flat_deg": 110.0,
}
PUBLISHED = (
    MeasuredTorque(1500.0, 9.8, 52.0),
    MeasuredTorque(1200.0, 11.88, 40.0),
    # Rated power at base speed, at whatever angle.
    MeasuredTorque(500.0, 1500.0 / (500.0 * pi / 30.0)),
)
NOISE = 0.05


def measured(
    document: DriveDocument, seed: int | None = None, uncertainty: float = np.nan
) -> list[MeasuredTorque]:
    """Measure the drive of the true constants at twenty points, with noise where there is a seed."""
    is_flat = document.machine.emf_shape == "trapezoid"
    constants = {key: value for key, value in TRUE.items() if is_flat or key != "emf_flat_deg"}
    drive = drive_with(document, constants)
    errors = np.zeros(20) if seed is None else NOISE * np.random.default_rng(seed).standard_normal(20)
    places = [
        (speed, advance, current)
        for speed in (100.0, 300.0, 600.0, 1000.0, 1500.0)
        for advance, current in ((0.0, 10.0), (20.0, 20.0), (50.0, 26.0), (60.0, 15.0))
    ]
    points = []
    for (speed, advance, current), error in zip(places, errors, strict=True):
        torque = MeasuredTorque(speed, 0.0, advance, current).torque_of(drive)
        points.append(MeasuredTorque(speed, torque + float(error), advance, current, uncertainty))
    return points


def by_key(document: dict[str, Any], value: str) -> dict[str, float]:
    return {row["key"]: row[value] for row in document["constants"]}


def test_the_published_facts_give_the_calibration() -> None:
    constants = calibrate().constants
    document = fit_document(PAPER, PUBLISHED, ["resistance_ohm"])
    fitted = by_key(document, "fitted")
    assert fitted["emf_constant_v_s_per_rad"] == pytest.approx(constants.emf_constant, rel=1e-6)
    assert fitted["inductance_h"] == pytest.approx(constants.inductance, rel=1e-6)
    assert fitted["emf_flat_deg"] == pytest.approx(np.degrees(constants.emf_flat), rel=1e-5)
    assert all(map(isnan, by_key(document, "uncertainty").values())), (
        "three points tell no more than three values"
    )


def test_constants_come_back_from_what_they_gave_wherever_the_search_begins() -> None:
    for start in ({}, {"emf_constant_v_s_per_rad": 0.6, "inductance_h": 8e-3, "emf_flat_deg": 30.0}):
        document = fit_document(PAPER.replaced(**start), measured(PAPER))
        assert by_key(document, "fitted") == pytest.approx(TRUE, rel=1e-4)
        assert document["rms_residual_nm"] < 1e-6
        assert document["usable"]
        assert not any(by_key(document, "at_bound").values())


@pytest.mark.nightly
def test_the_uncertainty_is_what_repeating_the_measurement_shows() -> None:
    fits = [fit_document(PAPER, measured(PAPER, seed)) for seed in range(25)]
    for key, true in TRUE.items():
        values = np.array([by_key(fit, "fitted")[key] for fit in fits])
        reported = np.mean([by_key(fit, "uncertainty")[key] for fit in fits])
        assert values.std() == pytest.approx(reported, rel=0.45), f"{key} scatters otherwise than reported"
        assert abs(values.mean() - true) < 4.0 * reported / 5.0


def test_a_stated_uncertainty_counts_and_more_scatter_than_stated_counts_more() -> None:
    exact = measured(PAPER, None, NOISE)
    stated = by_key(fit_document(PAPER, exact), "uncertainty")
    twice = by_key(fit_document(PAPER, measured(PAPER, None, 2.0 * NOISE)), "uncertainty")
    assert twice == pytest.approx({key: 2.0 * value for key, value in stated.items()}, rel=1e-2)
    too_small = by_key(fit_document(PAPER, measured(PAPER, 3, 0.1 * NOISE)), "uncertainty")
    scattered = by_key(fit_document(PAPER, measured(PAPER, 3)), "uncertainty")
    assert too_small == pytest.approx(scattered, rel=1e-3)


def test_what_the_points_do_not_show_is_uncertain_without_end() -> None:
    # At so low a speed and current, and an angle of zero, neither inductance nor resistance are felt.
    slow = [
        MeasuredTorque(1.0, torque, 0.0, 1.0 + k) for k, torque in enumerate((1.2, 2.4, 3.7, 4.9, 6.0, 7.3))
    ]
    uncertainty = by_key(fit_document(PAPER, slow), "uncertainty")
    assert isinf(uncertainty["resistance_ohm"]) or uncertainty["resistance_ohm"] > 0.08


@pytest.mark.nightly
def test_torques_that_no_constants_explain_propose_none() -> None:
    true = measured(PAPER)
    scattered = [replace(point, torque=5.0 + 3.0 * (number % 3)) for number, point in enumerate(true)]
    document = fit_document(PAPER, scattered)
    assert not document["usable"]
    assert not document["explained"]
    assert document["constants"] == []
    # What is said to scatter so much may.
    assert fit_document(PAPER, [replace(point, uncertainty=3.0) for point in scattered])["explained"]


def test_a_drive_without_an_advance_angle_is_refused() -> None:
    with pytest.raises(InputError, match="has no steady states of an advance angle"):
        fit_document(load_drive("pm-ac-interior"), PUBLISHED)


def test_a_sine_has_no_flat_width() -> None:
    sine = PAPER.replaced(emf_shape="sine")
    assert set(by_key(fit_document(sine, measured(sine)), "fitted")) == set(TRUE) - {"emf_flat_deg"}


@pytest.mark.parametrize(
    ("kept", "changes", "reason"),
    [
        ((), {}, "3 points cannot tell 4 constants"),
        (("resistence_ohm",), {}, "the nearest is 'resistance_ohm'"),
        (tuple(TRUE), {}, "leaves no constant"),
        ((), {"resistance_ohm": 0.0}, "begins at the drive's own value, which is 0"),
    ],
)
def test_what_cannot_be_fitted_is_refused(
    kept: tuple[str, ...], changes: dict[str, float], reason: str
) -> None:
    with pytest.raises(InputError) as refused:
        fit_document(PAPER.replaced(**changes), PUBLISHED, kept)
    assert reason in str(refused.value)


@pytest.mark.parametrize(
    ("rows", "reason"),
    [
        ("", "has 0 points"),
        ("0,5,10\n", "'speed_rpm' is 0, but must be above 0"),
        ("500,5,91\n", "'advance_deg' is 91, but must be from 0 to 90"),
        ("500,5,10,-1\n", "'current_a' is -1, but must be above 0"),
        ("500,5,10,1,0\n", "'uncertainty_nm' is 0, but must be above 0"),
        ("500,5,10,1,0.1\n600,5,10\n", "for some points, but must be for all or none"),
        ("500,5,steep\n", '"steep" in line 2'),
    ],
)
def test_points_that_cannot_be_are_refused(tmp_path: Any, rows: str, reason: str) -> None:
    (tmp_path / "own.csv").write_text(
        f"speed_rpm,torque_nm,advance_deg,current_a,uncertainty_nm\n{rows}", encoding="utf-8"
    )
    with pytest.raises(InputError) as refused:
        read_measured(tmp_path / "own.csv")
    assert reason in str(refused.value)
