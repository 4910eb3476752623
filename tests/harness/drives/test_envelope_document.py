"""What a result states of its drive: at few speeds, and nothing else than `drivegate drive` states at many."""

from __future__ import annotations

import pytest

from drivegate.drives.angle_ability import facts, required
from drivegate.drives.envelope import few_speeds_of, recommended_line, speed_point, speeds_of
from drivegate.drives.envelope_document import envelope_document, envelope_of
from drivegate.drives.rating import rated_drive
from drivegate.results.result import finite
from drivegate_cases.drive.drive_document import load_drive


@pytest.fixture(scope="module")
def fan():
    return load_drive("fan-3-phase")


def test_few_speeds_are_of_the_many_with_base_highest_and_overspeed_among_them() -> None:
    rating = rated_drive(load_drive("paper-5-phase")).rating
    few, many = few_speeds_of(rating), speeds_of(rating)
    assert list(few) == sorted(set(few) & set(many))
    assert {rating.base_speed, rating.highest_speed, rating.overspeed} <= set(few)
    assert few[0] < rating.base_speed
    assert len(few) < len(many) / 2


def test_at_few_speeds_a_drive_can_do_the_same_as_at_many(fan) -> None:
    drive = rated_drive(fan)
    line = recommended_line(drive)
    points = [speed_point(drive, line, speed) for speed in speeds_of(drive.rating)]
    whole = finite(envelope_document(drive, line, points))
    few = finite(envelope_of(fan))
    assert {key: few[key] for key in few if key != "points"} == {
        key: whole[key] for key in whole if key != "points"
    }
    assert [point for point in whole["points"] if point in few["points"]] == few["points"]
    assert facts(few) == facts(whole)


def test_words_of_a_result_are_those_of_what_was_computed(fan) -> None:
    without_resistance = fan.replaced(resistance_ohm=0.0)
    computed = envelope_of(without_resistance)
    assert facts(finite(computed)) == facts(computed)
    assert "L/R endless" in facts(computed)[2]


def test_rated_torque_out_of_reach_at_base_speed_is_said() -> None:
    star = facts(envelope_of(load_drive("star-3-phase")))
    (sentence,) = (fact for fact in star if "out of reach" in fact)
    assert sentence.startswith("rated torque is out of reach at 500 rpm, where the current limit leaves 28.")
    assert not any("out of reach" in fact for fact in facts(envelope_of(load_drive("star-3-phase-150-emf"))))


def test_requirements_are_reported_in_the_numbers_of_the_drive() -> None:
    of_search, of_torque = required(
        load_drive("paper-5-phase").replaced(speed_tolerance_rpm=4.0, settling_s=8.0)
    )
    assert "from 8 s after a change on" in of_search
    assert "within 4 rpm (k1)" in of_search
    assert "13 %" in of_torque
    assert "20 %" in of_torque
