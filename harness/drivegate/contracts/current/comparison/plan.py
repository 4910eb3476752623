"""What every candidate of a comparison runs: one fixed list of scenarios, whatever the candidates and workers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from drivegate.contracts.comparison import ComparisonRequest, PlannedRun
from drivegate.contracts.current.comparison.drive_cycle import cycle_scenario
from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.contracts.current.scenarios.feasibility import is_fair
from drivegate.scenarios.changes import (
    pulsed,
    stepped,
    with_load_shares,
    with_real_sensors,
    with_scales,
    with_speed,
    with_supply,
)
from drivegate.scenarios.drive_scale import scale_of, tidy
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.drive_cycle import DriveCycle
from drivegate_cases.scenario.scenario import Scenario


@dataclass(frozen=True)
class ComparisonEffort:
    """How much is run."""

    speeds: tuple[float, ...]
    """Speeds of the operating points: up to 1, shares of the range from base speed to the highest; beyond, 1
    and the share of the range from there to overspeed (1)."""
    shares: tuple[float, ...]
    """Their loads, as shares of the drive's rated power (1)."""
    disturbances: int
    """How many of the disturbances."""
    noise_seeds: int
    """Repetitions of each noisy operating point, and of the drive cycle, with other noise."""
    drawn: int
    """Scenarios drawn at random."""


EFFORTS: Final = {
    "quick": ComparisonEffort((0.05, 0.5, 1.0, 2.0), (0.25, 0.5, 0.75, 1.0), 4, 3, 10),
    "default": ComparisonEffort(
        (0.05, 0.2, 0.35, 0.5, 0.7, 1.0, 1.5, 2.0),
        (0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0),
        7,
        5,
        30,
    ),
    "nightly": ComparisonEffort(
        tuple(0.05 * step for step in range(1, 21)) + tuple(1.0 + 0.1 * step for step in range(1, 11)),
        (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0),
        7,
        20,
        200,
    ),
}
"""What is run, by the name of the effort."""

NOISY_POINTS: Final = ((0.2, 1.0), (0.6, 0.5), (1.0, 1.0))
"""Operating points that are repeated with other noise: shares of the drive's range of speeds, and of rated power."""
_MOST_DRAWS: Final = 100
"""Draws for one scenario that is fair, at most."""


def planned_runs(request: ComparisonRequest) -> tuple[PlannedRun, ...]:
    """Plan the runs of a comparison."""
    drive, seed, size = request.drive, request.seed, EFFORTS[request.effort]
    return (
        *_operating_points(drive, size),
        *disturbances(drive)[: size.disturbances],
        *_noisy(drive, size, seed),
        *_drawn(drive, size, seed),
        *_cycles(drive, request.cycle, size, seed),
    )


def operating_speed(drive: DriveDocument, share: float) -> float:
    """Return the speed of an operating point (rpm) by its share, as `ComparisonEffort.speeds` has it."""
    scale = scale_of(drive)
    return scale.speed(share) if share <= 1.0 else scale.speed_beyond(share - 1.0)


def _point(drive: DriveDocument, speed_rpm: float, share: float) -> Scenario:
    return steady_scenario(drive, speed_rpm, power_share=share, constant_power=False)


def _operating_points(drive: DriveDocument, size: ComparisonEffort) -> Iterator[PlannedRun]:
    for speed in dict.fromkeys(operating_speed(drive, share) for share in size.speeds):
        for share in size.shares:
            label = f"{speed:g} rpm, {100.0 * share:g} %"
            yield PlannedRun("points", label, _point(drive, speed, share), speed, share)


