"""Checks of a start without a position sensor, from standstill and of a shaft that turns."""

from __future__ import annotations

from math import degrees

import numpy as np

from drivegate.checks.check import Check
from drivegate.checks.course import course_of
from drivegate.checks.margin import Margin, Mark, Moment, Point, at_most
from drivegate.contracts.duty.checks.judged import worst
from drivegate.contracts.duty.checks.sensorless.judged import if_speed, least_speed, regulates_speed
from drivegate.contracts.duty.checks.sensorless.measures import Start, start_of
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.unsensed import TAKE_OVER_S
from drivegate.scenarios.rotation import sense_of
from drivegate_cases.drive.pm_ac.sensorless import START_TORQUE
from drivegate_cases.scenario.load import LockedLoad, VehicleLoad
from drivegate_cases.scenario.piecewise import Profile
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.pm_ac.rectifying import rectifies
from drivegate_models.units import RADIANS_PER_RPM

BACKWARD_DEG = 180.0
"""Greatest turn against the reference (electrical degrees): a rotor that is aligned turns by up to half a turn."""
REFERENCE_FACTOR = 2.0
"""Least reference of a start over the least speed (1): at the least speed itself, a regulator swings about it."""
TAKEN_SHARE = 0.2
"""Greatest torque while a turning shaft is taken over, over the rated one (1)."""


def _start_reference(record: DutyRecord) -> float | None:
    """Return the speed reference of a start (rad/s); None where the run is not a start, or not of the nominal drive."""
    scenario = record.scenario
    if not regulates_speed(record) or not record.is_nominal or scenario.initial_speed_rpm != 0.0:
        return None
    reference = scenario.speed_rpm[0][1] * RADIANS_PER_RPM
    return reference if abs(reference) >= REFERENCE_FACTOR * least_speed(record) else None


def _start_rows(record: DutyRecord) -> int:
    """Return the control periods until the reference or the load of a start changes."""
    scenario = record.scenario
    end = min(
        _constant_until(profile, scenario.duration_s)
        for profile in (scenario.speed_rpm, scenario.load_profile)
    )
    return round(end / scenario.control_period_s)


def _constant_until(profile: Profile, end_s: float) -> float:
    """Return the time until which a profile has its first value (s)."""
    first = profile[0][1]
    changes = [number for number, (_, value) in enumerate(profile) if value != first]
    return profile[changes[0] - 1][0] if changes else end_s


def start_without_sensor(record: DutyRecord) -> Margin | None:
    """Judge a start: the time to the least speed, for good, and the turn backward."""
    wanted = _start_reference(record)
    if wanted is None:
        return None
    rows = _start_rows(record)
    period, allowed = record.scenario.control_period_s, record.document.start_time_s
    if rows * period < allowed:
        return None
    found = _start(record, wanted)
    place = f"from {record.scenario.initial_angle_deg:g}°"
    late = rows * period if found.reached == float("inf") else found.reached
    words = f"{late:.4g} s" if late == found.reached else f"not within {late:.4g} s"
    backward = degrees(found.backward)
    return worst(
        (
            Margin("SLS-1", at_most(late, allowed), f"least speed for good after {words} {place}"),
            Margin("SLS-1", at_most(backward, BACKWARD_DEG), f"{backward:.3g}° backward {place}"),
        )
    )


def _start(record: DutyRecord, wanted: float) -> Start:
    """Measure a start, whose speed reference is given (rad/s)."""
    speed = record.run.column("speed")[: _start_rows(record)]
    pole_pairs, period = record.document.machine.pole_pairs, record.scenario.control_period_s
    return start_of(speed, least_speed(record), sense_of(wanted), pole_pairs, period)


def start_moment(record: DutyRecord) -> Moment | None:
    """Show the speed of a start, with the least speed and the time for it, or how far the shaft turns backward."""
    wanted, margin = _start_reference(record), start_without_sensor(record)
    if wanted is None or margin is None:
        return None
    if "backward" in margin.measured:
        return _backward_moment(record, sense_of(wanted))
    period, allowed = record.scenario.control_period_s, record.document.start_time_s
    speed = record.run.column("speed")[: _start_rows(record)] / RADIANS_PER_RPM
    place = min(round(min(_start(record, wanted).reached, len(speed) * period) / period), len(speed) - 1)
    least = sense_of(wanted) * record.document.least_speed_rpm
    return Moment(
        start_s=0.0,
        end_s=min(max(2.0 * allowed, (place + 1) * period), len(speed) * period),
        origin_s=0.0,
        column="speed_rpm",
        levels=(Mark(words=f"least speed {least:.4g} rpm", value=least),),
        instants=(Mark(words=f"{allowed:.3g} s allowed", value=allowed),),
        point=Point(
            words=f"{speed[place]:.4g} rpm", time_s=(place + 0.5) * period, value=float(speed[place])
        ),
    )


def _backward_moment(record: DutyRecord, sense: float) -> Moment:
    period = record.scenario.control_period_s
    speed = sense * record.run.column("speed")[: _start_rows(record)]
    turned = np.degrees(np.cumsum(speed) * period * record.document.machine.pole_pairs)
    place = int(np.argmin(turned))
    shown = turned[: 2 * (place + 1)]
    return Moment(
        start_s=0.0,
        end_s=len(shown) * period,
        quantity="turn towards the reference (el. deg)",
        courses=(course_of("turn", (np.arange(len(shown)) + 1.0) * period, shown),),
        levels=(Mark(words=f"limit {-BACKWARD_DEG:g}°", value=-BACKWARD_DEG),),
        point=Point(
            words=f"{-turned[place]:.3g}° backward",
            time_s=(place + 1.0) * period,
            value=float(turned[place]),
        ),
    )


