"""Ratings that no controller can meet are found, and what is offered instead can be met."""

import math
from typing import Any

import pytest

from drivegate.drives.abilities import refusals, refuse_unreachable, unreachable_rating
from drivegate.drives.power_reach import UnreachableRating
from drivegate.drives.rating import RatedDrive, rated_drive
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM


def drive_with(**changes: Any) -> RatedDrive:
    return rated_drive(load_drive("paper-5-phase").replaced(**changes))


def unreachable(**changes: Any) -> UnreachableRating:
    found = unreachable_rating(load_drive("paper-5-phase").replaced(**changes))
    assert found is not None
    return found


def test_the_papers_rating_is_the_papers() -> None:
    rating = drive_with().rating
    speeds = (rating.base_speed, rating.lowest_speed, rating.highest_speed, rating.overspeed)
    assert [round(speed / RADIANS_PER_RPM, 6) for speed in speeds] == [500.0, 550.0, 1500.0, 2000.0]
    assert rating.power == 1500.0
    assert drive_with().ideal.hysteresis_band == 0.0


def test_the_papers_rating_can_be_met() -> None:
    assert unreachable_rating(load_drive("paper-5-phase")) is None


def test_too_little_current_is_reported_with_every_way_out() -> None:
    found = unreachable(current_limit_a=20.0)
    assert found.speed == pytest.approx(550.0 * RADIANS_PER_RPM)
    assert found.sentence() == (
        "1.5 kW needs 26.0 N·m at 550 rpm, but at the current limit of 20 A this drive delivers at most 23.1 N·m "
        "(1.33 kW) there; a check accepts rated_power_w = 1320, or current_limit_a = 23.6, or base_speed_rpm = 630"
    )


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    "changes",
    [{"current_limit_a": 20.0}, {"supply_voltage_v": 30.0}, {"inductance_h": 0.01}, {"friction_n_m": 4.0}],
)
def test_a_check_accepts_what_a_refusal_names_and_no_more_power(changes: dict[str, float]) -> None:
    document = load_drive("paper-5-phase").replaced(
        **changes, hysteresis_band_a=0.0, ripple_percent=40.0, point=()
    )
    found = unreachable_rating(document)
    assert found is not None
    for named in found.accepted:
        assert refusals(document.replaced(**named)) == (), f"{named} is refused"
    more = 1.011 * found.nearest_power
    assert refusals(document.replaced(rated_power_w=more)), f"{more} W can be met, too"


@pytest.mark.parametrize("limit", [2.0, 20.0])
def test_the_nearest_limit_suffices_and_a_little_less_does_not(limit: float) -> None:
    nearest = unreachable(current_limit_a=limit).nearest_limit
    assert nearest is not None
    assert unreachable_rating(load_drive("paper-5-phase").replaced(current_limit_a=nearest)) is None
    assert unreachable(current_limit_a=0.97 * nearest)


def test_where_the_supply_is_what_lacks_more_current_is_said_not_to_help() -> None:
    found = unreachable(supply_voltage_v=30.0)
    assert found.nearest_limit is None
    assert found.sentence().endswith("; more current alone would not help")


def test_a_drive_that_cannot_even_turn_itself_is_reported_so() -> None:
    found = unreachable(friction_n_m=100.0)
    assert found.nearest_power == 0.0
    assert "no power can be met" in found.sentence()
    assert found.document()["nearest_power_w"] == 0.0


def test_its_plain_data_has_peoples_units_and_finite_numbers() -> None:
    document = unreachable(current_limit_a=20.0).document()
    assert document["key"] == "rated_power_w"
    assert document["speed_rpm"] == pytest.approx(550.0)
    assert document["nearest_range_rpm"] == pytest.approx([692.5, 1500.0])
    numbers = [value for value in document.values() if isinstance(value, float)]
    assert all(map(math.isfinite, numbers))


def test_a_drive_that_would_take_for_ever_is_refused_with_what_makes_it_slow() -> None:
    slow = load_drive("paper-5-phase").replaced(inertia_kg_m2=1e6, hysteresis_band_a=0.0)
    with pytest.raises(
        InputError,
        match=r"'paper-5-phase' is too slow to be checked: .*; a check accepts inertia_kg_m2 = 24\.8$",
    ):
        refuse_unreachable(slow)
    (found,) = refusals(slow)
    assert refusals(slow.replaced(**found.accepted[0])) == ()


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("name", "changes", "key"),
    [
        ("pm-ac-interior", {"rated_power_w": 900.0}, "rated_power_w"),
        ("pm-ac-interior", {"inertia_kg_m2": 1e3}, "inertia_kg_m2"),
        ("pm-ac-interior", {"highest_speed_rpm": 20000.0, "overspeed_rpm": 20000.0}, "current_limit_a"),
        ("star-24v-3-phase", {"current_limit_a": 3.0, "hysteresis_band_a": 0.0}, "rated_power_w"),
        ("star-24v-3-phase", {"base_speed_rpm": 0.01, "hysteresis_band_a": 0.0}, "base_speed_rpm"),
    ],
)
def test_a_check_accepts_every_value_that_a_refusal_names(
    name: str, changes: dict[str, float], key: str
) -> None:
    document = load_drive(name).replaced(**changes)
    found, *_ = refusals(document)
    assert key in found.accepted[0]
    for named in found.accepted:
        after = refusals(document.replaced(**named))
        assert not any(isinstance(other, type(found)) for other in after), f"{named} is refused"


def test_a_rated_torque_beyond_all_machines_is_refused() -> None:
    with pytest.raises(InputError, match=r"takes 1.06e\+09 N·m at 9 rpm, but must take at most 1e\+09 N·m"):
        load_drive("pm-ac-interior").replaced(rated_power_w=1e9, base_speed_rpm=9.0)
