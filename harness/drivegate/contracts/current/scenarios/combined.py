"""Scenarios of joint changes: a fair run for each row of the covering array, and long runs at rated load."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from random import Random
from typing import Final, TypeAlias

from drivegate.contracts.current.scenarios.building import (
    TORQUE_DIGITS,
    coming_on,
    standstill_scenario,
    steady_scenario,
    vehicle_scenario,
)
from drivegate.contracts.current.scenarios.drawn.courses import load_course
from drivegate.contracts.current.scenarios.feasibility import COASTING_SHARE, unfair_because
from drivegate.scenarios.changes import (
    moments,
    pulsed,
    repeated,
    stepped,
    with_beginning,
    with_current_error,
    with_drift,
    with_dropout,
    with_glitch,
    with_imbalance,
    with_load_factor,
    with_load_shares,
    with_lost_samples,
    with_real_sensors,
    with_restarts,
    with_scales,
    with_speed,
    with_supply,
)
from drivegate.scenarios.covering import Row, covering_rows
from drivegate.scenarios.drive_scale import SpeedRange, loaded_range, scale_of, tidy
from drivegate.scenarios.title import titled
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import rounded
from drivegate_cases.scenario.load import FanLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.sensors import has_encoder, real_sensors
from drivegate_models.units import RADIANS_PER_RPM

Change: TypeAlias = Callable[[Scenario, Random, float], Scenario]
"""From a run, random numbers and a time to the run changed then."""

ATTEMPTS: Final = 60
"""Draws for one row, ever lighter ones, before it is left out."""
LIGHTEST: Final = 0.1
"""Lightest load that is drawn, as a share of rated power (1)."""
_PERIODS: Final = {"500 µs": 5e-4, "400 µs": 4e-4, "250 µs": 2.5e-4, "100 µs": 1e-4}
_CLOCKS: Final = {"0": 0.0, "2³¹ µs": 2147.483648 - 5.0, "2³² µs": 4294.967296 - 5.0}


def combined_scenarios(
    drive: DriveDocument, speed_range: SpeedRange | None, seed: int, part: int = 0, parts: int = 1
) -> tuple[Scenario, ...]:
    """Draw a fair scenario for each row that a candidate's speeds allow, and the long runs, or a part of them all.

    The same seed gives the same ones, whatever the number of parts.
    """
    rows = list(enumerate(covering_rows()))[part::parts]
    drawn = [_drawn(drive, speed_range, row, seed, number) for number, row in rows]
    fair = tuple(scenario for scenario in drawn if scenario is not None)
    return fair + long_scenarios(drive, speed_range, seed)[part::parts]


def long_scenarios(drive: DriveDocument, speed_range: SpeedRange | None, seed: int) -> tuple[Scenario, ...]:
    """Draw runs of minutes at rated power.

    One is undisturbed, one has a load that changes late and real sensors, and one a load that goes to and fro with time
    for the search to come to rest in between. That one is in the lower half of the speeds, where the search restarts
    at every change of the load: higher up, the current is free and the angle regulates the speed.
    """
    random = Random(f"{seed}/long")
    scale = scale_of(drive)
    speeds = _whole_speeds(*loaded_range(drive, speed_range), scale.speed_step_rpm)
    lower_half = speeds[: (len(speeds) + 1) // 2]
    plain, late, busy = (
        steady_scenario(drive, random.choice(among), power_share=1.0, constant_power=False)
        for among in (speeds, speeds, lower_half)
    )
    rest = scale.settling_s
    changed = with_load_shares(late, (0.0, 1.0), (scale.long_s - scale.dwell_s, 0.5))
    to_and_fro = repeated(1.0, 0.5, rest, times=12, every_s=2.0 * rest)
    return (
        titled(plain.replaced(duration_s=scale.long_s)),
        with_real_sensors(changed, random.randrange(1000)),
        with_load_factor(busy, (*coming_on(drive), *to_and_fro[1:])),
    )


def _whole_speeds(lowest: float, highest: float, step: float) -> list[float]:
    """List the speeds of whole steps, or the highest where there is none."""
    bottom, top = math.ceil(lowest / step - 1e-9), math.floor(highest / step + 1e-9)
    return [tidy(step * steps) for steps in range(bottom, top + 1)] or [highest]


def _drawn(
    drive: DriveDocument, speed_range: SpeedRange | None, row: Row, seed: int, number: int
) -> Scenario | None:
    if speed_range is not None and row["speed course"] in ("standstill", "overspeed"):
        return None
    random = Random(f"{seed}/{number}")
    if row["speed course"] == "overspeed":
        among = drive.rating.highest_speed_rpm, drive.rating.overspeed_rpm
    else:
        among = loaded_range(drive, speed_range)
    speeds = _whole_speeds(*among, scale_of(drive).speed_step_rpm)
    # In an order of chance: no two rows have the same speed before all were had.
    shuffled = list(speeds)
    Random(f"{seed}/speeds").shuffle(shuffled)
    speed = shuffled[number % len(shuffled)]
    for attempt in range(ATTEMPTS):
        heaviest = 1.0 - 0.8 * attempt / ATTEMPTS
        other = random.choice(speeds)
        scenario = _changed(_base(drive, row, random, heaviest, (speed, other)), row, random)
        if unfair_because(scenario) is None:
            return scenario
    return None


def _base(
    drive: DriveDocument, row: Row, random: Random, heaviest: float, speeds: tuple[float, float]
) -> Scenario:
    """Make a run with the row's load and courses of speed and load, at the first speed or between both."""
    slow, fast = sorted(speeds) if row["speed course"] in ("up", "down") else (speeds[0], speeds[0])
    scale = scale_of(drive)
    share = round(0.05 * random.randint(3, max(3, round(20.0 * heaviest))), 2)
    at = _moment(drive, row, random)
    if row["load"] == "vehicle":
        grade = stepped(0.0, 1.0, at) if row["load course"] == "up" else ((0.0, 0.0),)
        run = vehicle_scenario(drive, fast, mass_units=3, gear_units=8, grade_percent=grade)
    elif row["speed course"] == "standstill":
        torque = min(
            share * drive.rating.rated_power_w / (fast * RADIANS_PER_RPM), scale.standstill_torque_nm
        )
        run = standstill_scenario(drive, fast, torque_nm=torque, at_s=at, over_s=scale.units(1))
    else:
        run = steady_scenario(drive, fast, power_share=share, constant_power=row["load"] == "power")
        if row["load"] == "fan":
            torque = rounded(share * drive.rating.rated_power_w / (fast * RADIANS_PER_RPM), TORQUE_DIGITS)
            fan = FanLoad(kind="fan", torque_nm=torque, speed_rpm=fast, factor=coming_on(drive))
            run = run.replaced(load=fan)
    if row["load course"] != "steady" and row["load"] != "vehicle":
        run = _with_course(run, row["load course"], random, at, share)
    match row["speed course"]:
        case "up":
            run = with_speed(run, stepped(slow, fast, at, over_s=scale.units(random.choice((0, 1, 2)))))
        case "down":
            torque = 0.05 * drive.rating.rated_power_w / (fast * RADIANS_PER_RPM)
            least = (fast - slow) * RADIANS_PER_RPM * drive.machine.inertia_kg_m2 / (COASTING_SHARE * torque)
            over = tidy(scale.tenth_s * math.ceil(least / scale.tenth_s))
            run = with_speed(run, stepped(fast, slow, at, over_s=over))
    return run


