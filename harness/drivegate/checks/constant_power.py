"""Checks of the constant-power range: that rated power is held there, and beyond."""

from __future__ import annotations

import math

from drivegate.checks.check import Check
from drivegate.checks.convergence import SPEED_TOLERANCE, described, speed_in_words
from drivegate.checks.declared_speeds import unless_speeds_from
from drivegate.checks.margin import Margin, at_most
from drivegate.runs.record import RunRecord, SteadyWindow
from drivegate_cases.scenario.circumstance import Circumstance

LOWEST_RPM = 550.0
"""Speed from which constant power is required (rpm)."""
HIGHEST_RPM = 1500.0
"""Speed up to which constant power is required, three times base speed (rpm)."""
HIGHEST_ADVISED_RPM = 2000.0
"""Speed up to which constant power is advised (rpm)."""


def holds_constant_power(record: RunRecord) -> Margin | None:
    """Judge whether rated power is held within k1 (paper, "Constant Power Operation", Fig. 3)."""
    return _held(
        "CPW-1", record, [w for w in record.windows() if LOWEST_RPM <= w.dwell.speed_rpm <= HIGHEST_RPM]
    )


def holds_constant_power_beyond(record: RunRecord) -> Margin | None:
    """Judge whether rated power is held within k1 beyond three times base speed (paper, Fig. 10)."""
    return _held(
        "CPW-2",
        record,
        [w for w in record.windows() if HIGHEST_RPM < w.dwell.speed_rpm <= HIGHEST_ADVISED_RPM],
    )


def _held(check: str, record: RunRecord, windows: list[SteadyWindow]) -> Margin | None:
    if record.circumstance is not Circumstance.NOMINAL:
        return None
    loaded = [window for window in windows if window.requires_rated_power]
    if not loaded:
        return None
    worst = max(loaded, key=_speed_error)
    error = _speed_error(worst)
    measured = f"{speed_in_words(worst)}{described(worst)}"
    return Margin(check, at_most(error, SPEED_TOLERANCE), measured)


def _speed_error(window: SteadyWindow) -> float:
    return window.values.speed_error


CPW_1 = Check(
    id="CPW-1",
    requirement="Constant power: 1.5 kW is held within k1 at every speed from 550 to 1500 rpm.",
    source="P5, P10",
    subject="candidate",
    level="required",
    limit="k1 = 5 rpm",
    scenarios="every steady stretch of 9 s or more that requires 1.5 kW, on the nominal drive",
    formula="1 - |speed error| / k1",
    why="Constant power over the whole high-speed range is what the advance angle is for.",
    evaluate=holds_constant_power,
    reason_not_applicable=unless_speeds_from(LOWEST_RPM, HIGHEST_RPM),
)
CPW_2 = Check(
    id="CPW-2",
    requirement="Constant power beyond three times base speed: 1.5 kW is held within k1 at speeds up to 2000 rpm.",
    source="P10",
    subject="candidate",
    level="advisory",
    limit="k1 = 5 rpm",
    scenarios="every steady stretch of 9 s or more that requires 1.5 kW above 1500 rpm, on the nominal drive",
    formula="1 - |speed error| / k1",
    why="The paper puts the limit of its drive beyond three times base speed, without a number.",
    evaluate=holds_constant_power_beyond,
    reason_not_applicable=unless_speeds_from(
        math.nextafter(HIGHEST_RPM, HIGHEST_ADVISED_RPM), HIGHEST_ADVISED_RPM
    ),
)
