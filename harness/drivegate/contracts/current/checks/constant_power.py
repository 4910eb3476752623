"""Checks of the constant-power range: that rated power is held there, and beyond."""

from __future__ import annotations

from drivegate.checks.check import Check, StateMoment
from drivegate.checks.margin import Margin, Moment, at_most
from drivegate.contracts.current.checks.convergence import described, speed_in_words, speed_tolerance
from drivegate.contracts.current.checks.declared_speeds import (
    JudgedSpeeds,
    beyond_constant_power,
    constant_power,
    unless_speeds,
)
from drivegate.contracts.current.checks.shown import speed_moment
from drivegate.contracts.current.record import CurrentRecord, SteadyWindow


def holds_constant_power(record: CurrentRecord) -> Margin | None:
    """Judge whether rated power is held within k1 (paper, "Constant Power Operation", Fig. 3)."""
    return _held("CPW-1", record, constant_power)


def holds_constant_power_beyond(record: CurrentRecord) -> Margin | None:
    """Judge whether rated power is held within k1 beyond the range of constant power (paper, Fig. 10)."""
    return _held("CPW-2", record, beyond_constant_power)


def is_in(judged: JudgedSpeeds, window: SteadyWindow) -> bool:
    """Return True if a window is at one of the speeds that a check judges."""
    lowest, highest = judged(window.scenario.drive)
    return lowest <= window.dwell.speed_rpm <= highest


def _worst(record: CurrentRecord, judged: JudgedSpeeds) -> SteadyWindow | None:
    windows = [w for w in record.nominal_windows() if is_in(judged, w) and w.requires_rated_power]
    return max(windows, key=lambda window: window.values.speed_error, default=None)


def _shown(judged: JudgedSpeeds) -> StateMoment:
    """Show the speed in the window that holds it least, of those that a check judges."""

    def moment(record: CurrentRecord) -> Moment | None:
        window = _worst(record, judged)
        return None if window is None else speed_moment(record, window)

    return moment


def _held(check: str, record: CurrentRecord, judged: JudgedSpeeds) -> Margin | None:
    worst = _worst(record, judged)
    if worst is None:
        return None
    margin = at_most(worst.values.speed_error, speed_tolerance(worst))
    return Margin(check, margin, f"{speed_in_words(worst)}{described(worst)}")


CPW_1 = Check(
    id="CPW-1",
    families=("constant power",),
    requirement="Constant power: {power} is held within k1 at every speed from {lowest} to {highest}.",
    source="P5, P10",
    limit="k1 = {k1}",
    scenarios="every steady stretch of {stretch} or more that requires {power}, on the nominal drive",
    formula="1 - |speed error| / k1",
    why="Constant power over the whole high-speed range is what the advance angle is for.",
    evaluate=holds_constant_power,
    moment=_shown(constant_power),
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
    moment=_shown(beyond_constant_power),
    reason_not_applicable=unless_speeds(beyond_constant_power),
)
