"""How a scenario can be made simpler."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from drivegate.contracts.current.scenarios.building import TORQUE_DIGITS, coming_on, plain_scenario
from drivegate.contracts.current.scenarios.courses import QUANTITIES, ProfileCourse, course_of, fields_of
from drivegate.scenarios.drive_scale import scale_of, tidy, whole_tenths
from drivegate.scenarios.simplification import (
    FAILURES,
    PLAIN_BEGINNING,
    Fields,
    Simplification,
    nominal_parameters,
    to_whole,
)
from drivegate_cases.drive.limits import rounded
from drivegate_cases.drive.plant import NOMINAL
from drivegate_cases.scenario.courses import COURSES, DISTURBANCES
from drivegate_cases.scenario.load import (
    ConstantPowerLoad,
    ConstantTorqueLoad,
    FanLoad,
    LockedLoad,
    VehicleLoad,
)
from drivegate_cases.scenario.profile import dwell_torque, dwells
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import IDEAL, PLAIN

_NAMING: Final = frozenset({"schema_version", "name", "description", "drive"})
# What belongs to another key, and means nothing without it.
_FOLLOWING: Final = frozenset({"duration_s", "initial_speed_rpm", "seed"})
_TIMES = (5.0, 1.0, 0.5, 0.1)
_SPEED_GRAINS: Final = (50, 10, 5, 1)
_SUPPLY_GRAINS: Final = (10, 5, 1)
_TORQUE_GRAINS: Final = (50, 10, 5, 1)
_SHARE_GRAINS: Final[dict[str, tuple[float, ...]]] = {
    "load": (0.5, 0.25, 0.1, 0.05),
    "imbalance": (0.05, 0.01),
    "emf_constant": (0.05, 0.01),
    "inertia": (0.1, 0.05),
}


_DISTURBED: Final = tuple(
    dict.fromkeys(key.partition(".")[0] for quantity in reversed(DISTURBANCES) for key in quantity.keys)
)


def _plain_but_for_one(scenario: Scenario) -> Iterator[Fields]:
    """Make the whole run the plain one, but for a single key, or for how the load changes."""
    plain = plain_scenario(scenario.drive)
    kept = {key: getattr(plain, key) for key in type(plain).model_fields if key not in _NAMING}
    yield kept
    for key in kept:
        if getattr(scenario, key) == kept[key] or key in _FOLLOWING:
            continue
        fields = {**kept, key: getattr(scenario, key), "duration_s": scenario.duration_s}
        if key == "load":
            yield from ({**fields, **load} for load in _plain_load(scenario))
        elif key == "speed_rpm":
            fields["initial_speed_rpm"] = scenario.initial_speed_rpm
        elif key == "glitches":
            fields["sensors"] = scenario.sensors
        yield fields
        if key == "sensors":
            yield {**fields, "seed": scenario.seed}


def _plain_load(scenario: Scenario) -> Iterator[Fields]:
    """Require rated torque."""
    load = plain_scenario(scenario.drive).load
    if hasattr(scenario.load, "factor"):
        yield {"load": load.model_copy(update={"factor": scenario.load.factor})}
    yield {"load": load}


def _plain_speed(scenario: Scenario) -> Iterator[Fields]:
    """Run at the plain run's speed, under the same load or under rated torque."""
    plain = plain_scenario(scenario.drive)
    speed = {"speed_rpm": plain.speed_rpm, "initial_speed_rpm": plain.initial_speed_rpm}
    for load in _plain_load(scenario):
        yield {**speed, **load}
    yield speed


