"""How far drives keep rated power."""

import pytest

from drivegate.drives.constant_power import constant_power, greatest_shaft_power
from drivegate.drives.rating import rated_drive
from drivegate_cases.drive.drive_document import load_drive

PAPER = load_drive("paper-5-phase")


def test_the_drive_of_the_paper_keeps_rated_power_to_overspeed():
    drive = rated_drive(PAPER)
    found = constant_power(drive)
    assert found.reached == drive.rating.overspeed
    assert found.speeds[-1] == pytest.approx(drive.rating.overspeed)
    assert min(found.powers) >= drive.rating.power


def test_where_power_runs_out_lies_between_a_speed_that_gives_it_and_one_that_does_not():
    # Friction in proportion to speed takes ever more of it.
    drive = rated_drive(PAPER.replaced(viscous_friction_n_m_s_per_rad=0.01))
    found = constant_power(drive)
    assert found.reached is not None
    assert drive.rating.lowest_speed < found.reached < drive.rating.overspeed
    assert greatest_shaft_power(drive, found.reached) >= drive.rating.power
    assert greatest_shaft_power(drive, 1.001 * found.reached) < drive.rating.power


def test_a_drive_too_weak_from_the_start_has_no_range():
    assert constant_power(rated_drive(PAPER.replaced(current_limit_a=15.0))).reached is None