def _with_course(run: Scenario, course: str, random: Random, at: float, share: float) -> Scenario:
    # Nothing is drawn below a tenth of rated power, where a band's own steps are most of the current.
    shares = [round(0.1 * count, 1) for count in range(1, 11)]
    less, more = sorted(random.sample([part for part in shares if part * share >= LIGHTEST], 2))
    match course:
        case "up":
            return with_load_shares(run, (0.0, less), (at, more))
        case "down":
            return with_load_shares(run, (0.0, more), (at, less))
    scale = scale_of(run.drive)
    lasts = scale.units(random.choice((0.5, 1.0, 2.0)))
    return with_load_factor(run, load_course(course, less, more, at, lasts, scale))


def _moment(drive: DriveDocument, row: Row, random: Random) -> float:
    """Draw when something happens: all at once after a search that has converged, or each for itself during it."""
    scale = scale_of(drive)
    return (
        scale.settled_s if row["moment"] == "settled" else tidy(scale.change_step_s * random.randint(1, 10))
    )


def _changed(run: Scenario, row: Row, random: Random) -> Scenario:
    """Put the rest of a row upon its base."""
    run = with_beginning(
        run,
        control_period_s=_PERIODS[row["control period"]],
        clock_start_s=_CLOCKS[row["clock"]],
        initial_angle_deg=0.0 if row["rotor"] == "0°" else 12.0 * random.randrange(1, 30),
    )
    # A drive without what a change is about goes without that change.
    is_possible = {
        "unequal halves": run.drive.has_split_supply,
        "false edges": has_encoder(real_sensors(run.drive), run.drive),
    }
    for changes in (_PLANTS, _SENSORS, _SUPPLIES, _FAULTS):
        for level in row.values():
            if level in changes and is_possible.get(level, True):
                run = changes[level](run, random, _moment(run.drive, row, random))
    return run


