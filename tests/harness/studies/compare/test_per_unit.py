"""Per-unit bases and the names of drives that are compared."""

import pytest

from drivegate.studies.compare.compare import drive_labels
from drivegate.studies.compare.drive_comparison import bases_of
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError

PAPER, FAN = load_drive("paper-5-phase"), load_drive("fan-3-phase")


def test_the_bases_are_those_of_the_rating():
    bases = bases_of(PAPER)
    assert (bases.speed_rpm, bases.power_w, bases.current_sum_a) == (500.0, 1500.0, 130.0)
    assert bases.torque_nm == pytest.approx(28.648, abs=5e-4), "rated power at base speed"


def test_drives_go_by_their_names():
    assert drive_labels((PAPER, FAN)) == ("paper-5-phase", "fan-3-phase")


def test_drives_of_one_name_are_reported_apart_by_their_hashes():
    other = PAPER.replaced(resistance_ohm=0.1)
    labels = drive_labels((PAPER, FAN, other))
    assert labels == (
        f"paper-5-phase ({PAPER.values_hash[:8]})",
        "fan-3-phase",
        f"paper-5-phase ({other.values_hash[:8]})",
    )


def test_a_drive_is_refused_beside_itself_whatever_its_name():
    with pytest.raises(InputError, match="'paper-5-phase' and 'mine' have the same values"):
        drive_labels((PAPER, FAN, PAPER.replaced(name="mine")))
