"""Scenarios of joint changes: a fair run for each row of the covering array, and long runs at rated load."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from random import Random
from typing import Final, TypeAlias

from drivegate.scenarios.building import DWELL_S, LOAD_RAMP_S, steady_scenario, tidy, vehicle_scenario
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
    with_mcs96,
    with_restarts,
    with_scales,
    with_speed,
    with_supply,
)
from drivegate.scenarios.covering import Row, covering_rows
from drivegate.scenarios.drawn.changes import COASTING_SHARE
from drivegate.scenarios.drawn.courses import load_course, standstill_scenario
from drivegate.scenarios.feasibility import unfair_because
from drivegate.scenarios.speed_range import HIGHEST_LOADED, SpeedRange, loaded_range
from drivegate.scenarios.title import titled
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.load import FanLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

Change: TypeAlias = Callable[[Scenario, Random, float], Scenario]
"""From a run, random numbers and a time to the run changed then."""

ATTEMPTS: Final = 60
"""Draws for one row, ever lighter ones, before it is left out."""
LIGHTEST: Final = 0.1
"""Lightest load that is drawn, as a share of rated power (1)."""
LONG_S: Final = 150.0
"""Length of a long run, beside which the time of every search is short (s)."""
_REST_S: Final = 6.0
_HIGHEST_ADVISED: Final = 4.0
_SETTLED_S: Final = 7.0
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
    for the search to come to rest in between.
    """
    random = Random(f"{seed}/long")
    lowest, highest = loaded_range(drive, speed_range)
    plain, late, busy = (
        steady_scenario(drive, _whole(random, lowest, highest), power_share=1.0, constant_power=False)
        for _ in range(3)
    )
    changed = with_load_shares(late, (0.0, 1.0), (LONG_S - DWELL_S, 0.5))
    to_and_fro = repeated(1.0, 0.5, _REST_S, times=12, every_s=2.0 * _REST_S)
    return (
        titled(plain.replaced(duration_s=LONG_S)),
        with_mcs96(changed, random.randrange(1000)),
        with_load_factor(busy, ((0.0, 0.0), (LOAD_RAMP_S, 1.0), *to_and_fro[1:])),
    )


def _whole_speeds(lowest: float, highest: float) -> list[float]:
    """List the speeds of whole steps of 10 rpm, or the highest where there is none."""
    bottom, top = math.ceil(lowest / 10.0), math.floor(highest / 10.0)
    return [10.0 * steps for steps in range(bottom, top + 1)] or [highest]


def _whole(random: Random, lowest: float, highest: float) -> float:
    return random.choice(_whole_speeds(lowest, highest))


def _speeds_of_row(drive: DriveDocument, speed_range: SpeedRange | None, row: Row) -> tuple[float, float]:
    if row["speed course"] == "overspeed":
        return HIGHEST_LOADED * drive.rating.base_speed_rpm, _HIGHEST_ADVISED * drive.rating.base_speed_rpm
    return loaded_range(drive, speed_range)


def _speed_in_turn(lowest: float, highest: float, seed: int, number: int) -> float:
    """Take a speed of a range in an order of chance: no two rows have the same one before all were had."""
    speeds = _whole_speeds(lowest, highest)
    Random(f"{seed}/speeds").shuffle(speeds)
    return speeds[number % len(speeds)]


def _drawn(
    drive: DriveDocument, speed_range: SpeedRange | None, row: Row, seed: int, number: int
) -> Scenario | None:
    if speed_range is not None and row["speed course"] in ("standstill", "overspeed"):
        return None
    random = Random(f"{seed}/{number}")
    lowest, highest = _speeds_of_row(drive, speed_range, row)
    speed = _speed_in_turn(lowest, highest, seed, number)
    for attempt in range(ATTEMPTS):
        heaviest = 1.0 - 0.8 * attempt / ATTEMPTS
        other = _whole(random, lowest, highest)
        scenario = _changed(_base(drive, row, random, heaviest, (speed, other)), row, random)
        if unfair_because(scenario) is None:
            return scenario
    return None