def _phase(run: Scenario, random: Random) -> int:
    return random.randint(1, run.drive.machine.phases)


def _lost_s(run: Scenario, random: Random) -> float:
    return tidy(scale_of(run.drive).dropout_step_s * random.choice((1, 5, 10, 20)))


def _times(run: Scenario, at: float) -> tuple[float, ...]:
    return moments(at, every_s=scale_of(run.drive).repeated_every_s)


def _with_drift(run: Scenario, random: Random, at: float) -> Scenario:
    over = scale_of(run.drive).units(5)
    return with_drift(
        run,
        resistance=stepped(1.0, random.choice((1.2, 1.4)), at, over_s=over),
        emf_constant=stepped(1.0, random.choice((0.96, 0.98)), at, over_s=over),
    )


_PLANTS: Final[Mapping[str, Change]] = {
    "resistance": lambda run, random, _: with_scales(run, resistance=random.choice((0.5, 1.5, 2.0))),
    "inductance": lambda run, random, _: with_scales(run, inductance=random.choice((0.8, 1.1, 1.2))),
    "EMF": lambda run, random, _: with_scales(run, emf_constant=random.choice((0.95, 1.05))),
    "friction": lambda run, random, _: with_scales(
        run, friction_added_n_m=tidy(scale_of(run.drive).torque_step_nm * random.choice((1, 3, 5)))
    ),
}
_SENSORS: Final[Mapping[str, Change]] = {
    "real": lambda run, random, _: with_real_sensors(run, random.randrange(1000)),
    "gain of a phase": lambda run, random, _: with_current_error(
        run, _phase(run, random), gain=random.choice((0.8, 0.9, 1.1, 1.2))
    ),
    "offset of a phase": lambda run, random, _: with_current_error(
        run,
        _phase(run, random),
        offset_a=tidy(scale_of(run.drive).offset_step_a * random.choice((-10, -5, 5, 10))),
    ),
}
_SUPPLIES: Final[Mapping[str, Change]] = {
    "dip": lambda run, random, at: with_supply(
        run, pulsed(1.0, random.choice((0.9, 0.95)), at, scale_of(run.drive).units(0.5))
    ),
    "sag": lambda run, random, at: with_supply(run, stepped(1.0, random.choice((0.92, 0.96)), at)),
    "swell": lambda run, random, at: with_supply(run, stepped(1.0, random.choice((1.05, 1.1)), at)),
}
_FAULTS: Final[Mapping[str, Change]] = {
    "speed lost": lambda run, random, at: with_dropout(run, "speed", at, _lost_s(run, random)),
    "currents lost": lambda run, random, at: with_dropout(run, "currents", at, _lost_s(run, random)),
    "supply lost": lambda run, random, at: with_dropout(run, "supply", at, _lost_s(run, random)),
    "sample of a phase lost twenty times": lambda run, random, at: with_lost_samples(
        run, _phase(run, random), _times(run, at)
    ),
    "false edges": lambda run, random, at: with_glitch(run, random.choice((-50, -20, 20, 50)), at),
    "unequal halves": lambda run, random, at: with_imbalance(
        run, stepped(0.0, random.choice((-0.03, 0.03)), at)
    ),
    "drift": _with_drift,
    "restart": lambda run, _, at: with_restarts(run, at),
    "restarted twenty times": lambda run, _, at: with_restarts(run, *_times(run, at)),
}
