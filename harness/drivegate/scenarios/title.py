"""Names and descriptions that say what a scenario is, made from its content."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from drivegate_cases.documents.wording import figure
from drivegate_cases.drive.drive_document import SPLIT_SUPPLY
from drivegate_cases.drive.plant import FACTOR_SYMBOLS
from drivegate_cases.scenario.courses import PARAMETERS
from drivegate_cases.scenario.disturbance import Dropout
from drivegate_cases.scenario.failure import PHASED
from drivegate_cases.scenario.load import (
    ConstantPowerLoad,
    ConstantTorqueLoad,
    DynamometerLoad,
    FanLoad,
    HoistLoad,
    LockedLoad,
    VehicleLoad,
)
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.scenario import LONGEST_CONTROL_PERIOD_S, Scenario
from drivegate_cases.scenario.sensors import ShuntSensors

_LONGEST_NAME = 200
_LONGEST_DESCRIPTION = 2000
_LISTED_TURNS = 2


class _Trait(NamedTuple):
    """Something about a scenario, as part of a name and as part of a sentence."""

    label: str
    words: str


def titled(scenario: Scenario) -> Scenario:
    """Name and describe a scenario by its content."""
    traits = [
        _speed(scenario),
        *_load(scenario),
        *_supply(scenario),
        *_parameters(scenario),
        *_sensors(scenario),
        *_current_errors(scenario),
        *_failures(scenario),
        *_failure(scenario),
        *_beginning(scenario),
    ]
    sentence = "; ".join(trait.words for trait in traits)
    return scenario.model_copy(
        update={
            "name": "-".join(trait.label for trait in traits)[:_LONGEST_NAME],
            "description": f"{sentence}."[:_LONGEST_DESCRIPTION],
        }
    )


def _levels(profile: Profile) -> list[float]:
    """Values that a profile goes through, without immediate repetitions."""
    values = [value for _, value in profile]
    return [value for index, value in enumerate(values) if index == 0 or value != values[index - 1]]


def _sequence(values: list[float], scale: float = 1.0) -> str:
    """Join values; what goes to and fro again and again is said once."""
    turns = len(values) // 2
    words = [figure(scale * value) for value in values]
    if turns > _LISTED_TURNS and values == (values[:2] * (turns + 1))[: len(values)]:
        return "-".join([f"{words[0]}-{words[1]}×{turns}", *words[2 * turns :]])
    return "-".join(words)


def _in_words(values: list[float], unit: str, scale: float = 1.0) -> str:
    return f"{', then '.join(figure(scale * value) for value in values)} {unit}"


def _changing(profile: Profile, unit: str, scale: float = 1.0) -> str:
    return f"{_in_words(_levels(profile), unit, scale)}{_change_times(profile)}"


def _change_times(profile: Profile) -> str:
    changes = [time for (time, value), (_, after) in pairwise(profile) if value != after]
    return f" (changing at {', '.join(f'{time:.4g}' for time in changes)} s)" if changes else ""


def _speed(scenario: Scenario) -> _Trait:
    levels = _levels(scenario.speed_rpm)
    label, words = f"{_sequence(levels)}rpm", _changing(scenario.speed_rpm, "rpm")
    if (first := scenario.initial_speed_rpm) != levels[0]:
        label, words = f"{figure(first)}-to-{label}", f"{words}, starting from {figure(first)} rpm"
    return _Trait(label, words)


def _load(scenario: Scenario) -> list[_Trait]:
    load = scenario.load
    match load:
        case DynamometerLoad():
            torques = _levels(load.torque_reference_nm)
            words = f"held by a dynamometer, torque reference {_changing(load.torque_reference_nm, 'N·m')}"
            return [_Trait(f"torque-{_sequence(torques)}Nm", words)]
        case LockedLoad():
            return [_Trait("locked", "locked to a dynamometer")]
        case VehicleLoad():
            whole = _Trait(f"vehicle-{load.mass_kg:g}kg", f"a vehicle of {load.mass_kg:g} kg")
            grades = _levels(load.grade_percent)
            if grades == [0.0]:
                return [whole]
            grade = f"grade {_changing(load.grade_percent, '%')}"
            return [whole, _Trait(f"grade-{_sequence(grades)}%", grade)]
        case ConstantTorqueLoad():
            whole = _Trait(f"{figure(load.torque_nm)}Nm", f"constant torque of {figure(load.torque_nm)} N·m")
        case HoistLoad():
            torque = figure(load.torque_nm)
            whole = _Trait(f"hoist-{torque}Nm", f"hoist of {torque} N·m")
        case ConstantPowerLoad():
            whole = _Trait(f"{figure(load.power_w)}W", f"constant power of {figure(load.power_w)} W")
        case FanLoad():
            words = f"fan of {figure(load.torque_nm)} N·m at {figure(load.speed_rpm)} rpm"
            whole = _Trait(f"fan-{figure(load.torque_nm)}Nm", words)
    return _switched(whole, load.factor)


def _switched(whole: _Trait, factor: Profile) -> list[_Trait]:
    """Return shares of a load, except for the rise from nothing to all of it."""
    levels = _levels(factor)
    if not any(levels) or whole.label in ("0Nm", "0W"):
        return [_Trait("unloaded", "unloaded")]
    comes_on = levels[0] == 0.0
    shares = levels[1:] if comes_on else levels
    if shares == [1.0]:
        return [whole]
    percent = _Trait(
        f"{_sequence(shares, 100.0)}%",
        f"{_in_words(shares, '% of it', 100.0)}{_change_times(factor[comes_on:])}",
    )
    return [whole, percent]


def _supply(scenario: Scenario) -> list[_Trait]:
    traits = []
    supply = scenario.supply_profile
    if _levels(supply) != [scenario.drive.inverter.supply_voltage_v]:
        name, volts = stated_supply(scenario.drive.kind, supply)
        traits.append(_Trait(f"{_sequence(_levels(volts))}V", f"{name} {_changing(volts, 'V')}"))
    if scenario.imbalance is not None:
        shares = _levels(scenario.imbalance)
        words = f"halves apart by {_changing(scenario.imbalance, '%', 100.0)}"
        traits.append(_Trait(f"imbalance-{_sequence(shares, 100.0)}%", words))
    return traits


def _parameters(scenario: Scenario) -> list[_Trait]:
    scales = scenario.scales
    traits = [
        _Trait(f"{symbol}×{factor:.4g}", f"{symbol} × {factor:.4g}")
        for key, symbol in FACTOR_SYMBOLS.items()
        if (factor := getattr(scales, key)) != 1.0
    ]
    if scales.friction_added_n_m:
        added = f"{scales.friction_added_n_m:.4g}"
        traits.append(_Trait(f"friction+{added}Nm", f"friction + {added} N·m"))
    for quantity in PARAMETERS:
        profile = quantity.profile(scenario)
        if (levels := _levels(profile)) != [quantity.nominal]:
            label = (
                f"{quantity.symbol}-{quantity.verb}{'×' if quantity.is_factor else '+'}{_sequence(levels)}"
            )
            words = f"{quantity.symbol} {quantity.verb} by {_changing(profile, quantity.unit)}"
            traits.append(_Trait(label, words))
    return traits


def _sensors(scenario: Scenario) -> list[_Trait]:
    kind = scenario.sensors.kind
    if kind == "ideal":
        return []
    if isinstance(scenario.sensors, ShuntSensors) and scenario.sensors.position == "hall":
        return [_Trait(f"{kind}-hall", f"{kind} sensors with Hall switches, seed {scenario.seed}")]
    if isinstance(scenario.sensors, ShuntSensors) and scenario.sensors.position == "exact":
        return [_Trait(f"{kind}-magnet", f"{kind} sensors and a magnet's on the shaft, seed {scenario.seed}")]
    return [_Trait(kind, f"{kind} sensors, seed {scenario.seed}")]


def _current_errors(scenario: Scenario) -> list[_Trait]:
    traits = []
    for error in scenario.current_errors:
        sizes = [f"×{error.gain:.4g}"] if error.gain != 1.0 else []
        sizes += [f"{error.offset_a:+.4g}A"] if error.offset_a else []
        label, phase = "".join(sizes), f"phase {error.phase}"
        traits.append(_Trait(f"phase{error.phase}{label}", f"current of {phase} shown as {' '.join(sizes)}"))
    return traits


def _beginning(scenario: Scenario) -> list[_Trait]:
    """Return how the run begins, how often the controller steps, and when it is restarted."""
    traits = []
    usual = scenario.drive.control_period_s or LONGEST_CONTROL_PERIOD_S
    if (period := scenario.control_period_s) != usual:
        micros = f"{1e6 * period:.4g}"
        traits.append(_Trait(f"every-{micros}us", f"a step every {micros} µs"))
    if scenario.clock_start_s:
        traits.append(
            _Trait(f"clock-{scenario.clock_start_s:.7g}s", f"clock at {scenario.clock_start_s:.7g} s")
        )
    if scenario.initial_angle_deg:
        degrees = f"{scenario.initial_angle_deg:.4g}"
        traits.append(_Trait(f"rotor-{degrees}deg", f"rotor at {degrees}° at first"))
    if scenario.restarts_s:
        times = ", ".join(f"{time:.4g}" for time in scenario.restarts_s)
        count = len(scenario.restarts_s)
        traits.append(_Trait(f"restart×{count}" if count > 1 else "restart", f"restarted at {times} s"))
    return traits


def _failures(scenario: Scenario) -> list[_Trait]:
    lost = [
        _Trait(
            f"{_lost(dropout)}-lost-{1000.0 * dropout.duration_s:.4g}ms".replace(" ", ""),
            f"{_lost(dropout)} lost for {1000.0 * dropout.duration_s:.4g} ms at {dropout.start_s:.4g} s",
        )
        for dropout in scenario.dropouts
    ]
    false_edges = [
        _Trait(
            f"glitch{glitch.counts:+d}",
            f"{glitch.counts:+d} encoder counts too many at {glitch.time_s:.4g} s",
        )
        for glitch in scenario.glitches
    ]
    return lost + false_edges


def _failure(scenario: Scenario) -> list[_Trait]:
    if (failure := scenario.failure) is None:
        return []
    phase = f"-{failure.phase}" if failure.kind in PHASED else ""
    if failure.slip_deg is not None:
        phase = f"-{failure.slip_deg:g}deg"
    return [_Trait(f"{failure.kind}{phase}", f"{failure.kind}{phase} from {failure.time_s:.4g} s on")]


def _lost(dropout: Dropout) -> str:
    return dropout.signal if dropout.phase is None else f"phase {dropout.phase}"


def stated_supply(kind: str, halves: Sequence[Sequence[float]]) -> tuple[str, Profile]:
    """Return what the users of a kind of drive call its supply, and its course (s, V), from that of each half."""
    name, share = ("half-supply", 1.0) if kind == SPLIT_SUPPLY else ("link", 2.0)
    return name, tuple((time, share * volts) for time, volts in halves)
