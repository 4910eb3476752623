"""The fixed runs of operations that are rarely tried, in which firmware has failed in the field."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final, TypeAlias

from drivegate.contracts.current.scenarios.building import (
    coming_on,
    standstill_scenario,
    steady_scenario,
)
from drivegate.scenarios.changes import (
    moments,
    pulsed,
    stepped,
    with_beginning,
    with_dropout,
    with_load_factor,
    with_supply,
)
from drivegate.scenarios.clocks import wraps_s
from drivegate.scenarios.drive_scale import scale_of, tidy
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario

RareRuns: TypeAlias = Callable[[DriveDocument], list[Scenario]]
"""From a drive to the runs of one kind."""

LEAST_WRAP_S: Final = 60.0
"""Least time after which a clock wraps around in a run (s): joint changes and the long run reach earlier ones."""
SHORT_PERIOD_S: Final = 5e-5
"""Shortest control period of any run (s)."""
# Speed of the run with it, as a share of the range from base speed to the highest.
_FAST: Final = 0.8
# Its load, as a share of rated power's: `CNV-2` only advises on less than half, and torques are rounded.
_ABOVE_HALF: Final = 0.52
LONG_S: Final = 75.0
"""Time of a load step in the long run (s): more than a minute, in which milliseconds in 16 bits wrap around."""


def rare_scenarios(drive: DriveDocument) -> list[Scenario]:
    """List the runs of every kind."""
    return [run for runs in RARE.values() for run in runs(drive)]


def _loaded(drive: DriveDocument, power_share: float = 0.5) -> Scenario:
    """Make a run in the middle of the range."""
    return steady_scenario(drive, scale_of(drive).speed(0.5), power_share=power_share, constant_power=False)


def _late_clocks(drive: DriveDocument) -> list[Scenario]:
    """Make the runs in which a clock wraps around shortly before their end, where the search has come to rest."""
    run = _loaded(drive)
    wraps = (wrap for wrap in wraps_s(run.control_period_s) if wrap > LEAST_WRAP_S)
    before = run.duration_s - scale_of(drive).units(1)
    return [with_beginning(run, clock_start_s=round(wrap - before, 6)) for wrap in wraps]


def _short_period(drive: DriveDocument) -> list[Scenario]:
    """Make the run with the shortest control period, at part load and a high speed.

    There Σ|i| takes long to follow a step of the angle, and a search that decides too early by the number of its steps
    shows it.
    """
    fast = scale_of(drive).speed(_FAST)
    run = steady_scenario(drive, fast, power_share=_ABOVE_HALF, constant_power=False)
    return [with_beginning(run, control_period_s=SHORT_PERIOD_S)]


def _minutes(drive: DriveDocument) -> list[Scenario]:
    """Make the run whose rated load falls and comes back after more than a minute."""
    factor = (*coming_on(drive), *pulsed(1.0, 0.6, LONG_S, scale_of(drive).dwell_s)[1:])
    return [with_load_factor(_loaded(drive, 1.0), factor)]


def _lost_samples(drive: DriveDocument) -> list[Scenario]:
    """Make the run in which a few samples of the speed, then one of all currents are lost, twenty times."""
    scale, run = scale_of(drive), _loaded(drive, 0.8)
    period = run.control_period_s
    for at in moments(scale.change_s, every_s=scale.repeated_every_s):
        run = with_dropout(run, "speed", at, tidy(4 * period))
        run = with_dropout(run, "currents", tidy(at + 0.25 * scale.repeated_every_s), period)
    return [run]


def _swell(drive: DriveDocument) -> list[Scenario]:
    return [with_supply(_loaded(drive, 0.8), stepped(1.0, 1.1, scale_of(drive).change_s))]


def _stop(drive: DriveDocument) -> list[Scenario]:
    """Make the run that comes to standstill under a load, and leaves it again."""
    scale = scale_of(drive)
    torque, at = scale.standstill_torque_nm, scale.change_s
    return [standstill_scenario(drive, scale.speed(0.6), torque_nm=torque, at_s=at, over_s=0.0)]


RARE: Final[Mapping[str, RareRuns]] = MappingProxyType(
    {
        "clocks": _late_clocks,
        "short control period": _short_period,
        "minutes": _minutes,
        "lost samples again and again": _lost_samples,
        "supply above its nominal voltage": _swell,
        "standstill": _stop,
    }
)
"""The kinds of operation, by their names, each with its runs."""