def disturbances(drive: DriveDocument) -> tuple[PlannedRun, ...]:
    """List the runs in which something changes once a search has converged."""
    scale = scale_of(drive)
    at, brief, ramp = scale.change_s, scale.units(0.5), scale.units(2)
    slow, fast, highest, middle = scale.speed(0.4), scale.speed(0.9), scale.speed(1.0), scale.speed(0.65)
    rated = steady_scenario(drive, slow, power_share=1.0, constant_power=True)
    full, faster = _point(drive, highest, 1.0), _point(drive, fast, 0.6)
    listed: tuple[tuple[str, Scenario, float], ...] = (
        (
            f"load step up, 50 to 100 % at {highest:g} rpm",
            with_load_shares(full, (0.0, 0.5), (at, 1.0)),
            at,
        ),
        (
            f"supply dip of 10 % for {brief:g} s at {highest:g} rpm, 80 %",
            with_supply(_point(drive, highest, 0.8), pulsed(1.0, 0.9, at, brief)),
            tidy(at + brief),
        ),
        (
            f"speed step up, {slow:g} to {fast:g} rpm",
            with_speed(faster, stepped(slow, fast, at)),
            at,
        ),
        (
            f"load step down, 100 to 50 % at {highest:g} rpm",
            with_load_shares(full, (0.0, 1.0), (at, 0.5)),
            at,
        ),
        (
            f"load step up, 50 to 100 % of constant power at {slow:g} rpm",
            with_load_shares(rated, (0.0, 0.5), (at, 1.0)),
            at,
        ),
        (
            f"speed ramp down, {fast:g} to {slow:g} rpm in {ramp:g} s",
            with_speed(faster, stepped(fast, slow, at, over_s=ramp)),
            tidy(at + ramp),
        ),
        (
            f"supply step down by 8 % at {middle:g} rpm, rated power",
            with_supply(
                steady_scenario(drive, middle, power_share=1.0, constant_power=True),
                stepped(1.0, 0.92, at),
            ),
            at,
        ),
    )
    return tuple(
        PlannedRun("disturbances", label, scenario, change_s=change) for label, scenario, change in listed
    )


def _noise_seed(seed: int, number: int) -> int:
    """Give each repetition noise of its own."""
    return int(np.random.SeedSequence([seed, number]).generate_state(1)[0])


def _noisy(drive: DriveDocument, size: ComparisonEffort, seed: int) -> Iterator[PlannedRun]:
    for speed_share, share in NOISY_POINTS:
        speed = scale_of(drive).speed(speed_share)
        for number in range(size.noise_seeds):
            scenario = with_real_sensors(_point(drive, speed, share), seed=_noise_seed(seed, number))
            label = f"{speed:g} rpm, {100.0 * share:g} %, noisy sensors"
            yield PlannedRun("noise", label, scenario, speed, share, seed=number)


def _drawn(drive: DriveDocument, size: ComparisonEffort, seed: int) -> Iterator[PlannedRun]:
    for number in range(size.drawn):
        generator = np.random.default_rng([seed, 1_000_000 + number])
        for _ in range(_MOST_DRAWS):
            speed, share, scenario = _draw(drive, generator)
            if is_fair(scenario):
                noisy = with_real_sensors(scenario, seed=_noise_seed(seed, 1_000_000 + number))
                yield PlannedRun("drawn", noisy.name, noisy, speed, share, seed=number)
                break


def _draw(drive: DriveDocument, generator: np.random.Generator) -> tuple[float, float, Scenario]:
    """Draw an operating point and a plant within the ranges of ROB-1, in whole steps."""

    def whole(low: int, high: int) -> int:
        return int(generator.integers(low, high + 1))

    scale = scale_of(drive)
    step = scale.speed_step_rpm
    lowest, highest = math.ceil(scale.lowest_loaded_rpm / step), math.floor(scale.highest_loaded_rpm / step)
    speed = tidy(step * whole(min(lowest, highest), highest))
    share = round(0.05 * whole(6, 20), 2)
    scenario = with_scales(
        _point(drive, speed, share),
        resistance=round(0.1 * whole(5, 20), 2),
        inductance=round(0.05 * whole(16, 24), 2),
        emf_constant=round(0.01 * whole(95, 105), 2),
        friction_added_n_m=tidy(scale.torque_step_nm * whole(0, 5)),
    )
    return speed, share, scenario


def _cycles(
    drive: DriveDocument, cycle: DriveCycle, size: ComparisonEffort, seed: int
) -> Iterator[PlannedRun]:
    yield PlannedRun("cycle", "ideal sensors", cycle_scenario(cycle, drive))
    for number in range(size.noise_seeds):
        scenario = cycle_scenario(cycle, drive, noise_seed=_noise_seed(seed, 2_000_000 + number))
        yield PlannedRun("cycle", "noisy sensors", scenario, seed=number)
