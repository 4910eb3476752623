"""The table of angles: the packaged one is what the oracle gives, and a computed one costs little more."""

from math import degrees

import numpy as np
import pytest

from drivegate_cases.drive.drive_document import load_drive
from drivegate_lab.candidates.angle_table import LOADS, angle_table
from drivegate_lab.kernels.designs.table_values import (
    ANGLES_DEG,
    CURRENT_SUMS,
    DRIVE,
    FIRST_SPEED_RPM,
    SHARES,
    SPEED_STEP_RPM,
)
from drivegate_models.steady.oracle import least_current_sum
from drivegate_models.units import RADIANS_PER_RPM

PAPER = load_drive(DRIVE)
# Half of the last decimal that is written.
ANGLE_DECIMAL_DEG, SUM_DECIMAL = 0.05, 0.005


def speed_of_row(row: int) -> float:
    return (FIRST_SPEED_RPM + SPEED_STEP_RPM * row) * RADIANS_PER_RPM


def test_rows_of_the_table_that_comes_along_are_computed_to_its_last_decimal() -> None:
    rows = (10, 32)
    first, last = map(speed_of_row, rows)
    found = angle_table(PAPER.plant(), first, last, 2, PAPER.rating.rated_power_w, banded=True)
    packaged = [np.array(table)[list(rows)] for table in (ANGLES_DEG, CURRENT_SUMS)]
    assert LOADS == SHARES
    np.testing.assert_allclose(np.degrees(found.angles), packaged[0], rtol=0.0, atol=ANGLE_DECIMAL_DEG + 1e-9)
    np.testing.assert_allclose(found.current_sums, packaged[1], rtol=0.0, atol=SUM_DECIMAL + 1e-9)


@pytest.mark.parametrize("name", ["fan-3-phase", "traction-7-phase"])
def test_an_angle_of_a_computed_table_costs_little_more_than_the_least(name: str) -> None:
    drive = load_drive(name)
    rating, plant = drive.rating, drive.plant()
    first, last = (speed * rating.base_speed_rpm * RADIANS_PER_RPM for speed in (1.5, 3.0))
    found = angle_table(plant, first, last, 3, rating.rated_power_w)
    assert (np.diff(found.angles) >= 0.0).all(), "an angle falls with load"
    assert (np.diff(found.current_sums) > 0.0).all(), "a current sum falls with load"
    for row, column in ((0, 5), (0, 9), (1, 9), (2, 5), (2, 9)):
        speed = first + row * found.speed_step
        least = least_current_sum(plant, speed, LOADS[column] * rating.rated_power_w / speed)
        excess = found.current_sums[row, column] / least.current_sum - 1.0
        angles = degrees(found.angles[row, column]), degrees(least.advance)
        assert -1e-3 < excess < 0.012, f"{100 * excess:.2f} % at {angles[0]:.1f}° instead of {angles[1]:.1f}°"


def test_where_no_angle_gives_the_torque_the_row_goes_on_in_proportion() -> None:
    weak = PAPER.replaced(current_limit_a=24.0).plant()
    speed = speed_of_row(0)
    found = angle_table(weak, speed, 1.1 * speed, 2, PAPER.rating.rated_power_w)
    sums, angles = found.current_sums[0], np.degrees(found.angles[0])
    assert sums[-1] / sums[-2] == pytest.approx(1.1)
    assert angles[-1] - angles[-2] == pytest.approx(4.0)
