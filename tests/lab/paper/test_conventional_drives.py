"""Conventional drives beside the paper's: the comparison over speed, the map of ripple, and what follows for P9."""

from __future__ import annotations

import math

import numpy as np
import pytest

from drivegate_lab.paper.conventional import CONVENTIONAL, CONVENTIONAL_NUMBERS
from drivegate_lab.paper.drives import at_three_times_base_speed, power_torque, star
from drivegate_lab.paper.facts import all_comparisons, comparisons
from drivegate_lab.paper.figures.conventional_drives import conventional_drives
from drivegate_lab.paper.figures.conventional_ripple_map import ripple_map
from drivegate_lab.paper.findings import recomputed_findings
from drivegate_lab.paper.verdicts import ComparedStatement
from drivegate_models.steady.oracle import feasible_edge, least_current_sum
from drivegate_models.units import RADIANS_PER_RPM


@pytest.fixture(scope="module")
def rows() -> dict[str, ComparedStatement]:
    return {row.quantity: row for row in all_comparisons() if row.fact == "P9"}


@pytest.mark.parametrize(
    ("place", "advance", "current_sum", "ripple", "lowest", "highest", "copper"),
    [
        (0, 50.8, 38.8, 14.0, 9.1, 10.4, 29.0),
        (1, 70.9, 47.9, 52.6, 7.4, 12.5, 47.7),
        (2, 70.2, 46.6, 110.6, 4.7, 15.2, 45.7),
        (3, 46.4, 35.4, 14.7, 9.1, 10.5, 25.1),
    ],
    ids=["five phases", "star", "wide EMF", "wide windows"],
)
def test_a_star_has_the_ripple_of_conventional_drives(
    place: int,
    advance: float,
    current_sum: float,
    ripple: float,
    lowest: float,
    highest: float,
    copper: float,
) -> None:
    """Published of conventional drives: ripple of 125 and 144 %, by far more than that of five phases."""
    found = at_three_times_base_speed()[place]
    point = found.point
    measured = (
        found.advance_deg,
        point.current_sum,
        found.ripple_percent,
        point.torque_lowest,
        point.torque_highest,
        point.copper_loss,
    )
    assert measured == pytest.approx((advance, current_sum, ripple, lowest, highest, copper), abs=0.06)


def test_constant_power_ends_early_with_narrow_windows() -> None:
    five, plain, wide_emf, wide_windows = conventional_drives().drives
    assert plain.to_rpm == pytest.approx(2420.0, abs=10.0)
    assert wide_emf.to_rpm == pytest.approx(2940.0, abs=10.0)
    assert five.to_rpm == wide_windows.to_rpm == pytest.approx(6000.0), "as far as was looked"
    for drive in (five, plain, wide_emf, wide_windows):
        assert 480.0 < drive.from_rpm < 520.0, f"{drive.name} begins at {drive.from_rpm:.0f} rpm"


def test_curves_end_where_the_range_of_constant_power_ends() -> None:
    data = conventional_drives()
    for drive in data.drives:
        within = (data.speed_rpm >= drive.from_rpm) & (data.speed_rpm <= drive.to_rpm)
        np.testing.assert_array_equal(np.isfinite(drive.ripple_percent), within, err_msg=drive.name)
        shaft = drive.input_w - drive.copper_loss_w
        np.testing.assert_allclose(
            shaft[within], data.power_w, rtol=1e-6, err_msg=f"{drive.name}: net of copper"
        )