def _base(
    drive: DriveDocument, row: Row, random: Random, heaviest: float, speeds: tuple[float, float]
) -> Scenario:
    """Make a run with the row's load and courses of speed and load, at the first speed or between both."""
    slow, fast = sorted(speeds) if row["speed course"] in ("up", "down") else (speeds[0], speeds[0])
    share = _share(random, heaviest)
    at = _moment(row, random)
    if row["load"] == "vehicle":
        grade = stepped(0.0, 1.0, at) if row["load course"] == "up" else ((0.0, 0.0),)
        run = vehicle_scenario(drive, fast, mass_kg=150.0, gear_ratio=8.0, grade_percent=grade)
    elif row["speed course"] == "standstill":
        torque = min(share * drive.rating.rated_power_w / (fast * RADIANS_PER_RPM), 12.0)
        run = standstill_scenario(drive, fast, torque_nm=torque, at_s=at, over_s=1.0)
    else:
        run = steady_scenario(drive, fast, power_share=share, constant_power=row["load"] == "power")
        if row["load"] == "fan":
            torque = round(share * drive.rating.rated_power_w / (fast * RADIANS_PER_RPM), 3)
            fan = FanLoad(
                kind="fan", torque_nm=torque, speed_rpm=fast, factor=((0.0, 0.0), (LOAD_RAMP_S, 1.0))
            )
            run = run.replaced(load=fan)
    if row["load course"] != "steady" and row["load"] != "vehicle":
        run = _with_course(run, row["load course"], random, at, share)
    match row["speed course"]:
        case "up":
            run = with_speed(run, stepped(slow, fast, at, over_s=random.choice((0.0, 1.0, 2.0))))
        case "down":
            torque = 0.05 * drive.rating.rated_power_w / (fast * RADIANS_PER_RPM)
            least = (fast - slow) * RADIANS_PER_RPM * drive.machine.inertia_kg_m2 / (COASTING_SHARE * torque)
            run = with_speed(run, stepped(fast, slow, at, over_s=tidy(0.1 * math.ceil(10.0 * least))))
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
    return with_load_factor(run, load_course(course, less, more, at, random.choice((0.5, 1.0, 2.0))))


def _share(random: Random, heaviest: float) -> float:
    return round(0.05 * random.randint(3, max(3, round(20.0 * heaviest))), 2)


def _moment(row: Row, random: Random) -> float:
    """Draw when something happens: all at once after a search that has converged, or each for itself during it."""
    return _SETTLED_S if row["moment"] == "settled" else 0.5 * random.randint(1, 10)


def _changed(run: Scenario, row: Row, random: Random) -> Scenario:
    """Put the rest of a row upon its base."""
    run = with_beginning(
        run,
        control_period_s=_PERIODS[row["control period"]],
        clock_start_s=_CLOCKS[row["clock"]],
        initial_angle_deg=0.0 if row["rotor"] == "0°" else 12.0 * random.randrange(1, 30),
    )
    for changes in (_PLANTS, _SENSORS, _SUPPLIES, _FAULTS):
        for level in row.values():
            if level in changes:
                run = changes[level](run, random, _moment(row, random))
    return run


def _phase(run: Scenario, random: Random) -> int:
    return random.randint(1, run.drive.machine.phases)


def _milliseconds(random: Random) -> float:
    return random.choice((0.001, 0.005, 0.01, 0.02))


def _with_lost_samples(run: Scenario, random: Random, at: float) -> Scenario:
    phase = _phase(run, random)
    for time in moments(at):
        run = with_dropout(run, "currents", time, run.control_period_s, phase=phase)
    return run


_PLANTS: Final[Mapping[str, Change]] = {
    "resistance": lambda run, random, _: with_scales(run, resistance=random.choice((0.5, 1.5, 2.0))),
    "inductance": lambda run, random, _: with_scales(run, inductance=random.choice((0.8, 1.1, 1.2))),
    "EMF": lambda run, random, _: with_scales(run, emf_constant=random.choice((0.95, 1.05))),
    "friction": lambda run, random, _: with_scales(run, friction_added_n_m=random.choice((0.1, 0.3, 0.5))),
}
_SENSORS: Final[Mapping[str, Change]] = {
    "mcs96": lambda run, random, _: with_mcs96(run, random.randrange(1000)),
    "gain of a phase": lambda run, random, _: with_current_error(
        run, _phase(run, random), gain=random.choice((0.8, 0.9, 1.1, 1.2))
    ),
    "offset of a phase": lambda run, random, _: with_current_error(
        run, _phase(run, random), offset_a=random.choice((-0.2, -0.1, 0.1, 0.2))
    ),
}
_SUPPLIES: Final[Mapping[str, Change]] = {
    "dip": lambda run, random, at: with_supply(run, pulsed(1.0, random.choice((0.9, 0.95)), at, 0.5)),
    "sag": lambda run, random, at: with_supply(run, stepped(1.0, random.choice((0.92, 0.96)), at)),
    "swell": lambda run, random, at: with_supply(run, stepped(1.0, random.choice((1.05, 1.1)), at)),
}
_FAULTS: Final[Mapping[str, Change]] = {
    "speed lost": lambda run, random, at: with_dropout(run, "speed", at, _milliseconds(random)),
    "currents lost": lambda run, random, at: with_dropout(run, "currents", at, _milliseconds(random)),
    "supply lost": lambda run, random, at: with_dropout(run, "supply", at, _milliseconds(random)),
    "sample of a phase lost twenty times": _with_lost_samples,
    "false edges": lambda run, random, at: with_glitch(run, random.choice((-50, -20, 20, 50)), at),
    "unequal halves": lambda run, random, at: with_imbalance(
        run, stepped(0.0, random.choice((-0.03, 0.03)), at)
    ),
    "drift": lambda run, random, at: with_drift(
        run,
        resistance=stepped(1.0, random.choice((1.2, 1.4)), at, over_s=5.0),
        emf_constant=stepped(1.0, random.choice((0.96, 0.98)), at, over_s=5.0),
    ),
    "restart": lambda run, _, at: with_restarts(run, at),
    "restarted twenty times": lambda run, _, at: with_restarts(run, *moments(at)),
}