def flying_start(record: DutyRecord) -> Margin | None:
    """Judge how a turning shaft is taken over: torque until the time allowed, and speed from then on."""
    scenario = record.scenario
    initial, reference = scenario.initial_speed_rpm, scenario.speed_rpm[0][1]
    if not regulates_speed(record) or not record.is_nominal or initial == 0.0 or initial != reference:
        return None
    if abs(initial) * RADIANS_PER_RPM < least_speed(record) or not _is_idle(scenario):
        return None
    return worst((_torque_taken(record), _speed_kept(record)))


def _is_idle(scenario: Scenario) -> bool:
    """Return True if a run has one speed reference and no load."""
    load = scenario.load
    assert not isinstance(load, (LockedLoad, VehicleLoad)), "a free shaft without a vehicle"
    torques = (load.torque_at(scenario.initial_speed_rpm, share) for _, share in scenario.load_profile)
    return not any(torques) and all(speed == scenario.initial_speed_rpm for _, speed in scenario.speed_rpm)


def flying_moment(record: DutyRecord) -> Moment | None:
    """Show the torque while a turning shaft is taken over; None where its speed decides."""
    margin, taken = flying_start(record), _torque_taken(record)
    if margin is None or taken is None or taken.value > margin.value:
        return None
    period, torque = record.scenario.control_period_s, record.run.column("torque")
    place = int(np.argmax(np.abs(torque[record.periods(0.0, TAKE_OVER_S)])))
    allowed = TAKEN_SHARE * record.document.rating.rated_torque_nm
    return Moment(
        start_s=0.0,
        end_s=min(2.0 * TAKE_OVER_S, record.scenario.duration_s),
        column="torque_nm",
        levels=tuple(Mark(words=f"± {allowed:.3g} N·m", value=value) for value in (allowed, -allowed)),
        instants=(Mark(words=f"{1e3 * TAKE_OVER_S:g} ms", value=TAKE_OVER_S),),
        point=Point(
            words=f"{torque[place]:.4g} N·m", time_s=(place + 0.5) * period, value=float(torque[place])
        ),
    )


def _torque_taken(record: DutyRecord) -> Margin | None:
    speed, link = (float(record.run.column(name)[0]) for name in ("speed", "link"))
    if rectifies(record.plant, speed, link):
        # The diodes alone brake the shaft.
        return None
    rows = record.periods(0.0, TAKE_OVER_S)
    greatest = float(np.max(np.abs(record.run.column("torque")[rows])))
    allowed = TAKEN_SHARE * record.document.rating.rated_torque_nm
    measured = f"torque {greatest:.4g} N·m while a shaft at {record.scenario.initial_speed_rpm:.4g} rpm is taken over"
    return Margin("SLS-6", at_most(greatest, allowed), measured)


def _speed_kept(record: DutyRecord) -> Margin | None:
    if not record.steady:
        return None
    window = record.steady[-1]
    error = abs(window.speed - window.speed_reference) / RADIANS_PER_RPM
    measured = f"speed off by {error:.4g} rpm after a start at {record.scenario.initial_speed_rpm:.4g} rpm"
    return Margin("SLS-6", at_most(error, 2.0 * record.limits.speed_tolerance_rpm), measured)


SLS_1 = Check(
    id="SLS-1",
    families=("sensorless start",),
    requirement=(
        "Without a position sensor, the shaft starts from any angle of the rotor under up to half of rated torque. It "
        "reaches the least speed within the start time, stays above it, and turns back by at most 180° electrical."
    ),
    limit="the start time, 180° electrical backward",
    scenarios="starts of the nominal drive from standstill to twice the least speed or more, from 24 rotor angles and "
    "drawn ones",
    formula="the lesser of 1 - time to the least speed for good / start time and 1 - backward turn / 180°",
    why="An observer alone is no start: many controllers start from some angles only, or the wrong way.",
    evaluate=start_without_sensor,
    moment=start_moment,
    reason_not_applicable=if_speed,
)
SLS_6 = Check(
    id="SLS-6",
    families=("flying start",),
    requirement=(
        "A shaft that turns at its speed reference without a load is taken over: the torque is at most 20 % of rated "
        "torque for 100 ms, and then the mean speed is within 2 k1 of the reference."
    ),
    limit="20 % of rated torque for 100 ms, then speed 2 k1",
    scenarios="runs of the nominal drive that begin at 5 to 100 % of the highest speed, from the least speed on and up "
    "to where the terminals lag the EMF by 60° with all legs off, either way; the torque only where no diode conducts "
    "by itself",
    formula="the lesser of 1 - greatest torque / 20 % of rated torque and 1 - speed error / 2 k1",
    why="A fan that the wind turns, or a vehicle that rolls, is braked hard by a controller that presumes standstill.",
    evaluate=flying_start,
    moment=flying_moment,
    reason_not_applicable=if_speed,
)
assert START_TORQUE == 0.5, "the words of SLS-1 state it"
