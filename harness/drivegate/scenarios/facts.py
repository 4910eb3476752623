"""The facts of a scenario: what of it is not as in the plain run, rated torque at the highest required speed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any, Final

from drivegate.scenarios.drive_scale import scale_of_mapping
from drivegate.scenarios.title import stated_supply
from drivegate_cases.documents.wording import figure
from drivegate_cases.drive.drive_document import PM_AC
from drivegate_cases.drive.limits import rounded
from drivegate_cases.drive.plant import FACTOR_SYMBOLS, NOMINAL
from drivegate_cases.scenario.courses import PARAMETERS, stated_profiles
from drivegate_cases.scenario.failure import PHASED
from drivegate_cases.scenario.scenario import LONGEST_CONTROL_PERIOD_S, Scenario
from drivegate_models.units import RADIANS_PER_RPM

PLAIN_RUN: Final = "the plain run"
"""What is said of a scenario without any fact."""

_TOLD_ELSEWHERE: Final = frozenset({"schema", "name", "description", "drive", "seed", "initial_speed_rpm"})
_TORQUE_DIGITS: Final = 3
_UNITS: Final = {"torque_nm": "N·m", "power_w": "W"}


def facts_of(scenario: Mapping[str, Any]) -> tuple[str, ...]:
    """State what of a scenario, as plain data, is not as in the plain run; one text for each key that differs."""
    if scenario.get("kind") == "script":
        return (f"a script of {len(scenario.get('rows', ()))} rows",)
    return tuple(fact for key in scenario if key not in _TOLD_ELSEWHERE for fact in _facts(key, scenario))


def facts_in_short(scenario: Mapping[str, Any]) -> str:
    """State the facts of a scenario in one line."""
    return ", ".join(facts_of(scenario)) or PLAIN_RUN


def _facts(key: str, scenario: Mapping[str, Any]) -> Iterator[str]:
    words = _WORDS.get(key)
    return _other(key, scenario[key]) if words is None else words(scenario)


def _other(key: str, value: Any) -> Iterator[str]:
    """Describe a key that has no words of its own; each entry of a list is a fact."""
    field = Scenario.model_fields.get(key)
    default = None if field is None else field.get_default(call_default_factory=True)
    if value == default or (not value and not default):
        return
    for entry in value if isinstance(value, (list, tuple)) else (value,):
        yield f"{key.replace('_', ' ')} {entry:g}" if isinstance(entry, float) else f"{key}: {entry}"


def _plain_speed(scenario: Mapping[str, Any]) -> float:
    return float(scenario["drive"]["rating"]["highest_speed_rpm"])


def _coming_on(scenario: Mapping[str, Any]) -> list[list[float]]:
    return [[0.0, 0.0], [scale_of_mapping(scenario["drive"]).load_ramp_s, 1.0]]


def _load(scenario: Mapping[str, Any]) -> Iterator[str]:
    load = scenario["load"]
    kind = load["kind"].replace("_", " ")
    if kind == "dynamometer":
        yield f"torque reference {_course(load['torque_reference_nm'], 'N·m')}"
        return
    coming_on = _coming_on(scenario)
    factor = load.get("factor", coming_on)
    if kind == "vehicle":
        yield f"a vehicle of {load['mass_kg']:g} kg"
        if any(grade for _, grade in load["grade_percent"]):
            yield f"grade {_course(load['grade_percent'], '%')}"
        return
    if not any(share for _, share in factor):
        yield "unloaded"
        return
    rated = float(scenario["drive"]["rating"]["rated_power_w"]) / (_plain_speed(scenario) * RADIANS_PER_RPM)
    if kind != "constant torque" or load["torque_nm"] != rounded(rated, _TORQUE_DIGITS):
        sizes = [f"{load[name]:g} {unit}" for name, unit in _UNITS.items() if name in load]
        yield " ".join((kind, *sizes))
    if _listed(factor) != coming_on:
        switched = factor[_listed(factor)[:1] == coming_on[:1] :]
        yield f"{_course(switched, '% of the load', 100.0)}"


def _control_period(scenario: Mapping[str, Any]) -> Iterator[str]:
    """Name a control period that the scenario chooses; that of a PM AC drive follows from its carrier."""
    period = scenario["control_period_s"]
    if scenario["drive"]["kind"] != PM_AC and period != LONGEST_CONTROL_PERIOD_S:
        yield f"control period s {period:g}"


def _sensors(scenario: Mapping[str, Any]) -> Iterator[str]:
    sensors, seed = scenario["sensors"], scenario.get("seed", 0)
    kind = sensors if isinstance(sensors, str) else sensors["kind"]
    if kind != "ideal":
        switches = " with Hall switches" if kind == "shunts" and _position(scenario) == "hall" else ""
        yield f"{kind} sensors{switches}" + (f" of seed {seed}" if seed else "")


def _position(scenario: Mapping[str, Any]) -> str:
    """Return what shows angle and speed of a shaft seen with shunts."""
    sensors, stated = scenario["sensors"], (scenario["drive"].get("sensing") or {}).get("position", "exact")
    own = "encoder" if stated == "exact" else stated
    return str(own if isinstance(sensors, str) else sensors.get("position", own))


def _speed(scenario: Mapping[str, Any]) -> Iterator[str]:
    profile = scenario["speed_rpm"]
    if _listed(profile) != [[0.0, _plain_speed(scenario)]]:
        yield _course(profile, "rpm")
    if scenario.get("initial_speed_rpm", profile[0][1]) != profile[0][1]:
        yield f"starting from {scenario['initial_speed_rpm']:g} rpm"


def _supply(scenario: Mapping[str, Any]) -> Iterator[str]:
    if scenario["supply_v"]:
        name, volts = stated_supply(scenario["drive"]["kind"], scenario["supply_v"])
        yield f"{name} {_course(volts, 'V')}"


def _imbalance(scenario: Mapping[str, Any]) -> Iterator[str]:
    if scenario["imbalance"]:
        yield f"halves of the supply apart by {_course(scenario['imbalance'], '%', 100.0)}"


def _scales(scenario: Mapping[str, Any]) -> Iterator[str]:
    for name, value in scenario["scales"].items():
        if value != getattr(NOMINAL, name):
            symbol = FACTOR_SYMBOLS.get(name)
            yield f"friction + {value:g} N·m" if symbol is None else f"{symbol} × {value:g}"


def _drift(scenario: Mapping[str, Any]) -> Iterator[str]:
    for quantity in PARAMETERS:
        if profile := quantity.stated(scenario):
            yield f"{quantity.symbol} {quantity.verb} by {_course(profile, quantity.unit)}"


def _dropouts(scenario: Mapping[str, Any]) -> Iterator[str]:
    for lost in scenario["dropouts"]:
        yield f"{lost['signal']} lost for {1e3 * lost['duration_s']:g} ms at {lost['start_s']:g} s"


def _glitches(scenario: Mapping[str, Any]) -> Iterator[str]:
    for false in scenario["glitches"]:
        yield f"{false['counts']:+d} encoder counts at {false['time_s']:g} s"


def _failure(scenario: Mapping[str, Any]) -> Iterator[str]:
    if failure := scenario["failure"]:
        phase = f" {failure['phase']}" if failure["kind"] in PHASED else ""
        phase += f" by {failure['slip_deg']:g}°" if failure.get("slip_deg") is not None else ""
        yield f"{failure['kind']}{phase} at {failure['time_s']:g} s"


def _duration(scenario: Mapping[str, Any]) -> Iterator[str]:
    """Describe a run that goes on for longer than a whole steady stretch after its last change."""
    scale = scale_of_mapping(scenario["drive"])
    needed = _last_time(scenario) + scale.load_ramp_s + scale.dwell_s + scale.time_unit_s
    if scenario["duration_s"] > needed:
        yield f"for {scenario['duration_s']:g} s"


def _last_time(scenario: Mapping[str, Any]) -> float:
    """Return the time at which the last change is over."""
    times = [point[0] for _, profile in stated_profiles(scenario) for point in profile]
    times += [lost["start_s"] + lost["duration_s"] for lost in scenario.get("dropouts", ())]
    times += [false["time_s"] for false in scenario.get("glitches", ())]
    return max(times, default=0.0)


def _course(profile: Sequence[Sequence[float]], unit: str, scale: float = 1.0) -> str:
    """State the values of a profile, and when they change."""
    values = [value for _, value in profile]
    levels = [value for place, value in enumerate(values) if place == 0 or value != values[place - 1]]
    times = dict.fromkeys(f"{before[0]:g}" for before, after in pairwise(profile) if before[1] != after[1])
    words = f"{' → '.join(figure(scale * value) for value in levels)} {unit}"
    return f"{words} at {', '.join(times)} s" if times else words


def _listed(profile: Sequence[Sequence[float]]) -> list[list[float]]:
    return [[float(number) for number in point] for point in profile]


_WORDS: Final[Mapping[str, Callable[[Mapping[str, Any]], Iterator[str]]]] = {
    "duration_s": _duration,
    "control_period_s": _control_period,
    "speed_rpm": _speed,
    "load": _load,
    "supply_v": _supply,
    "imbalance": _imbalance,
    "sensors": _sensors,
    "scales": _scales,
    "drift": _drift,
    "dropouts": _dropouts,
    "glitches": _glitches,
    "failure": _failure,
}
"""How a key of a scenario is named in texts; the others have their own names."""
