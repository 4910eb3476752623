"""Current limit and rated power follow from the currents of a data sheet, and contradictions are refused."""

import math
from collections.abc import Callable
from typing import Any

import pytest

from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.data_sheet import USABLE_SHARE, following
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.drive_file import drive_schema, drive_toml

KINDS = ("paper-5-phase", "star-24v-3-phase", "pm-ac-interior")


def parsed(name: str, *left_out: str, **rating: Any) -> DriveDocument:
    """Load a packaged drive whose rating leaves out some keys and has others; without an ideal regulator's band."""
    drive = load_drive(name)
    mapping = drive.to_mapping()
    if drive.contract == "current":
        mapping["inverter"]["hysteresis_band_a"] = 0.0
    kept = {key: value for key, value in mapping["rating"].items() if key not in left_out}
    return parse_document({**mapping, "rating": kept | rating}, DriveDocument, "mine.toml")


@pytest.mark.parametrize("name", KINDS)
def test_the_limit_is_the_peak_current_and_else_the_continuous_one(name: str) -> None:
    limit = load_drive(name).rating.current_limit_a
    both = parsed(name, "current_limit_a", continuous_current_a=limit, peak_current_a=1.5 * limit)
    assert both.rating.current_limit_a == 1.5 * limit
    assert following(both) == {"current_limit_a": "peak_current_a"}
    one = parsed(name, "current_limit_a", continuous_current_a=limit)
    assert one.rating.current_limit_a == limit
    assert following(one) == {"current_limit_a": "continuous_current_a"}


@pytest.mark.parametrize("name", KINDS)
def test_rated_power_is_what_the_continuous_current_produces_with_a_reserve(name: str) -> None:
    limit = load_drive(name).rating.current_limit_a
    drive = parsed(
        name, "current_limit_a", "rated_power_w", continuous_current_a=limit, peak_current_a=2.0 * limit
    )
    rating = drive.rating
    speeds = [math.radians(6.0 * rpm) for rpm in (rating.base_speed_rpm, rating.highest_speed_rpm)]
    for speed in speeds:
        friction = drive.machine.friction_n_m + drive.machine.viscous_friction_n_m_s_per_rad * speed
        produced = USABLE_SHARE * drive.greatest_torque(limit, speed) - friction
        assert rating.rated_power_w <= produced * speed * (1.0 + 1e-9)
    assert rating.rated_power_w == float(f"{rating.rated_power_w:.3g}")
    assert rating.rated_power_w > 0.6 * load_drive(name).rating.rated_power_w
    assert set(following(drive)) == {"current_limit_a", "rated_power_w"}


def test_a_drive_with_values_that_follow_is_the_same_when_it_is_read_again() -> None:
    drive = parsed("pm-ac-interior", "rated_power_w", "current_limit_a", continuous_current_a=5.0)
    again = parse_document(drive.to_mapping(), DriveDocument, "again")
    assert again == drive
    assert again.values_hash == drive.values_hash
    assert following(again) == following(drive)


def test_values_that_follow_change_with_what_they_follow_from() -> None:
    drive = parsed("pm-ac-interior", "rated_power_w", "current_limit_a", continuous_current_a=5.0)
    more = drive.with_overrides(["continuous_current_a=6"])
    assert more.rating.current_limit_a == 6.0
    assert more.rating.rated_power_w > drive.rating.rated_power_w
    stated = drive.with_overrides(["rated_power_w=300", "peak_current_a=9"])
    assert (stated.rating.rated_power_w, stated.rating.current_limit_a) == (300.0, 9.0)
    assert set(following(stated)) == {"current_limit_a"}


@pytest.mark.parametrize(
    ("name", "rating", "reported"),
    [
        (
            "pm-ac-interior",
            {"continuous_current_a": 5.0, "peak_current_a": 4.0},
            "'continuous_current_a' is 5, but must be at most the peak current, and peak_current_a is 4",
        ),
        (
            "star-24v-3-phase",
            {"peak_current_a": 5.0},
            "'current_limit_a' is 5.4, but must be at most the peak current, and peak_current_a is 5",
        ),
        (
            "pm-ac-interior",
            {"continuous_current_a": 4.0},
            "'rating.continuous_current_a' is 4, which produces at most 1.21 N·m, but rated_power_w = 500 needs 2.27 "
            "N·m at 2100 rpm; state the peak value, 1.414 times the rms value of a data sheet, or leave rated_power_w "
            "out",
        ),
        (
            "paper-5-phase",
            {"continuous_current_a": 18.0},
            "but rated_power_w = 1500 needs 28.6 N·m at 500 rpm",
        ),
        (
            "star-24v-3-phase",
            {"continuous_current_a": 2.5},
            "which produces at most 0.0875 N·m, but rated_power_w = 42 needs 0.115 N·m",
        ),
        ("star-24v-3-phase", {"continuous_current_a": -1.0}, "must be greater than 0"),
    ],
)
def test_contradictions_are_refused_with_the_numbers(
    refusal: Callable[..., str], name: str, rating: dict[str, float], reported: str
) -> None:
    assert reported in refusal(parsed, name, **rating)


def test_a_wrong_value_elsewhere_is_what_is_reported(refusal: Callable[..., str]) -> None:
    message = refusal(
        parsed, "pm-ac-interior", "rated_power_w", continuous_current_a=5.0, base_speed_rpm="fast"
    )
    assert message.count("the key") == 1
    assert "'rating.base_speed_rpm'" in message


def test_a_rating_without_any_current_or_power_names_what_is_missing(refusal: Callable[..., str]) -> None:
    message = refusal(parsed, "pm-ac-interior", "rated_power_w", "current_limit_a")
    assert "'rating.rated_power_w' is missing" in message
    assert "'rating.current_limit_a' is missing" in message
    assert "peak_current_a, or else continuous_current_a" in message


def test_a_current_that_produces_no_power_at_the_highest_speed_is_refused(
    refusal: Callable[..., str],
) -> None:
    message = refusal(
        parsed,
        "pm-ac-interior",
        "rated_power_w",
        continuous_current_a=5.0,
        highest_speed_rpm=60_000.0,
        overspeed_rpm=60_000.0,
    )
    assert (
        "no power follows: a continuous current of 5 A produces none at some speed from 2100 to 60000"
        in message
    )


def test_a_wrong_unit_is_named_where_no_power_follows_because_of_it(refusal: Callable[..., str]) -> None:
    mapping = load_drive("pm-ac-interior").to_mapping()
    mapping["machine"]["magnet_flux_v_s"] = 22.5
    mapping["rating"] |= {"continuous_current_a": 5.0, "rated_power_w": None}
    message = refusal(parse_document, mapping, DriveDocument, "mine.toml")
    assert "no power follows: the drive's magnet_flux_v_s is 22.5, but usual" in message
    assert message.endswith("volts per 1000 turns a minute or turns a minute per volt?")


@pytest.mark.parametrize("name", KINDS)
def test_the_template_and_the_schema_know_the_keys(name: str) -> None:
    text = drive_toml(load_drive(name))
    assert "# continuous_current_a =" in text
    assert "# peak_current_a =" in text
    ratings = [value for key, value in drive_schema()["$defs"].items() if key == "Rating"]
    for schema in ratings:
        assert set(schema["required"]) == {"base_speed_rpm", "highest_speed_rpm", "overspeed_rpm"}
