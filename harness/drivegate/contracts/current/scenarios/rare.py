"""The fixed runs of operations that are rarely tried, in which firmware has failed in the field."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final, TypeAlias

from drivegate.contracts.current.scenarios.building import coming_on, steady_scenario
from drivegate.scenarios.changes import (
    pulsed,
    with_beginning,
    with_load_factor,
)
from drivegate.scenarios.clocks import wraps_s
from drivegate.scenarios.drive_scale import scale_of
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario

RareRuns: TypeAlias = Callable[[DriveDocument], list[Scenario]]
"""From a drive to the runs of one kind."""

LEAST_WRAP_S: Final = 60.0
"""Least time after which a clock wraps around in a run (s): joint changes and the long run reach earlier ones."""
SHORT_PERIOD_S: Final = 1e-4
"""Control period of the run with a short one (s)."""
LONG_S: Final = 75.0
"""Time of a load step in the long run (s): more than a minute, in which milliseconds in 16 bits wrap around."""


def rare_scenarios(drive: DriveDocument) -> list[Scenario]:
    """List the runs of every kind."""
    return [run for runs in RARE.values() for run in runs(drive)]


def _loaded(drive: DriveDocument) -> Scenario:
    """Make the run of half rated power in the middle of the range."""
    return steady_scenario(drive, scale_of(drive).speed(0.5), power_share=0.5, constant_power=False)


def _late_clocks(drive: DriveDocument) -> list[Scenario]:
    """Make the runs in which a clock wraps around shortly before their end, where the search has come to rest."""
    run = _loaded(drive)
    wraps = (wrap for wrap in wraps_s(run.control_period_s) if wrap > LEAST_WRAP_S)
    before = run.duration_s - scale_of(drive).units(1)
    return [with_beginning(run, clock_start_s=round(wrap - before, 6)) for wrap in wraps]


def _short_period(drive: DriveDocument) -> list[Scenario]:
    return [with_beginning(_loaded(drive), control_period_s=SHORT_PERIOD_S)]


def _minutes(drive: DriveDocument) -> list[Scenario]:
    """Make the run whose load falls and comes back after more than a minute."""
    factor = (*coming_on(drive), *pulsed(1.0, 0.6, LONG_S, scale_of(drive).dwell_s)[1:])
    return [with_load_factor(_loaded(drive), factor)]


RARE: Final[Mapping[str, RareRuns]] = MappingProxyType(
    {
        "clocks": _late_clocks,
        "short control period": _short_period,
        "minutes": _minutes,
    }
)
"""The kinds of operation, by their names, each with its runs."""
