"""The values of a rating that follow from the continuous and the peak current of a data sheet."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Final

from pydantic import Field, ValidationError

from drivegate_cases.documents.wording import rounded_to_digits, shown
from drivegate_cases.drive.rating import FOLLOWING
from drivegate_cases.drive.usual_values import DriveValues, unusual_values
from drivegate_models.units import RADIANS_PER_RPM

_Sentence = Annotated[str, Field(max_length=1000)]
_COPIED: Final = re.compile(r"not stated; as in .*(, which has (?P<value>.*)| until it is changed)")
_LONGEST_COPY: Final = 500
Provenance = dict[str, dict[str, _Sentence]]
"""A sentence for each key of each table, written ``machine.phases = "stated: …"``."""
USABLE_SHARE: Final = 0.92
"""Share of the greatest torque that a rating may use; the rest is reserved for the regulator (1)."""
SPEEDS: Final = 21
"""Speeds from base speed to the highest at which the continuous current must produce the power that follows."""
_FOLLOWS: Final = "follows from "
_ANY_POWER: Final = 1e-6
_NO_POWER: Final = "the key 'rating.rated_power_w' is left out, and no power follows"
_TORQUE_SLACK: Final = 1.1
"""Rated torque over that of the continuous current which still counts as rounding of a data sheet (1)."""


def completed(
    values: Mapping[str, Any], parse: Callable[[Mapping[str, Any]], DriveValues]
) -> Mapping[str, Any]:
    """Fill in the current limit and the rated power of a drive's plain data, and state what they follow from."""
    rating = values.get("rating")
    if not isinstance(rating, Mapping):
        return values
    stated = {key: value for key, value in rating.items() if value is not None}
    found = {}
    source = next((key for key in ("peak_current_a", "continuous_current_a") if key in stated), None)
    if source is not None and "current_limit_a" not in stated:
        found["current_limit_a"] = stated[source]
        values = _with_rating(values, "current_limit_a", stated[source], source)
    if "continuous_current_a" in stated and "rated_power_w" not in stated:
        source = (
            f"continuous_current_a: {100.0 * USABLE_SHARE:g} % of the power that it produces at every speed from base "
            "speed to the highest"
        )
        values = _with_rating(values, "rated_power_w", _ANY_POWER, source)
        try:
            drive = parse(values)
        except ValidationError:
            # The values themselves are wrong, and their own validation says so.
            return values
        try:
            power = continuous_power(drive)
        except ValueError as error:
            slips = _wrong_units(drive)
            raise ValueError(f"{_NO_POWER}: {slips[0]}" if slips else str(error)) from error
        values = _with_rating(values, "rated_power_w", power, source)
    return values


def _wrong_units(drive: DriveValues) -> tuple[str, ...]:
    """Describe what looks like a wrong unit in a drive whose power does not follow."""
    supposed = drive.inverter.supply_voltage_v * drive.rating.current_limit_a
    return unusual_values(drive.replaced(rated_power_w=supposed, continuous_current_a=None))


def _with_rating(values: Mapping[str, Any], key: str, value: Any, source: str) -> dict[str, Any]:
    sentences = values.get("provenance") or {}
    if isinstance(sentences, Mapping):
        of_rating = sentences.get("rating") or {}
        sentences = {**sentences, "rating": {**of_rating, key: f"{_FOLLOWS}{source}"}}
    return {**values, "rating": {**values["rating"], key: value}, "provenance": sentences}


def following(drive: DriveValues) -> dict[str, str]:
    """Return what each value of the rating follows from that the drive's file leaves out, by its key."""
    sentences = drive.provenance.get("rating", {})
    return {
        key: sentences[key].removeprefix(_FOLLOWS)
        for key in FOLLOWING
        if sentences.get(key, "").startswith(_FOLLOWS)
    }


def continuous_power(drive: DriveValues) -> float:
    """Return the power that the continuous current gives from base speed to the highest, to three digits (W).

    It leaves the regulator its reserve, and does not depend on the rated power of the drive.
    """
    rating, machine = drive.rating, drive.machine
    current = min(rating.continuous_current_a or rating.current_limit_a, rating.current_limit_a)
    base, highest = rating.base_speed_rpm, rating.highest_speed_rpm
    step = (highest - base) / (SPEEDS - 1)
    powers = [
        (
            USABLE_SHARE * drive.greatest_torque(current, speed)
            - machine.friction_n_m
            - machine.viscous_friction_n_m_s_per_rad * speed
        )
        * speed
        for speed in ((base + place * step) * RADIANS_PER_RPM for place in range(SPEEDS))
    ]
    power = rounded_to_digits(min(powers), up=False)
    if power == 0.0:
        raise ValueError(
            f"{_NO_POWER}: a continuous current of {current:g} A "
            f"produces none at some speed from {base:g} to {highest:g} rpm; lower "
            "highest_speed_rpm, or raise the supply"
        )
    return power


def check_continuous_current(drive: DriveValues) -> None:
    """Refuse a rated power whose torque needs clearly more than the continuous current."""
    rating = drive.rating
    if rating.continuous_current_a is None:
        return
    needed = rating.rated_torque_nm
    torque = drive.torque_of_current(rating.continuous_current_a)
    if needed > _TORQUE_SLACK * torque:
        raise ValueError(
            f"the key 'rating.continuous_current_a' is {rating.continuous_current_a:g}, which produces at most "
            f"{torque:.3g} N·m, but rated_power_w = {rating.rated_power_w:g} needs {needed:.3g} N·m at "
            f"{rating.base_speed_rpm:g} rpm; state the peak value, 1.414 times the rms value of a "
            "data sheet, or leave rated_power_w out"
        )


def copied(name: str, value: object) -> str:
    """State that a value is that of another drive, and which value that is, so that a change of it shows."""
    text = str(value)
    return f"not stated; as in {name}, which has {text}" if len(text) <= _LONGEST_COPY else "not stated"


def origin(sentence: str, value: object) -> str:
    """Return what a drive says of a value, without what a change has made untrue."""
    found = _COPIED.fullmatch(sentence)
    if found is None or found["value"] == str(value):
        return sentence
    return "not stated"


def check_provenance(provenance: Provenance, tables: Mapping[str, tuple[str, ...]]) -> Provenance:
    """Check that sentences are of keys that there are."""
    for table, sentences in provenance.items():
        if table not in tables:
            raise ValueError(f"{shown(table)} is no table of a drive, which are {', '.join(tables)}")
        for key in sentences:
            if key not in tables[table]:
                raise ValueError(f"{shown(key)} is no key of the table '{table}'")
    return provenance
