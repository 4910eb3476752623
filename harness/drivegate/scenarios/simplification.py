"""How complicated a scenario is, and how a simplification is applied to it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final, TypeAlias

from drivegate.scenarios.facts import facts_of
from drivegate.scenarios.traits import traits_of
from drivegate_cases.drive.plant import NOMINAL
from drivegate_cases.scenario.control_periods import on_whole_periods
from drivegate_cases.scenario.courses import COURSES, stated_profiles
from drivegate_cases.scenario.load import DynamometerLoad
from drivegate_cases.scenario.profile import dwell_torque, dwells
from drivegate_cases.scenario.scenario import LONGEST_CONTROL_PERIOD_S, Scenario
from drivegate_cases.scenario.sensors import IDEAL, PLAIN
from drivegate_models.errors import InputError

_FACT, _FAILURE, _PARAMETER, _POINT, _LOAD, _SENSE, _SEED, _DIGIT = 1500, 2000, 1000, 300, 100, 30, 20, 5
FAILURES: Final = ("dropouts", "glitches", "restarts_s", "current_errors")
"""Keys of what can go wrong more than once."""
PLAIN_BEGINNING: Final[dict[str, float]] = {
    "control_period_s": LONGEST_CONTROL_PERIOD_S,
    "clock_start_s": 0.0,
    "initial_angle_deg": 0.0,
}
"""How a plain run begins, and how often it steps."""
PM_AC: Final = "pm-ac"
"""Kind of the drives whose controllers follow torques."""
_LOAD_KINDS: Final = {
    "locked": 0,
    "dynamometer": 0,
    "constant_torque": 0,
    "hoist": 1,
    "constant_power": 1,
    "fan": 2,
    "vehicle": 4,
}
Fields: TypeAlias = dict[str, Any]
Simplification: TypeAlias = Callable[[Scenario], Iterator[Fields]]
"""From a scenario to changes that make it simpler in one respect, the boldest first."""


def size_of(scenario: Mapping[str, Any]) -> int:
    if scenario.get("kind") == "script":
        return _leaves(scenario)
    failures = sum(len(scenario.get(key, ())) for key in FAILURES)
    faults = sum(
        quantity.role == "fault" and quantity.key(scenario) is not None for quantity in COURSES.values()
    )
    moved = sum(scenario.get(key, plain) != plain for key, plain in PLAIN_BEGINNING.items())
    load = scenario["load"]
    profiles = [profile for _, profile in stated_profiles(scenario)]
    numbers = [number for profile in profiles for point in profile for number in point]
    numbers += [value for key, value in load.items() if isinstance(value, float)]
    for key in ("dropouts", "glitches", "current_errors"):
        for failure in scenario.get(key, ()):
            numbers += [value for value in failure.values() if not isinstance(value, str)]
    numbers += scenario.get("restarts_s", ())
    numbers += [scenario[key] for key in PLAIN_BEGINNING if key in scenario]
    scales = scenario.get("scales", {})
    numbers += scales.values()
    parts = (
        _FACT * (len(facts_of(scenario)) - _plain_speed(scenario)),
        _FAILURE * (failures + faults + (scenario.get("failure") is not None)),
        _PARAMETER * len([key for key, value in scales.items() if value != getattr(NOMINAL, key)]),
        _sensor_size(scenario.get("sensors", "ideal")),
        _PARAMETER * moved,
        _SEED * (scenario.get("seed", 0) != 0),
        _POINT * sum(map(len, profiles)),
        _SENSE * _unplain_operation(scenario),
        _LOAD * _LOAD_KINDS[load["kind"]],
        _DIGIT * sum(map(_digits, numbers)),
        math.ceil(scenario["duration_s"]),
    )
    return int(sum(parts))


def _plain_speed(scenario: Mapping[str, Any]) -> int:
    """Count the fact that a speed of a PM AC drive is not the highest: torque is followed at any constant one."""
    is_constant = len({speed for _, speed in scenario["speed_rpm"]}) == 1
    if not is_constant or scenario.get("drive", {}).get("kind") != PM_AC:
        return 0
    return sum(bool(trait.fact) for trait in traits_of("speed_rpm", scenario))


def _unplain_operation(scenario: Mapping[str, Any]) -> int:
    """Count what is not plain about the operating point: a shaft that turns, above base speed, backward, or braked."""
    speeds = [scenario.get("initial_speed_rpm", 0.0), *(speed for _, speed in scenario.get("speed_rpm", ()))]
    torques = [torque for _, torque in scenario["load"].get("torque_reference_nm", ())]
    fastest = max(map(abs, speeds))
    base = scenario.get("drive", {}).get("rating", {}).get("base_speed_rpm", math.inf)
    return sum((fastest > 0.0, fastest > base, min(speeds) < 0.0, min(torques, default=0.0) < 0.0))


def _leaves(value: object) -> int:
    if isinstance(value, Mapping):
        return sum(map(_leaves, value.values()))
    if isinstance(value, Sequence) and not isinstance(value, str):
        return sum(map(_leaves, value))
    return 1


def _sensor_size(sensors: str | Mapping[str, Any]) -> int:
    keys = {"kind": sensors} if isinstance(sensors, str) else sensors
    if keys["kind"] == IDEAL.kind:
        return 0
    plain = PLAIN[keys["kind"]]
    return _PARAMETER + _LOAD * len(
        [key for key, value in keys.items() if getattr(plain, key) not in (None, value)]
    )


def to_whole(grain: float) -> Callable[[float], float]:
    """Return the function that rounds to whole grains."""
    return lambda value: round(round(value / grain) * grain, 9)


def nominal_parameters(scenario: Scenario) -> Iterator[Fields]:
    """Make one parameter of the plant nominal."""
    for key in type(NOMINAL).model_fields:
        yield {"scales": scenario.scales.model_copy(update={key: getattr(NOMINAL, key)})}


def _digits(number: float) -> int:
    """Count the digits that it takes to write a number, without zeros at its ends."""
    return len(f"{abs(number):.9f}".replace(".", "").strip("0"))


def simplified(scenario: Scenario, fields: Fields) -> Scenario | None:
    """Apply a change, if it gives a valid and simpler scenario that is still loaded where it was.

    A shaft without a load needs hardly any current, so that shares of it say little: a failure there would be another
    one. A torque of 0 on a dynamometer is a reference like any other.
    """
    period = fields.get("control_period_s", scenario.control_period_s)
    if "duration_s" in fields:
        fields = fields | {"duration_s": on_whole_periods(fields["duration_s"], period)}
    try:
        simpler = scenario.replaced(**fields)
    except InputError:
        return None
    is_load = not isinstance(simpler.load, DynamometerLoad)
    if is_load and _is_loaded(scenario) and not _is_loaded(simpler):
        return None
    return simpler if size_of(simpler.to_mapping()) < size_of(scenario.to_mapping()) else None


def _is_loaded(scenario: Scenario) -> bool:
    return any(dwell_torque(scenario, dwell) > 0.0 for dwell in dwells(scenario))
