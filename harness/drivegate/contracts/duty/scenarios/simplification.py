"""How a scenario of a PM AC drive can be made simpler."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Any, Final

from drivegate.contracts.duty.document import duty_document
from drivegate.contracts.duty.scenarios.building import TORQUE_DIGITS, speed_scenario, torque_scenario
from drivegate.contracts.duty.scenarios.drawn_range import speed_of
from drivegate.scenarios.course_words import levels
from drivegate.scenarios.rotation import is_mirrored, mirrored, sense_of
from drivegate.scenarios.simplification import Fields, Simplification, nominal_parameters, to_whole
from drivegate_cases.drive.limits import nearest_step, rounded
from drivegate_cases.drive.plant import NOMINAL
from drivegate_cases.scenario.load import ConstantTorqueLoad, DynamometerLoad, FanLoad, HoistLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import IDEAL, SHUNTS, ShuntSensors

_KEPT: Final = (
    "duration_s",
    "initial_speed_rpm",
    "speed_rpm",
    "load",
    "supply_v",
    "scales",
    "initial_angle_deg",
    "winding_temperature_c",
)
_GRAIN_SHARES: Final = (0.5, 0.2, 0.1, 0.05)


def _fields_of(made: Scenario) -> Fields:
    """Return all that a plain scenario says, so that whatever else there was goes."""
    return {key: getattr(made, key) for key in _KEPT}


def _nominal(scenario: Scenario) -> Iterator[Fields]:
    """Take other parameters, another supply and another begin away."""
    yield {
        "scales": NOMINAL,
        "drift": None,
        "supply_v": None,
        "initial_angle_deg": 0.0,
        "clock_start_s": 0.0,
        "turns_before": 0,
    }
    yield {"scales": NOMINAL}
    yield {"drift": None}
    yield from nominal_parameters(scenario)
    yield {"supply_v": None}
    yield {"initial_angle_deg": 0.0}
    yield {"clock_start_s": 0.0}
    yield {"turns_before": 0}


def _fewer_events(scenario: Scenario) -> Iterator[Fields]:
    """Take restarts, lost samples and false edges away, all or all but the first."""
    for key in ("restarts_s", "dropouts", "glitches"):
        events = getattr(scenario, key)
        if events:
            yield {key: ()}
        if len(events) > 1:
            yield {key: events[:1]}


def _plainer_sensors(scenario: Scenario) -> Iterator[Fields]:
    """See the plant as it is, through sensors with their defaults, or through those of the first seed."""
    yield {"sensors": IDEAL, "seed": 0}
    if isinstance(scenario.sensors, ShuntSensors):
        # What gives the position stays: edges of another kind are lost in another way.
        plain = SHUNTS.model_copy(update={"position": scenario.sensors.position})
        yield {"sensors": plain, "seed": 1}
        yield {"sensors": plain}


def _forward(scenario: Scenario) -> Iterator[Fields]:
    """Turn forward what begins backward."""
    if scenario.speed_rpm[0][1] < 0.0 and is_mirrored(scenario):
        yield _fields_of(mirrored(scenario))


def _fewer_torques(scenario: Scenario) -> Iterator[Fields]:
    """Ask for one torque, or for two one after the other."""
    if not isinstance(scenario.load, DynamometerLoad):
        return
    drive, speed = duty_document(scenario.drive), scenario.speed_rpm[0][1]
    torques = levels(scenario.load.torque_reference_nm)
    for fewer in _fewer(torques):
        if len(fewer) < len(torques):
            yield _with_own(scenario, torque_scenario(drive, speed, fewer))


def _fewer_speeds(scenario: Scenario) -> Iterator[Fields]:
    """Run at one speed under the last load, or through two speeds."""
    load = scenario.load
    if not isinstance(load, ConstantTorqueLoad):
        return
    drive, speeds = duty_document(scenario.drive), levels(scenario.speed_rpm)
    torque = rounded(load.torque_nm * load.factor[-1][1], TORQUE_DIGITS)
    for fewer in _fewer(speeds):
        for size in (torque, 0.0):
            yield _with_own(scenario, speed_scenario(drive, fewer, torque_nm=size))


def _fewer(values: list[float]) -> Iterator[tuple[float, ...]]:
    """List each of some values, the plainest first, and the pairs of neighbours of more than two."""
    yield from (
        (value,) for value in sorted(dict.fromkeys(values), key=lambda value: (abs(value), value < 0.0))
    )
    if len(values) > 2:
        yield from pairwise(values)


def _with_own(scenario: Scenario, made: Scenario) -> Fields:
    """Keep what is not nominal about a run in a shorter one."""
    own: dict[str, Any] = {
        key: getattr(scenario, key) for key in ("scales", "initial_angle_deg", "sensors", "seed")
    }
    return _fields_of(made) | own


def _rounder_speed(scenario: Scenario) -> Iterator[Fields]:
    drive = duty_document(scenario.drive)
    base = drive.rating.base_speed_rpm
    begin = scenario.initial_speed_rpm
    starts = begin == scenario.speed_rpm[0][1]
    if len(scenario.speed_rpm) == 1:
        own = sense_of(scenario.speed_rpm[0][1])
        for share in (-1.0, 0.0, 0.5, 1.0):
            for sense in dict.fromkeys((1.0, own)):
                plain = sense * speed_of(drive, share)
                yield {"speed_rpm": ((0.0, plain),), "initial_speed_rpm": plain if starts else begin}
    for share in _GRAIN_SHARES:
        whole = to_whole(nearest_step(share * base))
        rounder = tuple((time, whole(speed)) for time, speed in scenario.speed_rpm)
        yield {"speed_rpm": rounder, "initial_speed_rpm": rounder[0][1] if starts else begin}


def _rounder_torque(scenario: Scenario) -> Iterator[Fields]:
    load, drive = scenario.load, duty_document(scenario.drive)
    rated = drive.rating.rated_torque_nm
    for share in _GRAIN_SHARES:
        whole = to_whole(nearest_step(share * rated))
        if isinstance(load, DynamometerLoad):
            rounder = tuple((time, whole(torque)) for time, torque in load.torque_reference_nm)
            yield {"load": load.model_copy(update={"torque_reference_nm": rounder})}
        elif isinstance(load, (ConstantTorqueLoad, FanLoad, HoistLoad)):
            yield {"load": load.model_copy(update={"torque_nm": whole(load.torque_nm)})}


DUTY_SIMPLIFICATIONS: Final[tuple[Simplification, ...]] = (
    _nominal,
    _fewer_events,
    _plainer_sensors,
    _forward,
    _fewer_torques,
    _fewer_speeds,
    _rounder_speed,
    _rounder_torque,
)
"""All of them, in the order in which they are tried."""
