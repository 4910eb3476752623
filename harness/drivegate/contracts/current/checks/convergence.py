"""Checks of the search on the nominal drive: that it converges, also after changes, and where to."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Final

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Moment, at_most, worst_required
from drivegate.contracts.current.checks.commanded import commanded_spread
from drivegate.contracts.current.checks.declared_speeds import above_base, unless_speeds
from drivegate.contracts.current.checks.shown import angle_moment, decisive, speed_moment, spread_moment
from drivegate.contracts.current.numbers import given_below_limit
from drivegate.contracts.current.record import CurrentRecord, SteadyWindow, rated_torque
from drivegate_cases.documents.wording import figure
from drivegate_cases.drive.limits import limits_of, mean_time
from drivegate_cases.scenario.load import LockedLoad
from drivegate_cases.scenario.sensors import IdealSensors, counted_s
from drivegate_models.machine.friction import friction_torque
from drivegate_models.steady.oracle import feasible_edge, least_current_sum, point_at_torque
from drivegate_models.units import RADIANS_PER_RPM

_STALLED_SHARE: Final = 0.999
"""From this share of the reference on, a speed error is that of a shaft that stands (1)."""

LIGHTEST_SHARE = 0.2
"""Share of the rated power's torque below which k2 is a share of no less current (1)."""
REQUIRED_SHARE = 0.5
"""Share of the rated power's torque, as a load on the shaft, from which the optimum is required (1)."""
_SAME: Final = 1e-6

ABOVE_BASE_SPEED = unless_speeds(above_base)
"""Reason why a check of the search does not apply to a candidate for speeds up to base speed."""


def described(window: SteadyWindow) -> str:
    """State where a window was observed; the torque of a shaft that stands means nothing."""
    if is_stalled(window):
        return f" where {figure(window.dwell.speed_rpm)} rpm are demanded"
    torque = window.values.torque
    return f" at {figure(window.dwell.speed_rpm)} rpm, {torque:.3g} N·m"


def speed_tolerance(window: SteadyWindow) -> float:
    """Return k1 (rad/s)."""
    return limits_of(window.scenario.drive).speed_tolerance_rpm * RADIANS_PER_RPM


def is_stalled(window: SteadyWindow) -> bool:
    return window.speed > 0.0 and window.values.speed_error >= _STALLED_SHARE * window.speed


def speed_in_words(window: SteadyWindow) -> str:
    """State how far the speed was off, or that the shaft stood."""
    return (
        "stalled"
        if is_stalled(window)
        else f"speed error {figure(window.values.speed_error / RADIANS_PER_RPM)} rpm"
    )


def unseen_share(window: SteadyWindow) -> float:
    """Return the share of the torque, and so of the current sum, that sensors cannot distinguish from a steady speed.

    A speed that moves by one step of its measurement up or down takes the torque J·2Δω in the time of one mean.
    The step is the clock's over the time in which edges are counted.
    """
    sensors = window.scenario.sensors
    torque = window.values.torque
    if isinstance(sensors, IdealSensors) or torque <= 0.0:
        return 0.0
    electrical_speed = window.scenario.drive.machine.pole_pairs * window.speed
    step = window.speed * sensors.clock_s / counted_s(sensors, electrical_speed)
    inertia = window.scenario.nameplate().inertia
    return 2.0 * inertia * step / mean_time(window.scenario.drive) / torque


def judged_current_sum(window: SteadyWindow) -> float:
    """Return the current sum that k2 is a share of: the mean one, or the least at a fifth of the rated power's torque.

    Band, regulator and converters have a resolution in amperes, whatever the load.
    """
    mean = window.values.current_sum
    lightest = LIGHTEST_SHARE * rated_torque(window.scenario, window.speed)
    if window.values.torque >= lightest:
        return mean
    drive = window.scenario.drive.plant(window.scales)
    least = least_current_sum(drive, window.speed, lightest, window.dwell.supply_v).current_sum
    return max(mean, least) if math.isfinite(least) else mean


_SHOWN: Final = (speed_moment, angle_moment, spread_moment)
"""What shows each of the quantities of `window_convergence`, in their order."""


def window_convergence(window: SteadyWindow) -> tuple[float, str]:
    """Judge whether the search has converged in a window (paper, Fig. 4)."""
    return min(_quantities(window))


def convergence_moment(record: CurrentRecord, window: SteadyWindow) -> Moment:
    """Show the quantity of a window that has converged least."""
    judged = _quantities(window)
    return _SHOWN[judged.index(min(judged))](record, window)


