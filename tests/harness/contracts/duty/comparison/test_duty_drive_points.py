"""Operating points of controllers of duty ratios in a comparison of drives."""

from math import pi

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.comparison import ComparisonRequest
from drivegate.contracts.duty.comparison.declaration import EFFORTS, planned_duty_runs
from drivegate.contracts.duty.scenarios.building import torque_of
from drivegate.contracts.duty.scenarios.drawn_range import speed_of
from drivegate.studies.compare.compared_drive import ComparedDrive
from drivegate.studies.compare.drive_comparison import drive_rows, operating_points, summary_rows
from drivegate.studies.compare.engine import Compared
from drivegate.studies.compare.ranking import rows_of
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.drive_cycle import load_drive_cycle

SIZE = EFFORTS["quick"]
TORQUES = len(SIZE.torques)


def compared_on(name: str, lost: int | None = None) -> ComparedDrive:
    """Give 3 A along the magnet and 4 A across it, and a tenth more power than the shaft's, at every point but one."""
    drive = load_drive(name)
    assert isinstance(drive, PmAcDocument)
    one = Compared("foc", "foc", resolve_candidate("foc"))
    rated = drive.rating.rated_power_w / (drive.rating.base_speed_rpm * pi / 30.0)
    for index, share in enumerate(SIZE.speeds):
        speed = speed_of(drive, share)
        one.figures[index] = {
            "points": [
                {
                    "speed_rpm": speed,
                    "reference_nm": torque,
                    "torque_nm": torque,
                    "held": index * TORQUES + place != lost,
                    "direct_current_a": -3.0,
                    "quadrature_current_a": 4.0,
                    "input_power_w": 1.1 * torque * speed * pi / 30.0,
                    "ripple_percent": 100.0 * 0.05 * torque / rated,
                }
                for place, torque in enumerate(torque_of(drive, speed, load) for load in SIZE.torques)
            ]
        }
    request = ComparisonRequest(drive, "quick", 0, load_drive_cycle("ece-15"))
    return ComparedDrive(request, planned_duty_runs(request), [one], {})


def test_points_are_matched_by_their_shares_and_written_alike() -> None:
    made = [compared_on("pm-ac-surface"), compared_on("pm-ac-interior", lost=0)]
    points = operating_points(("surface", "interior"), made)
    rows = rows_of(points)
    assert len(rows) == 2 * len(SIZE.speeds) * TORQUES
    for row in rows:
        assert row["current_sum_a"] == pytest.approx(30.0 / pi), "three sines of 5 A"
        assert row["ripple_percent"] == pytest.approx(5.0, rel=1e-3), "over the mean, not over rated torque"
        if row["held"]:
            assert row["efficiency_percent"] == pytest.approx(100.0 / 1.1)
    surface, interior = summary_rows(("surface", "interior"), made, points)
    assert (surface["points_held"], interior["points_held"]) == (15, 14)
    assert surface["points_shared"] == interior["points_shared"] == 14
    assert surface["rated_power_held_up_to_pu"] == pytest.approx(3.0)


def test_a_drive_is_listed_with_its_link_and_its_bases() -> None:
    from drivegate.drives.abilities import ability_of

    drive = load_drive("pm-ac-surface")
    assert isinstance(drive, PmAcDocument)
    (row,) = drive_rows(("surface",), [drive], [ability_of(drive).constant_power(drive)])
    assert (row["supply_voltage_v"], row["phases"], row["base_current_sum_a"]) == (96.0, 3, 78.0)
    assert row["base_torque_nm"] == pytest.approx(700.0 / (550.0 * pi / 30.0), rel=1e-6)
    assert row["constant_power_up_to_pu"] == pytest.approx(1900.0 / 550.0, rel=1e-6)
