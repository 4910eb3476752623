"""What every candidate of a comparison runs: one fixed list of scenarios, whatever the candidates and workers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Literal, TypeAlias

import numpy as np

from drivegate.drives.kinds import kind_of
from drivegate.scenarios.building import steady_scenario
from drivegate.scenarios.changes import (
    CHANGE_S,
    pulsed,
    stepped,
    with_load_shares,
    with_mcs96,
    with_scales,
    with_speed,
    with_supply,
)
from drivegate.studies.compare.drive_cycle_run import cycle_scenario
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.drive_cycle import DriveCycle
from drivegate_cases.scenario.scenario import Scenario

Group: TypeAlias = Literal["points", "disturbances", "noise", "drawn", "cycle"]
"""Kinds of runs of a comparison."""


@dataclass(frozen=True)
class ComparisonEffort:
    """How much is run.

    Attributes
    ----------
    speeds_rpm : tuple of float
        Speeds of the operating points (rpm).
    shares : tuple of float
        Their loads, as shares of the drive's rated power (1).
    disturbances : int
        How many of the disturbances.
    noise_seeds : int
        Repetitions of each noisy operating point, and of the drive cycle, with other noise.
    drawn : int
        Scenarios drawn at random.
    """

    speeds_rpm: tuple[float, ...]
    shares: tuple[float, ...]
    disturbances: int
    noise_seeds: int
    drawn: int


EFFORTS: Final = {
    "quick": ComparisonEffort((550.0, 1000.0, 1500.0, 2000.0), (0.25, 0.5, 0.75, 1.0), 4, 3, 10),
    "default": ComparisonEffort(
        (550.0, 700.0, 850.0, 1000.0, 1200.0, 1500.0, 1750.0, 2000.0),
        (0.1, 0.25, 0.4, 0.55, 0.7, 0.85, 1.0),
        7,
        5,
        30,
    ),
    "nightly": ComparisonEffort(
        tuple(np.arange(550.0, 2001.0, 50.0).tolist()),
        (0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0),
        7,
        20,
        200,
    ),
}
"""What is run, by the name of the effort."""

NOISY_POINTS: Final = ((700.0, 1.0), (1100.0, 0.5), (1500.0, 1.0))
"""Speed (rpm) and share of rated power of the operating points that are repeated with other noise."""
_MOST_DRAWS: Final = 100
"""Draws for one scenario that is fair, at most."""


@dataclass(frozen=True)
class PlannedRun:
    """One run that every candidate makes.

    Attributes
    ----------
    group : str
        What the run is for.
    label : str
        What it is, for people; the same label stands for repetitions with other noise.
    scenario : Scenario
        The scenario.
    speed_rpm, share : float or None
        The operating point where it is one; share of rated power (1).
    change_s : float or None
        When the disturbance is over (s).
    seed : int or None
        Number of the repetition or draw.
    """

    group: Group
    label: str
    scenario: Scenario
    speed_rpm: float | None = None
    share: float | None = None
    change_s: float | None = None
    seed: int | None = None


def planned_runs(drive: DriveDocument, cycle: DriveCycle, effort: str, seed: int) -> tuple[PlannedRun, ...]:
    """Plan the runs of a comparison."""
    size = EFFORTS[effort]
    return (
        *_operating_points(drive, size),
        *disturbances(drive)[: size.disturbances],
        *_noisy(drive, size, seed),
        *_drawn(drive, size, seed),
        *_cycles(drive, cycle, size, seed),
    )


def _point(drive: DriveDocument, speed_rpm: float, share: float) -> Scenario:
    return steady_scenario(drive, speed_rpm, power_share=share, constant_power=False)


def _operating_points(drive: DriveDocument, size: ComparisonEffort) -> Iterator[PlannedRun]:
    for speed in size.speeds_rpm:
        for share in size.shares:
            label = f"{speed:g} rpm, {100.0 * share:g} %"
            yield PlannedRun("points", label, _point(drive, speed, share), speed, share)


def disturbances(drive: DriveDocument) -> tuple[PlannedRun, ...]:
    """List the runs in which something changes once a search has converged."""
    rated = steady_scenario(drive, 900.0, power_share=1.0, constant_power=True)
    full, fast = _point(drive, 1500.0, 1.0), _point(drive, 1400.0, 0.6)
    listed: tuple[tuple[str, Scenario, float], ...] = (
        (
            "load step up, 50 to 100 % at 1500 rpm",
            with_load_shares(full, (0.0, 0.5), (CHANGE_S, 1.0)),
            CHANGE_S,
        ),
        (
            "supply dip of 10 % for 0.5 s at 1500 rpm, 80 %",
            with_supply(_point(drive, 1500.0, 0.8), pulsed(1.0, 0.9, CHANGE_S, 0.5)),
            CHANGE_S + 0.5,
        ),
        (
            "speed step up, 900 to 1400 rpm",
            with_speed(fast, stepped(900.0, 1400.0, CHANGE_S)),
            CHANGE_S,
        ),
        (
            "load step down, 100 to 50 % at 1500 rpm",
            with_load_shares(full, (0.0, 1.0), (CHANGE_S, 0.5)),
            CHANGE_S,
        ),
        (
            "load step up, 50 to 100 % of constant power at 900 rpm",
            with_load_shares(rated, (0.0, 0.5), (CHANGE_S, 1.0)),
            CHANGE_S,
        ),
        (
            "speed ramp down, 1400 to 900 rpm in 2 s",
            with_speed(fast, stepped(1400.0, 900.0, CHANGE_S, over_s=2.0)),
            CHANGE_S + 2.0,
        ),
        (
            "supply step down by 8 % at 1150 rpm, rated power",
            with_supply(
                steady_scenario(drive, 1150.0, power_share=1.0, constant_power=True),
                stepped(1.0, 0.92, CHANGE_S),
            ),
            CHANGE_S,
        ),
    )
    return tuple(
        PlannedRun("disturbances", label, scenario, change_s=change) for label, scenario, change in listed
    )


def _noise_seed(seed: int, number: int) -> int:
    """Give each repetition noise of its own."""
    return int(np.random.SeedSequence([seed, number]).generate_state(1)[0])


def _noisy(drive: DriveDocument, size: ComparisonEffort, seed: int) -> Iterator[PlannedRun]:
    for speed, share in NOISY_POINTS:
        for number in range(size.noise_seeds):
            scenario = with_mcs96(_point(drive, speed, share), seed=_noise_seed(seed, number))
            label = f"{speed:g} rpm, {100.0 * share:g} %, noisy sensors"
            yield PlannedRun("noise", label, scenario, speed, share, seed=number)


def _drawn(drive: DriveDocument, size: ComparisonEffort, seed: int) -> Iterator[PlannedRun]:
    for number in range(size.drawn):
        generator = np.random.default_rng([seed, 1_000_000 + number])
        for _ in range(_MOST_DRAWS):
            speed, share, scenario = _draw(drive, generator)
            if kind_of(scenario.drive).is_fair(scenario):
                noisy = with_mcs96(scenario, seed=_noise_seed(seed, 1_000_000 + number))
                yield PlannedRun("drawn", noisy.name, noisy, speed, share, seed=number)
                break


def _draw(drive: DriveDocument, generator: np.random.Generator) -> tuple[float, float, Scenario]:
    """Draw an operating point and a plant within the ranges of ROB-1, in whole steps."""

    def whole(low: int, high: int) -> int:
        return int(generator.integers(low, high + 1))

    speed = 10.0 * whole(55, 150)
    share = round(0.05 * whole(6, 20), 2)
    scenario = with_scales(
        _point(drive, speed, share),
        resistance=round(0.1 * whole(5, 20), 2),
        inductance=round(0.05 * whole(16, 24), 2),
        emf_constant=round(0.01 * whole(95, 105), 2),
        friction_added_n_m=round(0.1 * whole(0, 5), 2),
    )
    return speed, share, scenario


def _cycles(
    drive: DriveDocument, cycle: DriveCycle, size: ComparisonEffort, seed: int
) -> Iterator[PlannedRun]:
    yield PlannedRun("cycle", "ideal sensors", cycle_scenario(cycle, drive))
    for number in range(size.noise_seeds):
        scenario = cycle_scenario(cycle, drive, noise_seed=_noise_seed(seed, 2_000_000 + number))
        yield PlannedRun("cycle", "noisy sensors", scenario, seed=number)