def _quantities(window: SteadyWindow) -> list[tuple[float, str]]:
    """Judge speed, angle and, with a current, the means of the current sum of a window."""
    values, limits = window.values, limits_of(window.scenario.drive)
    mean = values.current_sum
    moved = values.angle_highest - values.angle_lowest
    error = values.speed_error
    judged = [
        (at_most(error, speed_tolerance(window)), speed_in_words(window)),
        (
            at_most(moved, math.radians(limits.angle_tolerance_deg)),
            f"angle moves by {math.degrees(moved):.3g}°",
        ),
    ]
    if mean > 0.0:
        lacking = judged_current_sum(window) - mean
        k2 = limits.power_tolerance
        allowed = (k2 + unseen_share(window)) * mean + k2 * lacking
        varied = values.current_sum_range
        spread = commanded_spread(values)
        share = f"Σ|i| varies by {100.0 * varied / mean:.3g} %"
        if spread < varied:
            share += f", at most {100.0 * spread / mean:.3g} % of it by the command"
        judged.append((at_most(spread, allowed), share))
    return judged


def is_feasible(window: SteadyWindow) -> bool:
    """Return True if some advance angle lets the plant give what the load requires."""
    scenario, dwell = window.scenario, window.dwell
    if isinstance(scenario.load, LockedLoad) or window.torque_required <= 0.0:
        return True
    drive = scenario.drive.plant(window.scales)
    torque = window.torque_required + friction_torque(drive, window.speed)
    voltage = dwell.supply_v * (1.0 - abs(dwell.imbalance))
    return not math.isnan(feasible_edge(drive, window.speed, torque, voltage))


def worst_convergence(check: str, windows: Iterable[SteadyWindow]) -> Margin | None:
    return worst_required([margin for _, margin in converging(check, windows)])


def converging(check: str, windows: Iterable[SteadyWindow]) -> Iterator[tuple[SteadyWindow, Margin]]:
    """Judge the loaded windows that some angle lets converge, each with its margin."""
    for window in windows:
        if not window.is_loaded:
            continue
        value, measured = window_convergence(window)
        # Feasibility takes much longer to compute than convergence, and matters only without it.
        if value >= 0.0 or is_feasible(window):
            yield window, Margin(check, value, measured + described(window), is_beyond_range(window))


def moment_of(record: CurrentRecord, windows: Iterable[SteadyWindow]) -> Moment | None:
    """Show the window that has converged least."""
    window = decisive(converging("", windows))
    return None if window is None else convergence_moment(record, window)


def is_beyond_range(window: SteadyWindow) -> bool:
    """Return True if a window lies above the range of constant power, where the paper requires no convergence."""
    return window.dwell.speed_rpm > window.scenario.drive.rating.highest_speed_rpm


def converges(record: CurrentRecord) -> Margin | None:
    """Judge whether the search has converged where nothing had changed before."""
    return worst_convergence("CNV-1", _at_first(record))


def _at_first(record: CurrentRecord) -> Iterator[SteadyWindow]:
    return (window for window in record.nominal_windows() if not window.is_after_change)


def _after_changes(record: CurrentRecord) -> Iterator[SteadyWindow]:
    return (window for window in record.nominal_windows() if window.is_after_change)


def converges_again(record: CurrentRecord) -> Margin | None:
    """Judge whether the search has converged again after a change of load, speed reference or supply."""
    return worst_convergence("CNV-3", _after_changes(record))


def reaches_optimum(record: CurrentRecord) -> Margin | None:
    """Judge the current sum of every converged window against the least one of the same plant (Figs. 5, 7)."""
    loaded = (window for window in record.nominal_windows() if window.torque_required > 0.0)
    return worst_required([_excess(record, window) for window in loaded])


def _excess(record: CurrentRecord, window: SteadyWindow) -> Margin:
    torque = window.values.torque
    mean = window.values.current_sum
    # Where the speed reference is not held, the least sum is that of the speed at which the torque really is.
    mean_speed = window.values.speed
    base_speed = record.scenario.drive.rating.base_speed_rpm * RADIANS_PER_RPM
    speed = mean_speed if mean_speed > base_speed else window.speed
    # Rated power is that of the shaft, so friction makes no load heavier.
    light = window.torque_required < REQUIRED_SHARE * rated_torque(record.scenario, window.speed) * (
        1.0 - _SAME
    )
    advisory = light or is_beyond_range(window)
    least = least_current_sum(record.drive, speed, torque, window.dwell.supply_v).current_sum
    if not math.isfinite(least):
        return Margin("CNV-2", -1.0, _without_optimum(record, window, speed), advisory)
    if least == 0.0:
        return Margin("CNV-2", -1.0, f"Σ|i| {mean:.4g} A gives no torque{described(window)}", advisory)
    lost = _lost_at_limit(record, window, speed) if mean < least else ""
    measured = f"Σ|i| {mean:.4g} A, {_excess_in_words(mean, least, lost)}{described(window)}{lost}"
    allowed = limits_of(record.scenario.drive).optimum_tolerance * least
    return Margin("CNV-2", at_most(mean - least, allowed), measured, advisory)