def _fewer_failures(scenario: Scenario) -> Iterator[Fields]:
    yield dict.fromkeys(FAILURES, ())
    for key in FAILURES:
        failures = getattr(scenario, key)
        yield {key: ()}
        yield {key: failures[: len(failures) // 2]}
        yield {key: failures[len(failures) // 2 :]}
        for index in range(len(failures)):
            yield {key: failures[:index] + failures[index + 1 :]}


def _plainer_beginning(scenario: Scenario) -> Iterator[Fields]:
    """Begin as every plain run does, and step as rarely as may be."""
    given = {key: value for key, value in PLAIN_BEGINNING.items() if getattr(scenario, key) != value}
    yield given
    for key, value in given.items():
        yield {key: value}


def _plainer_sensors(scenario: Scenario) -> Iterator[Fields]:
    yield {"sensors": IDEAL, "glitches": (), "seed": 0}
    yield {"sensors": IDEAL, "glitches": ()}
    if scenario.sensors.kind != IDEAL.kind:
        yield {"sensors": PLAIN[scenario.sensors.kind]}
    yield {"seed": 0}


def _nominal_parameters(scenario: Scenario) -> Iterator[Fields]:
    yield {"scales": NOMINAL}
    yield from nominal_parameters(scenario)


def _without_disturbance(scenario: Scenario) -> Iterator[Fields]:
    """Take drift, unequal halves and another supply away altogether."""
    given = [key for key in _DISTURBED if getattr(scenario, key) is not None]
    yield dict.fromkeys(given)
    for key in given:
        yield {key: None}


def _steadier(quantity: str) -> Simplification:
    def candidates(scenario: Scenario) -> Iterator[Fields]:
        course = course_of(scenario, quantity)
        if not course.changes:
            return
        for steadier in course.steadier():
            yield fields_of(scenario, quantity, _coming_on(scenario, quantity, steadier))

    return candidates


def _coming_on(scenario: Scenario, quantity: str, course: ProfileCourse) -> ProfileCourse:
    """Let a switched load come on as in every other run, from a shaft that turns freely."""
    if quantity != "load" or isinstance(scenario.load, VehicleLoad) or course.first == 0.0:
        return course
    comes_on = scale_of(scenario.drive).load_ramp_s
    return ProfileCourse.of(((0.0, 0.0), (comes_on, course.first), *course.profile()[1:]))


def _plainer_load(scenario: Scenario) -> Iterator[Fields]:
    """Require the torque of the last steady stretch, whatever the speed."""
    load = scenario.load
    steady = [dwell for dwell in dwells(scenario) if dwell_torque(scenario, dwell) > 0.0]
    if not steady or isinstance(load, (LockedLoad, ConstantTorqueLoad)):
        return
    torque = rounded(dwell_torque(scenario, steady[-1]), TORQUE_DIGITS)
    factor = coming_on(scenario.drive)
    if not isinstance(load, VehicleLoad):
        share = course_of(scenario, "load").values()[-1]
        if share > 0.0:
            whole = rounded(torque / share, TORQUE_DIGITS)
            yield {"load": ConstantTorqueLoad(kind="constant_torque", torque_nm=whole, factor=load.factor)}
    yield {"load": ConstantTorqueLoad(kind="constant_torque", torque_nm=torque, factor=factor)}


def _shorter(scenario: Scenario) -> Iterator[Fields]:
    """End at the first time at which a stretch can be judged, or after a part of the run."""
    scale = scale_of(scenario.drive)
    judged = [dwell.start + scale.settling_s + scale.shortest_window_s for dwell in dwells(scenario)]
    parts = [share * scenario.duration_s for share in (0.1, 0.25, 0.5, 0.75)]
    for end in sorted({whole_tenths(end) for end in (*judged, *parts)}):
        if end < scenario.duration_s:
            yield _until(scenario, end)


def _until(scenario: Scenario, end: float) -> Fields:
    fields: Fields = {"duration_s": end}
    shorter = scenario
    for quantity in QUANTITIES:
        changed = fields_of(shorter, quantity, course_of(shorter, quantity).until(end))
        fields |= changed
        shorter = shorter.model_copy(update=changed)
    fields["dropouts"] = tuple(dropout for dropout in scenario.dropouts if dropout.end_s <= end)
    fields["glitches"] = tuple(glitch for glitch in scenario.glitches if glitch.time_s <= end)
    fields["restarts_s"] = tuple(time for time in scenario.restarts_s if time <= end)
    return fields


def _rounder(quantity: str) -> Simplification:
    def candidates(scenario: Scenario) -> Iterator[Fields]:
        course = course_of(scenario, quantity)
        for grain in _grains(scenario, quantity):
            yield fields_of(scenario, quantity, course.mapped(value=to_whole(grain)))

    return candidates


def _grains(scenario: Scenario, quantity: str) -> Iterator[float]:
    """Return what a quantity is rounded to, the coarsest first."""
    scale = scale_of(scenario.drive)
    match quantity:
        case "speed":
            yield from (tidy(steps * scale.speed_step_rpm) for steps in _SPEED_GRAINS)
        case "supply":
            yield from (tidy(steps * scale.supply_step_v) for steps in _SUPPLY_GRAINS)
        case _:
            unit = _unit(scenario, COURSES[quantity].scale)
            yield from (tidy(grain * unit) for grain in _SHARE_GRAINS.get(quantity, (0.5, 0.1, 0.05)))


def _rounder_times(scenario: Scenario) -> Iterator[Fields]:
    for units in _TIMES:
        grain = scale_of(scenario.drive).units(units)
        rounded_time = to_whole(grain)
        fields: Fields = {"duration_s": max(rounded_time(scenario.duration_s), grain)}
        changed = scenario
        for quantity in QUANTITIES:
            course = course_of(scenario, quantity)
            # A load comes on as in every other run.
            kept = 1 if quantity == "load" and course.first == 0.0 else 0
            later = ProfileCourse(course.first, course.changes[kept:]).mapped(time=rounded_time)
            rounder = ProfileCourse(course.first, course.changes[:kept] + later.changes)
            fields |= fields_of(changed, quantity, rounder)
            changed = scenario.model_copy(update=fields)
        fields["dropouts"] = tuple(
            dropout.model_copy(update={"start_s": rounded_time(dropout.start_s)})
            for dropout in scenario.dropouts
        )
        fields["glitches"] = tuple(
            glitch.model_copy(update={"time_s": rounded_time(glitch.time_s)}) for glitch in scenario.glitches
        )
        fields["restarts_s"] = tuple(sorted({rounded_time(time) for time in scenario.restarts_s}))
        yield fields


def _rounder_load(scenario: Scenario) -> Iterator[Fields]:
    load, scale = scenario.load, scale_of(scenario.drive)
    if isinstance(load, ConstantPowerLoad):
        rated = scenario.drive.rating.rated_power_w
        for share in (0.5, 0.25, 0.1, 0.05):
            yield {"load": load.model_copy(update={"power_w": to_whole(share * rated)(load.power_w)})}
    elif isinstance(load, (ConstantTorqueLoad, FanLoad)):
        for steps in _TORQUE_GRAINS:
            grain = tidy(steps * scale.torque_step_nm)
            yield {"load": load.model_copy(update={"torque_nm": to_whole(grain)(load.torque_nm)})}
    elif isinstance(load, VehicleLoad):
        for units in (2, 1):
            grain = tidy(units * scale.mass_unit_kg)
            yield {"load": load.model_copy(update={"mass_kg": max(grain, to_whole(grain)(load.mass_kg))})}


def _rounder_parameters(scenario: Scenario) -> Iterator[Fields]:
    for grain in (0.5, 0.25, 0.1, 0.05):
        for key in type(NOMINAL).model_fields:
            value = to_whole(tidy(grain * _unit(scenario, key)))(getattr(scenario.scales, key))
            yield {"scales": scenario.scales.model_copy(update={key: value})}


def _unit(scenario: Scenario, scale: str | None) -> float:
    """Return what grains of a parameter are multiplied by: 1 for a factor, a torque of the drive for a friction."""
    return 10.0 * scale_of(scenario.drive).torque_step_nm if scale == "friction_added_n_m" else 1.0


def _rounder_failures(scenario: Scenario) -> Iterator[Fields]:
    scale = scale_of(scenario.drive)
    for steps in (10, 5, 1):
        grain = tidy(steps * scale.dropout_step_s)
        lasting = [max(grain, to_whole(grain)(dropout.duration_s)) for dropout in scenario.dropouts]
        pairs = zip(scenario.dropouts, lasting, strict=True)
        yield {"dropouts": tuple(old.model_copy(update={"duration_s": time}) for old, time in pairs)}
    for gain_grain, offset_steps in ((0.5, 50), (0.1, 25), (0.05, 5)):
        offset_grain = tidy(offset_steps * scale.offset_step_a)
        yield {
            "current_errors": tuple(
                error.model_copy(
                    update={
                        "gain": to_whole(gain_grain)(error.gain),
                        "offset_a": to_whole(offset_grain)(error.offset_a),
                    }
                )
                for error in scenario.current_errors
            )
        }
    for count in (50, 10, 5, 1):
        signs = [count if glitch.counts > 0 else -count for glitch in scenario.glitches]
        edges = zip(scenario.glitches, signs, strict=True)
        yield {"glitches": tuple(old.model_copy(update={"counts": counts}) for old, counts in edges)}


SIMPLIFICATIONS: Final[tuple[Simplification, ...]] = (
    _plain_but_for_one,
    _fewer_failures,
    _plainer_beginning,
    _without_disturbance,
    _plainer_sensors,
    _nominal_parameters,
    *(_steadier(quantity) for quantity in QUANTITIES),
    _shorter,
    _plain_speed,
    _plain_load,
    _plainer_load,
    _rounder("speed"),
    _rounder_load,
    _rounder_parameters,
    _rounder_failures,
    _rounder_times,
    *(_rounder(quantity) for quantity in QUANTITIES if quantity != "speed"),
)
"""All of them, in the order in which they are tried."""
