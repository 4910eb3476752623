"""Five phases, a star and PM AC at the same power: what each takes, and where its power ends."""

from __future__ import annotations

import math

import numpy as np
import pytest

from drivegate_lab.paper.drives import at_three_times_base_speed, constant_power_range
from drivegate_lab.paper.figures.kinds_of_drives import kinds_over_speed
from drivegate_lab.paper.findings import recomputed_findings
from drivegate_lab.paper.kinds_of_drives import OUT_OF_REACH, KindOfDrive, kinds_of_drives
from drivegate_models.pm_ac.oracle import undistorted_limits
from drivegate_models.units import RADIANS_PER_RPM

FIVE, STAR, FUNDAMENTAL, AS_HIGH, SURFACE = range(5)


@pytest.fixture(scope="module")
def drives() -> tuple[KindOfDrive, ...]:
    return kinds_of_drives()


@pytest.mark.parametrize(
    ("place", "power", "speed", "current_sum", "copper", "ripple"),
    [
        (FIVE, 1500.0, 1500.0, 38.8, 29.0, 14.0),
        (STAR, 1500.0, 1500.0, 47.9, 47.7, 52.6),
        (FUNDAMENTAL, 1500.0, 1500.0, 38.5, 29.3, 0.0),
        (FIVE, 700.0, 550.0, 39.1, 29.8, 11.3),
        (AS_HIGH, 700.0, 550.0, 45.7, 41.2, 0.0),
        (SURFACE, 700.0, 1500.0, 18.4, 11.2, 0.0),
    ],
)
def test_an_operating_point_has_the_values_of_the_findings(
    drives: tuple[KindOfDrive, ...],
    place: int,
    power: float,
    speed: float,
    current_sum: float,
    copper: float,
    ripple: float,
) -> None:
    point = drives[place].at(speed, power)
    assert (point.current_sum_a, point.copper_loss_w) == pytest.approx((current_sum, copper), abs=0.06)
    assert point.ripple_percent == pytest.approx(ripple, abs=0.06)
    assert point.input_w == pytest.approx(power + point.copper_loss_w, rel=1e-6), "nothing else is lost"


def test_five_phases_and_star_are_those_of_the_other_comparison(drives: tuple[KindOfDrive, ...]) -> None:
    for drive, other in zip(drives[:2], at_three_times_base_speed()[:2], strict=True):
        assert drive.at(1500.0, 1500.0).current_sum_a == other.point.current_sum
    for drive in drives[:2]:
        assert drive.power_range(1500.0) == pytest.approx(constant_power_range(drive.document), abs=0.2)


def test_a_sine_wave_of_currents_has_this_sum_of_magnitudes(drives: tuple[KindOfDrive, ...]) -> None:
    """Without weakening all current lies across the magnet: T = 3/2 p psi i, and three phases lose 3/2 R i^2."""
    drive = drives[SURFACE]
    torque = 700.0 / (600.0 * RADIANS_PER_RPM)
    peak = torque / (1.5 * 11 * 0.0308)
    angles = np.linspace(0.0, 2.0 * math.pi, 3600, endpoint=False)
    sums = sum(np.abs(peak * np.sin(angles + turn)) for turn in (0.0, 2.0 * math.pi / 3, 4.0 * math.pi / 3))
    point = drive.at(600.0, 700.0)
    assert point.current_sum_a == pytest.approx(float(np.mean(sums)), rel=1e-3)
    assert point.copper_loss_w == pytest.approx(1.5 * 0.08 * peak**2, rel=1e-3)


def test_power_of_surface_magnets_ends_where_the_limits_say(drives: tuple[KindOfDrive, ...]) -> None:
    """Far above base speed a machine without saliency has at most 3/2 V psi/L, and less for its resistance."""
    for place, reaches in ((FUNDAMENTAL, True), (AS_HIGH, False), (SURFACE, False)):
        drive = drives[place]
        plant = drive.document.plant()
        most = 1.5 * undistorted_limits(plant).voltage * plant.magnet_flux / plant.direct_inductance
        assert 0.97 * most < drive.greatest_power(6000.0) < most, drive.name
        assert (drive.power_range(1500.0) is not None) is reaches, drive.name
        if not reaches:
            assert drive.at(1500.0, 1500.0) is OUT_OF_REACH
    first, last = drives[FUNDAMENTAL].power_range(1500.0) or (0.0, 0.0)
    assert first == pytest.approx(558.0, abs=1.0)
    assert last == 6000.0
    assert math.isnan(drives[FUNDAMENTAL].at(first - 1.0, 1500.0).current_sum_a)
    assert drives[FUNDAMENTAL].at(first + 1.0, 1500.0).current_sum_a > 0.0


def test_only_windows_make_ripple(drives: tuple[KindOfDrive, ...]) -> None:
    data = kinds_over_speed()
    assert [kind.drive for kind in data.kinds] == list(drives)
    for kind in data.kinds[:2]:
        assert kind.ripple_percent.min() > 2.0
    for kind in data.kinds[2:]:
        assert not kind.ripple_percent.any()
    worst = max(kind.ripple_percent.max() for kind in data.kinds[1:])
    assert worst == data.kinds[STAR].ripple_percent.max()
    assert worst > 3.0 * data.kinds[FIVE].ripple_percent.max()


def test_the_finding_has_the_numbers_that_it_tells() -> None:
    found = next(item for item in recomputed_findings() if item.finding.id == "F9")
    numbers = dict(found.numbers)
    told = "PM AC, the trapezoid's fundamental, 1.5 kW"
    assert numbers[told] == "from 558 to at least 6000 rpm"
    assert "Σ|i| 38.5 A (0.297 pu), ripple 0 %, copper 29.3 W" in numbers[f"{told} at 1500 rpm"]
    assert numbers["PM AC, a sine as high, 1.5 kW"] == "nowhere up to 6000 rpm"
    assert "from 558 to 6000 rpm at least" in found.finding.statement