def _excess_in_words(mean: float, least: float, lost: str) -> str:
    """State how far a current sum is from the least one; by how much it is below only with what is lost for it."""
    excess = 100.0 * (mean / least - 1.0)
    if mean < least and not lost:
        return f"no more than the least {least:.4g} A"
    return f"{abs(excess):.2f} % {'above' if excess >= 0.0 else 'below'} the least {least:.4g} A"


def _without_optimum(record: CurrentRecord, window: SteadyWindow, speed: float) -> str:
    """State why there is no least Σ|i|."""
    mean, limit = window.values.current_sum, record.drive.current_limit
    if is_stalled(window):
        return f"stalled, with Σ|i| {mean:.4g} A{described(window)}"
    words = f"no angle gives the torque with the current at its limit of {limit:g} A"
    return f"Σ|i| {mean:.4g} A{described(window)}, where {words}{_lost_at_limit(record, window, speed)}"


def _lost_at_limit(record: CurrentRecord, window: SteadyWindow, speed: float) -> str:
    """State that the window's angle gives the torque with less current than the limit alone; nothing if it does not."""
    values = window.values
    found = point_at_torque(record.drive, speed, values.angle, values.torque, window.dwell.supply_v)
    if found.robust or not found.static:
        return ""
    return f": at {math.degrees(values.angle):.3g}°, {given_below_limit(found.reference)}"


_CALM = ("steady", "constant power", "required point", "beginning", "overspeed")
_CHANGING = ("load step", "load course", "supply", "restart", "speed step", "standstill")
LOADED = (*_CALM, *_CHANGING)
"""Families of runs under load but those of a vehicle."""

CNV_1 = Check(
    id="CNV-1",
    families=_CALM,
    requirement=(
        "Within {settling} of a steady reference the search has converged: from then on the true speed error stays "
        "within k1, the {mean} means of Σ|i|, or their part that follows the command, within k2 (of no less than Σ|i| "
        "at a fifth of the rated torque), and the advance angle within {angle}; required up to {highest}, the range "
        "of constant power, advisory beyond."
    ),
    source="P6",
    limit="k1 = {k1}, k2 = {k2} of Σ|i|, {angle}",
    scenarios="every first loaded steady stretch of {stretch} or more above base speed, on the nominal drive",
    formula=(
        "least of 1 - |speed error| / k1, 1 - (max - min of the {mean} means of Σ|i|, at most of a line in the command "
        "that fits them) / k2, 1 - (max - min of the angle) / {angle}"
    ),
    why="A search that goes on for ever shakes torque and speed, and one that loses the speed does not drive.",
    evaluate=converges,
    moment=lambda record: moment_of(record, _at_first(record)),
    reason_not_applicable=ABOVE_BASE_SPEED,
)
CNV_2 = Check(
    id="CNV-2",
    families=(*LOADED, "vehicle"),
    requirement=(
        "The search converges to the optimum: Σ|i| lies within {optimum} of the least at that speed and mean torque, "
        "of all angles that give this torque with the current at its limit too (at others a regulator at its limit "
        "may lose it); required under loads from half the torque of rated power upward and up to {highest}, else "
        "advisory."
    ),
    source="P6, P11, P12",
    limit="{optimum} above the least Σ|i|",
    scenarios="every loaded steady stretch of {stretch} or more above base speed, on the nominal drive",
    formula="1 - (Σ|i| - least Σ|i|) / ({optimum} of the least Σ|i|)",
    why="The least Σ|i| is what the search is for; the exhaustive search of the same plant knows it.",
    evaluate=reaches_optimum,
    reason_not_applicable=ABOVE_BASE_SPEED,
)
CNV_3 = Check(
    id="CNV-3",
    families=("required point", *_CHANGING, "vehicle"),
    requirement=(
        "No lock-up: after any load step, speed step or supply dip that leaves the point feasible, the search "
        "converges again as CNV-1 requires."
    ),
    source="P6",
    limit="k1 = {k1}, k2 = {k2} of Σ|i|, {angle}",
    scenarios="every loaded steady stretch of {stretch} or more above base speed after a change, on the nominal drive",
    formula="as CNV-1",
    why="A search that is active only near the reference stops for good once it has lost the speed.",
    evaluate=converges_again,
    moment=lambda record: moment_of(record, _after_changes(record)),
    reason_not_applicable=ABOVE_BASE_SPEED,
)