def test_the_map_has_the_published_ripple_between_narrow_and_wide_emfs() -> None:
    data = ripple_map()
    own = int(np.argmin(np.abs(data.inductance_mh - data.own_mh)))
    at = {flat: row for row, flat in enumerate(data.flat_deg.tolist())}
    necessary = data.necessary.ripple_percent[:, own]
    assert necessary[at[120.0]] == pytest.approx(52.6, abs=0.1)
    assert necessary[at[150.0]] == pytest.approx(110.6, abs=0.1)
    assert data.edge_deg[at[120.0], own] == pytest.approx(70.9, abs=0.1)
    assert data.flats_where(data.necessary.as_published)[0] == 155.0
    assert data.flats_where(data.further.as_published) == (130.0, 155.0)
    assert not data.necessary.changes_sign[at[150.0]].any(), "at the smallest angle the torque keeps its sign"
    assert data.further.changes_sign[at[150.0]].any(), "15° further on it does not"
    for one in (data.necessary, data.further):
        growth = np.diff(one.ripple_percent[data.flat_deg >= 125.0], axis=0)
        assert np.nanmin(growth) > 0.0, "the wider the EMF, the more ripple"


def test_power_is_out_of_reach_with_much_inductance() -> None:
    data = ripple_map()
    assert np.isfinite(data.edge_deg[:, data.inductance_mh < 1.3]).all()
    assert np.isnan(data.edge_deg[:, -1]).all()
    unreached = np.isnan(data.edge_deg)
    assert np.isnan(data.necessary.ripple_percent[unreached]).all(), (
        "a ripple where the power is out of reach"
    )
    beyond = ~(data.edge_deg + data.further.further_deg <= 90.0)
    assert np.isnan(data.further.ripple_percent[beyond]).all(), "a ripple beyond 90°"


@pytest.mark.parametrize(("share", "flat_deg"), [(0.25, 90.0), (0.25, 150.0), (0.6, 120.0), (1.0, 150.0)])
def test_the_smallest_angle_of_the_map_is_that_of_least_current(share: float, flat_deg: float) -> None:
    drive = star(emf_flat_deg=flat_deg, inductance_h=share * star().machine.inductance_h).plant()
    speed, torque = 1500.0 * RADIANS_PER_RPM, power_torque(1500.0, 1500.0)
    least = least_current_sum(drive, speed, torque).advance
    assert math.degrees(least - feasible_edge(drive, speed, torque)) == pytest.approx(0.0, abs=0.01)


def test_conventional_drives_are_reproduced_in_kind(rows: dict[str, ComparedStatement]) -> None:
    verdicts = {row.verdict for row in rows.values()}
    assert verdicts == {"reproduced", "reproduced in kind"}, "nothing of P9 is open"
    for quantity, published in (("surface", "144 %"), ("inset", "125 %")):
        row = next(row for name, row in rows.items() if quantity in name)
        assert (row.published, row.ours, row.residual) == (published, "53 to 111 %", "")
    inset = rows["ripple of an inset-magnet drive"]
    assert "saliency is not modelled" in inset.note, "ours has no saliency, which must be said"


def test_the_torque_of_a_star_changes_its_sign(rows: dict[str, ComparedStatement]) -> None:
    row = rows["torque of these drives under phase advance"]
    values = {number.name: number.value for number in row.numbers}
    assert values["least torque"] == pytest.approx(-1.6, abs=0.05)
    assert values["greatest torque"] == pytest.approx(17.9, abs=0.05)
    assert values["ripple"] == pytest.approx(204.0, abs=0.5)
    assert row.ours.startswith("−1.6 to 17.9 N·m at 60°")


def test_wide_windows_do_what_five_phases_do() -> None:
    numbers = {item.finding.id: dict(item.numbers) for item in recomputed_findings()}["F8"]
    key = next(name for name in numbers if name.startswith("star, 150° for 120° windows"))
    assert numbers[key] == "46.4°, Σ|i| 35.4 A, ripple 14.7 %, copper 25.1 W"


def test_a_check_of_the_papers_drive_computes_no_star() -> None:
    """A second plant takes long to compile, so pages on candidates leave it to the reproduction."""
    apart = set(all_comparisons()) - set(comparisons())
    computed = {row.quantity for row in apart if row.fact != "Fig. 1"}
    assert computed == {compare().quantity for rows in CONVENTIONAL.values() for compare in rows}
    for item in recomputed_findings(of_paper_drive_only=True):
        assert bool(item.numbers) == (item.finding.id not in CONVENTIONAL_NUMBERS), item.finding.id
