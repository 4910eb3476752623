"""Checks of the constant-power range: that rated power is held there, and beyond."""

from __future__ import annotations

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most
from drivegate.contracts.current.checks.convergence import described, speed_in_words, speed_tolerance
from drivegate.contracts.current.checks.declared_speeds import (
    JudgedSpeeds,
    beyond_constant_power,
    constant_power,
    unless_speeds,
)
from drivegate.contracts.current.record import CurrentRecord, SteadyWindow
from drivegate_cases.scenario.circumstance import Circumstance


def holds_constant_power(record: CurrentRecord) -> Margin | None:
    """Judge whether rated power is held within k1 (paper, "Constant Power Operation", Fig. 3)."""
    return _held("CPW-1", record, [window for window in record.windows() if is_in(constant_power, window)])


def holds_constant_power_beyond(record: CurrentRecord) -> Margin | None:
    """Judge whether rated power is held within k1 beyond the range of constant power (paper, Fig. 10)."""
    return _held(
        "CPW-2", record, [window for window in record.windows() if is_in(beyond_constant_power, window)]
    )


def is_in(judged: JudgedSpeeds, window: SteadyWindow) -> bool:
    """Return True if a window is at one of the speeds that a check judges."""
    lowest, highest = judged(window.scenario.drive)
    return lowest <= window.dwell.speed_rpm <= highest


def _held(check: str, record: CurrentRecord, windows: list[SteadyWindow]) -> Margin | None:
    if record.circumstance is not Circumstance.NOMINAL:
        return None
    loaded = [window for window in windows if window.requires_rated_power]
    if not loaded:
        return None
    worst = max(loaded, key=_speed_error)
    error = _speed_error(worst)
    measured = f"{speed_in_words(worst)}{described(worst)}"
    return Margin(check, at_most(error, speed_tolerance(worst)), measured)


def _speed_error(window: SteadyWindow) -> float:
    return window.values.speed_error


CPW_1 = Check(
    id="CPW-1",
    families=("constant power",),
    requirement="Constant power: {power} is held within k1 at every speed from {lowest} to {highest}.",
    source="P5, P10",
    level="required",
    limit="k1 = {k1}",
    scenarios="every steady stretch of {stretch} or more that requires {power}, on the nominal drive",
    formula="1 - |speed error| / k1",
    why="Constant power over the whole high-speed range is what the advance angle is for.",
    evaluate=holds_constant_power,
    reason_not_applicable=unless_speeds(constant_power),
)
CPW_2 = Check(
    id="CPW-2",
    families=("overspeed",),
    requirement="Constant power beyond {highest}: {power} is held within k1 at speeds up to {overspeed}.",
    source="P10",
    level="advisory",
    limit="k1 = {k1}",
    scenarios="every steady stretch of {stretch} or more that requires {power} above {highest}, on the nominal drive",
    formula="1 - |speed error| / k1",
    why="The paper puts the limit of its drive beyond three times base speed, without a number.",
    evaluate=holds_constant_power_beyond,
    reason_not_applicable=unless_speeds(beyond_constant_power),
)
