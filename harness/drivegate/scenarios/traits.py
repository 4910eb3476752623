"""The traits of a scenario in words, from which its title, its facts and its line are made."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, Final, NamedTuple, TypeAlias

from drivegate.scenarios.course_words import (
    arrows,
    change_times,
    changes_at,
    changing,
    in_words,
    levels,
    listed,
    sequence,
)
from drivegate.scenarios.drive_scale import scale_of_mapping
from drivegate_cases.documents.wording import figure
from drivegate_cases.drive.drive_document import PM_AC, SPLIT_SUPPLY
from drivegate_cases.drive.limits import rounded
from drivegate_cases.drive.plant import FACTOR_SYMBOLS, NOMINAL
from drivegate_cases.scenario.courses import PARAMETERS, stated_profiles
from drivegate_cases.scenario.failure import PHASED
from drivegate_cases.scenario.scenario import LONGEST_CONTROL_PERIOD_S, Scenario
from drivegate_models.units import RADIANS_PER_RPM

_TORQUE_DIGITS: Final = 3
_UNITS: Final = {"torque_nm": "N·m", "power_w": "W"}
_SEEN: Final = {
    "hall": ("-hall", " with Hall switches"),
    "exact": ("-magnet", " and a magnet's on the shaft"),
}

Content: TypeAlias = Mapping[str, Any]
"""A scenario as plain data."""


class Trait(NamedTuple):
    """Something about a scenario; a text is empty where it says nothing."""

    label: str = ""
    """Part of its name."""
    words: str = ""
    """Part of its description."""
    fact: str = ""
    """What is not as in the plain run, rated torque at the highest required speed."""
    short: str = ""
    """Part of its line."""


def traits(scenario: Content) -> Iterator[Trait]:
    """List the traits of a scenario in the order of its title, which does not state the duration."""
    for key in _TRAITS:
        if key != "duration_s":
            yield from traits_of(key, scenario)


def traits_of(key: str, scenario: Content) -> Iterator[Trait]:
    """List the traits that a key of a scenario gives it."""
    if key not in _TRAITS:
        yield from _other(key, scenario[key])
    elif scenario.get(key):
        yield from _TRAITS[key](scenario)


def _other(key: str, value: Any) -> Iterator[Trait]:
    """Describe a key that has no words of its own; each entry of a list is a fact."""
    field = Scenario.model_fields.get(key)
    default = None if field is None else field.get_default(call_default_factory=True)
    if value == default or (not value and not default):
        return
    for entry in value if isinstance(value, (list, tuple)) else (value,):
        yield Trait(
            fact=f"{key.replace('_', ' ')} {entry:g}" if isinstance(entry, float) else f"{key}: {entry}"
        )


def _plain_speed(scenario: Content) -> float:
    return float(scenario["drive"]["rating"]["highest_speed_rpm"])


def _duration(scenario: Content) -> Iterator[Trait]:
    """Describe a run that goes on for longer than a whole steady stretch after its last change."""
    scale, duration = scale_of_mapping(scenario["drive"]), scenario["duration_s"]
    needed = _last_time(scenario) + scale.load_ramp_s + scale.dwell_s + scale.time_unit_s
    if duration > needed:
        yield Trait(fact=f"for {duration:g} s")


def _last_time(scenario: Content) -> float:
    """Return the time at which the last change is over."""
    times = [point[0] for _, profile in stated_profiles(scenario) for point in profile]
    times += [lost["start_s"] + lost["duration_s"] for lost in scenario.get("dropouts", ())]
    times += [false["time_s"] for false in scenario.get("glitches", ())]
    return max(times, default=0.0)


def _speed(scenario: Content) -> Iterator[Trait]:
    profile = scenario["speed_rpm"]
    label, words = f"{sequence(levels(profile))}rpm", changing(profile, "rpm")
    start = scenario.get("initial_speed_rpm", profile[0][1])
    starts_elsewhere = start != profile[0][1]
    if starts_elsewhere:
        label, words = f"{figure(start)}-to-{label}", f"{words}, starting from {figure(start)} rpm"
    is_plain = listed(profile) == [[0.0, _plain_speed(scenario)]]
    yield Trait(label, words, "" if is_plain else changes_at(profile, "rpm"), f"{arrows(profile)} rpm")
    if starts_elsewhere:
        yield Trait(fact=f"starting from {start:g} rpm")


def _load(scenario: Content) -> Iterator[Trait]:
    load = scenario["load"]
    sized = " ".join(
        (
            load["kind"].replace("_", " "),
            *(f"{load[key]:g} {unit}" for key, unit in _UNITS.items() if key in load),
        )
    )
    short = f"load {sized}" + (f" × {arrows(load['factor'])}" if "factor" in load else "")
    match load["kind"]:
        case "dynamometer":
            torque = load["torque_reference_nm"]
            words = f"held by a dynamometer, torque reference {changing(torque, 'N·m')}"
            fact = f"torque reference {changes_at(torque, 'N·m')}"
            yield Trait(f"torque-{sequence(levels(torque))}Nm", words, fact, short)
            if (released := load.get("released_s")) is not None:
                yield Trait("released", f"released at {released:.4g} s", f"shaft released at {released:g} s")
        case "locked":
            yield Trait("locked", "locked to a dynamometer", sized, short)
        case "vehicle":
            words, grade = f"a vehicle of {load['mass_kg']:g} kg", load["grade_percent"]
            yield Trait(f"vehicle-{load['mass_kg']:g}kg", words, words, short)
            if any(percent for _, percent in grade):
                label = f"grade-{sequence(levels(grade))}%"
                yield Trait(label, f"grade {changing(grade, '%')}", f"grade {changes_at(grade, '%')}")
        case _:
            yield from _switched(scenario, sized, short)


def _switched(scenario: Content, sized: str, short: str) -> Iterator[Trait]:
    """Describe a load and its shares, except for the rise from nothing to all of it."""
    load, factor = scenario["load"], scenario["load"]["factor"]
    values = levels(factor)
    if not any(values):
        yield Trait("unloaded", "unloaded", "unloaded", short)
        return
    rated = float(scenario["drive"]["rating"]["rated_power_w"]) / (_plain_speed(scenario) * RADIANS_PER_RPM)
    is_rated = load["kind"] == "constant_torque" and load["torque_nm"] == rounded(rated, _TORQUE_DIGITS)
    label, words = _whole(load)
    is_nothing = label in ("0Nm", "0W")
    if is_nothing:
        label = words = "unloaded"
    yield Trait(label, words, "" if is_rated else sized, short)
    comes_on = values[0] == 0.0
    shares = values[1:] if comes_on else values
    label = words = fact = ""
    if shares != [1.0] and not is_nothing:
        label = f"{sequence(shares, 100.0)}%"
        words = f"{in_words(shares, '% of it', 100.0)}{change_times(factor[comes_on:])}"
    coming_on = [[0.0, 0.0], [scale_of_mapping(scenario["drive"]).load_ramp_s, 1.0]]
    if (points := listed(factor)) != coming_on:
        fact = changes_at(points[points[:1] == coming_on[:1] :], "% of the load", 100.0)
    yield Trait(label, words, fact)


def _whole(load: Content) -> tuple[str, str]:
    """Return label and words of the whole of a load that is switched."""
    if load["kind"] == "constant_power":
        return f"{figure(load['power_w'])}W", f"constant power of {figure(load['power_w'])} W"
    torque = figure(load["torque_nm"])
    match load["kind"]:
        case "hoist":
            return f"hoist-{torque}Nm", f"hoist of {torque} N·m"
        case "fan":
            return f"fan-{torque}Nm", f"fan of {torque} N·m at {figure(load['speed_rpm'])} rpm"
    return f"{torque}Nm", f"constant torque of {torque} N·m"


def _supply(scenario: Content) -> Iterator[Trait]:
    """Describe the supply as the users of the kind of drive call it: by half, or the whole of a link."""
    drive, halves = scenario["drive"], scenario["supply_v"]
    name, share = ("half-supply", 1.0) if drive["kind"] == SPLIT_SUPPLY else ("link", 2.0)
    volts = [(time, share * half) for time, half in halves]
    fact, short = f"{name} {changes_at(volts, 'V')}", f"{name} {arrows(volts)} V"
    inverter = drive["inverter"]
    if levels(halves) == [inverter.get("supply_voltage_v", 0.5 * inverter.get("link_voltage_v", 0.0))]:
        yield Trait(fact=fact, short=short)
    else:
        yield Trait(f"{sequence(levels(volts))}V", f"{name} {changing(volts, 'V')}", fact, short)


def _imbalance(scenario: Content) -> Iterator[Trait]:
    profile = scenario["imbalance"]
    yield Trait(
        f"imbalance-{sequence(levels(profile), 100.0)}%",
        f"halves apart by {changing(profile, '%', 100.0)}",
        f"halves of the supply apart by {changes_at(profile, '%', 100.0)}",
    )


def _scales(scenario: Content) -> Iterator[Trait]:
    for key, value in scenario["scales"].items():
        if value == getattr(NOMINAL, key):
            continue
        if symbol := FACTOR_SYMBOLS.get(key):
            words = f"{symbol} × {value:.4g}"
            yield Trait(f"{symbol}×{value:.4g}", words, f"{symbol} × {value:g}", f"{key} × {value:g}")
        else:
            words, short = f"friction + {value:.4g} N·m", f"{value:g} N·m of friction added"
            yield Trait(f"friction+{value:.4g}Nm", words, f"friction + {value:g} N·m", short)


def _drift(scenario: Content) -> Iterator[Trait]:
    for quantity in PARAMETERS:
        if (profile := quantity.stated(scenario)) is None:
            continue
        changes, values = f"{quantity.symbol} {quantity.verb} by ", levels(profile)
        fact = f"{changes}{changes_at(profile, quantity.unit)}"
        if values == [quantity.nominal]:
            yield Trait(fact=fact)
        else:
            sign = "×" if quantity.is_factor else "+"
            label = f"{quantity.symbol}-{quantity.verb}{sign}{sequence(values)}"
            yield Trait(label, f"{changes}{changing(profile, quantity.unit)}", fact)


def _sensors(scenario: Content) -> Iterator[Trait]:
    sensors, seed = scenario["sensors"], scenario.get("seed", 0)
    kind = sensors if isinstance(sensors, str) else sensors["kind"]
    if kind == "ideal":
        return
    position = _position(scenario) if kind == "shunts" else ""
    label, seen = _SEEN.get(position, ("", ""))
    fact = f"{kind} sensors{seen if position == 'hall' else ''}" + (f" of seed {seed}" if seed else "")
    yield Trait(f"{kind}{label}", f"{kind} sensors{seen}, seed {seed}", fact)


def _position(scenario: Content) -> str:
    """Return what shows angle and speed of a shaft seen with shunts."""
    sensors, stated = scenario["sensors"], (scenario["drive"].get("sensing") or {}).get("position", "exact")
    own = "encoder" if stated == "exact" else stated
    return str(own if isinstance(sensors, str) else sensors.get("position", own))


def _current_errors(scenario: Content) -> Iterator[Trait]:
    for trait, error in zip(
        _other("current_errors", scenario["current_errors"]), scenario["current_errors"], strict=True
    ):
        sizes = [f"×{error['gain']:.4g}"] if error["gain"] != 1.0 else []
        sizes += [f"{error['offset_a']:+.4g}A"] if error["offset_a"] else []
        words = f"current of phase {error['phase']} shown as {' '.join(sizes)}"
        yield trait._replace(label=f"phase{error['phase']}{''.join(sizes)}", words=words)


def _dropouts(scenario: Content) -> Iterator[Trait]:
    for lost in scenario["dropouts"]:
        signal, phase = lost["signal"], lost.get("phase")
        what, lasting = signal if phase is None else f"phase {phase}", 1000.0 * lost["duration_s"]
        yield Trait(
            f"{what}-lost-{lasting:.4g}ms".replace(" ", ""),
            f"{what} lost for {lasting:.4g} ms at {lost['start_s']:.4g} s",
            f"{signal} lost for {lasting:g} ms at {lost['start_s']:g} s",
        )


def _glitches(scenario: Content) -> Iterator[Trait]:
    for false in scenario["glitches"]:
        counts, time = f"{false['counts']:+d}", false["time_s"]
        yield Trait(
            f"glitch{counts}",
            f"{counts} encoder counts too many at {time:.4g} s",
            f"{counts} encoder counts at {time:g} s",
        )


def _failure(scenario: Content) -> Iterator[Trait]:
    failure = scenario["failure"]
    kind, time, slip = failure["kind"], failure["time_s"], failure.get("slip_deg")
    label, phase = (f"-{failure['phase']}", f" {failure['phase']}") if kind in PHASED else ("", "")
    if slip is not None:
        label, phase = f"-{slip:g}deg", f" by {slip:g}°"
    yield Trait(f"{kind}{label}", f"{kind}{label} from {time:.4g} s on", f"{kind}{phase} at {time:g} s")


def _control_period(scenario: Content) -> Iterator[Trait]:
    """Name a control period that the scenario chooses; that of a PM AC drive follows from its carrier."""
    period = scenario["control_period_s"]
    if scenario["drive"]["kind"] != PM_AC and period != LONGEST_CONTROL_PERIOD_S:
        micros = f"{1e6 * period:.4g}"
        yield Trait(f"every-{micros}us", f"a step every {micros} µs", f"control period s {period:g}")


def _clock(scenario: Content) -> Iterator[Trait]:
    start = scenario["clock_start_s"]
    yield Trait(f"clock-{start:.7g}s", f"clock at {start:.7g} s", f"clock start s {start:g}")


def _turns(scenario: Content) -> Iterator[Trait]:
    turns = scenario["turns_before"]
    yield Trait(f"after-{turns:.7g}-turns", f"after {turns:.7g} turns", f"after {turns:g} turns")


def _winding(scenario: Content) -> Iterator[Trait]:
    hot = scenario["winding_temperature_c"]
    yield Trait(f"windings-{hot:.4g}C", f"windings at {hot:.4g} °C at first", f"windings at {hot:g} deg C")


def _angle(scenario: Content) -> Iterator[Trait]:
    angle = scenario["initial_angle_deg"]
    yield Trait(f"rotor-{angle:.4g}deg", f"rotor at {angle:.4g}° at first", f"initial angle deg {angle:g}")


def _restarts(scenario: Content) -> Iterator[Trait]:
    times = scenario["restarts_s"]
    label = f"restart×{len(times)}" if len(times) > 1 else "restart"
    yield Trait(label, f"restarted at {', '.join(f'{time:.4g}' for time in times)} s")
    yield from _other("restarts_s", times)


_TRAITS: Final[Mapping[str, Callable[[Content], Iterator[Trait]]]] = {
    "duration_s": _duration,
    "speed_rpm": _speed,
    "load": _load,
    "supply_v": _supply,
    "imbalance": _imbalance,
    "scales": _scales,
    "drift": _drift,
    "sensors": _sensors,
    "current_errors": _current_errors,
    "dropouts": _dropouts,
    "glitches": _glitches,
    "failure": _failure,
    "control_period_s": _control_period,
    "clock_start_s": _clock,
    "turns_before": _turns,
    "winding_temperature_c": _winding,
    "initial_angle_deg": _angle,
    "restarts_s": _restarts,
}
"""The traits of each key that has words of its own, in the order of a title."""
