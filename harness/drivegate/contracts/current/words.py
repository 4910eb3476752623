"""What happened in a run, in plain words with times and numbers, read off its recorded signals."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.contracts.current.columns import CurrentColumns
from drivegate.scenarios.title import titled
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.scenario.profile import Dwell, dwell_torque, dwells
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError
from drivegate_models.machine.friction import friction_torque
from drivegate_models.steady import oracle
from drivegate_models.units import RADIANS_PER_RPM

if TYPE_CHECKING:
    from drivegate.contracts.contract import RecordedTrace

LASTING_S: Final = 0.2
"""Time from which on something is reported (s)."""
_SHORTFALL: Final = 0.98
_MOVED_DEG: Final = 0.02
_AT_EDGE_DEG: Final = 0.2
_STANDING: Final = 0.02


@dataclass(frozen=True)
class RunSignals:
    """A run's signals, and the stretch that a check was judged on."""

    scenario: Scenario
    time_s: NDArray[np.float64]
    """Middle of each point's stretch (s), shape (n,)."""
    speed_reference_rpm: NDArray[np.float64]
    speed_rpm: NDArray[np.float64]
    """Speed reference, and true speed (rpm), shape (n,)."""
    current_sum_a: NDArray[np.float64]
    current_reference_a: NDArray[np.float64]
    """Σ|i| and the current reference (A), shape (n,)."""
    advance_deg: NDArray[np.float64]
    """Advance angle (electrical deg), shape (n,)."""
    torque_nm: NDArray[np.float64]
    load_torque_nm: NDArray[np.float64]
    """Electromagnetic torque and the load's (N·m), shape (n,)."""
    judged_s: tuple[float, float]
    """Start and end of the stretch (s)."""

    @property
    def speed_error_rpm(self) -> NDArray[np.float64]:
        """True speed less the reference, shape (n,) (rpm)."""
        return self.speed_rpm - self.speed_reference_rpm

    @property
    def judged(self) -> NDArray[np.bool_]:
        """Which points lie in the judged stretch, shape (n,)."""
        return (self.time_s >= self.judged_s[0]) & (self.time_s <= self.judged_s[1])


def run_signals(trace: RecordedTrace) -> RunSignals:
    # A result may have further columns, of what the controller sensed.
    columns = {name: trace.columns[name] for name in CurrentColumns.recorded_names}
    return RunSignals(scenario=trace.scenario, judged_s=trace.judged_s, **columns)


@dataclass(frozen=True)
class JudgedPoint:
    """An operating point of a run, and the oracle's answers there."""

    begins_s: float
    """When its conditions begin (s)."""
    speed_rpm: float
    torque_nm: float
    """Speed reference, and torque of the load and of friction (N·m)."""
    edge_deg: float
    """Smallest angle that gives the torque (electrical deg)."""
    best_deg: float
    least_current_sum_a: float
    """Angle of least Σ|i|, and that (A)."""


def judged_point(signals: RunSignals) -> JudgedPoint | None:
    """Evaluate the oracle at the conditions at the end of the judged stretch."""
    end = signals.judged_s[1]
    held = [dwell for dwell in dwells(signals.scenario) if dwell.start < end]
    if not held or held[-1].end + 1e-9 < end:
        return None
    return _answers(signals.scenario, _from_its_begin(signals.scenario, held))


def _from_its_begin(scenario: Scenario, held: Sequence[Dwell]) -> Dwell:
    """Return the last stretch, from where its conditions began: a sensor that fails meanwhile changes none of them."""
    failures = {(lost.start_s, lost.end_s) for lost in scenario.dropouts}
    whole = held[-1]
    for earlier in reversed(held[:-1]):
        resumed = replace(earlier, start=whole.start, end=whole.end) == whole
        joined = earlier.end == whole.start or (earlier.end, whole.start) in failures
        if not (resumed and joined):
            break
        whole = replace(whole, start=earlier.start)
    return whole


@lru_cache(maxsize=200)
def _answers(scenario: Scenario, dwell: Dwell) -> JudgedPoint | None:
    drive = scenario.drive.plant(dwell.scales)
    speed = dwell.speed_rpm * RADIANS_PER_RPM
    load = dwell_torque(scenario, dwell)
    voltage = dwell.supply_v * (1.0 - abs(dwell.imbalance))
    torque = load + friction_torque(drive, speed)
    if load <= 0.0 or speed <= 0.0:
        return None
    try:
        edge = oracle.feasible_edge(drive, speed, torque, voltage)
        least = oracle.least_current_sum(drive, speed, torque, voltage)
    except InputError:
        return None
    if not (math.isfinite(edge) and math.isfinite(least.advance)):
        return None
    angles = np.degrees([edge, least.advance])
    return JudgedPoint(
        dwell.start, dwell.speed_rpm, torque, float(angles[0]), float(angles[1]), least.current_sum
    )


def account(signals: RunSignals) -> tuple[str, ...]:
    point = judged_point(signals)
    words = titled(signals.scenario).description.rstrip(".")
    sentences = [f"Run: {words}; {signals.scenario.duration_s:g} s."]
    if lost_at(signals) is None:
        sentences += _held(signals)
    else:
        sentences += [*_lost(signals, point), *_not_to_blame(signals)]
    return (*sentences, *_optimum(point))


def lost_at(signals: RunSignals) -> float | None:
    """Find when the speed left its band for long; None where it was held (s)."""
    begin = _loaded_from(signals, judged_point(signals))
    return _lasting(signals, np.abs(signals.speed_error_rpm) > _band_rpm(signals), begin)


def _band_rpm(signals: RunSignals) -> float:
    """k1: the speed error that the checks of convergence allow (rpm)."""
    return limits_of(signals.scenario.drive).speed_tolerance_rpm


def _loaded_from(signals: RunSignals, point: JudgedPoint | None) -> float:
    """Time from which on the judged load is there (s)."""
    return signals.time_s[0] if point is None else point.begins_s


def _lost(signals: RunSignals, point: JudgedPoint | None) -> list[str]:
    """Report how the speed was lost, as events in the order of time."""
    begin = _loaded_from(signals, point)
    # At the same time, the cause comes first.
    events = [] if point is None else _edge_passed(signals, point)
    falls_short = signals.torque_nm < _SHORTFALL * signals.load_torque_nm
    if (when := _lasting(signals, falls_short, begin)) is not None:
        events.append((when, f"at {when:.2f} s torque fell below the load"))
    limit = signals.scenario.drive.rating.current_limit_a
    if (when := _lasting(signals, signals.current_reference_a > 0.999 * limit, begin)) is not None:
        events.append((when, f"at {when:.2f} s the current reference reached its limit of {limit:g} A"))
    if (when := _lasting(signals, np.abs(signals.speed_error_rpm) > _band_rpm(signals), begin)) is not None:
        later = float(np.interp(when + LASTING_S, signals.time_s, signals.speed_error_rpm))
        way = "below" if later < 0.0 else "above"
        events.append(
            (
                when,
                f"at {when:.2f} s the speed left its band of ±{_band_rpm(signals):g} rpm, {way} the reference",
            )
        )
    events += _rest(signals)
    texts = [text for _, text in sorted(events, key=lambda event: event[0])]
    return [*(f"{text[0].upper()}{text[1:]}." for text in texts), _end(signals)]


def _not_to_blame(signals: RunSignals) -> list[str]:
    """State that the speed was lost before anything disturbed the sensors, if so."""
    disturbed = [lost.start_s for lost in signals.scenario.dropouts]
    disturbed += [glitch.time_s for glitch in signals.scenario.glitches]
    when = lost_at(signals)
    if not disturbed or when is None or min(disturbed) <= when:
        return []
    first = f"{min(disturbed):g} s"
    return [
        f"The speed was lost before the first disturbance of the sensors, at {first}, which is not the cause."
    ]


def _edge_passed(signals: RunSignals, point: JudgedPoint) -> list[tuple[float, str]]:
    after = signals.time_s >= point.begins_s
    below = after & (signals.advance_deg < point.edge_deg - 0.05)
    if not below.any():
        return []
    first = int(np.flatnonzero(below)[0])
    meaning = f"the smallest at which the motor can give the {point.torque_nm:.3g} N·m demanded"
    at = signals.time_s[first]
    if first == int(np.flatnonzero(after)[0]):
        angle = signals.advance_deg[first]
        return [
            (
                at,
                f"when the load was there, at {at:.2f} s, the angle was {angle:.1f}°, below {point.edge_deg:.1f}°, "
                f"{meaning}",
            )
        ]
    return [(at, f"at {at:.2f} s the angle passed {point.edge_deg:.1f}°, {meaning}")]


def _rest(signals: RunSignals) -> list[tuple[float, str]]:
    """Report from when on the angle did not move any more, if it rested for a second at least."""
    moves = np.flatnonzero(np.abs(np.diff(signals.advance_deg)) > _MOVED_DEG)
    last = int(moves[-1]) + 1 if moves.size else 0
    at = signals.time_s[last]
    if signals.time_s[-1] - at < 1.0:
        return []
    angle = signals.advance_deg[-1]
    return [(at, f"from {at:.2f} s on the angle rested at {angle:.1f}°: the search was frozen or had ended")]


def _end(signals: RunSignals) -> str:
    error = signals.speed_error_rpm[-1]
    if abs(error) <= _band_rpm(signals):
        where = "within the band again"
    else:
        where = f"{abs(error):.0f} rpm {'below' if error < 0.0 else 'above'} the reference"
    return (
        f"At the end the speed was {signals.speed_rpm[-1]:.0f} rpm, {where}, with a current reference of "
        f"{signals.current_reference_a[-1]:.1f} A, an angle of {signals.advance_deg[-1]:.1f}° and a torque of "
        f"{signals.torque_nm[-1]:.2f} N·m."
    )


def _held(signals: RunSignals) -> list[str]:
    judged = signals.judged
    if not judged.any():
        return [_end(signals)]
    start, end = signals.judged_s
    error = float(np.max(np.abs(signals.speed_error_rpm[judged])))
    angles, sums = signals.advance_deg[judged], signals.current_sum_a[judged]
    moved = f"the angle rested at {angles.mean():.1f}°"
    if np.ptp(angles) > _MOVED_DEG:
        moved = f"the angle lay between {angles.min():.1f}° and {angles.max():.1f}°"
    return [
        f"From {start:.2f} s to {end:.2f} s, where the check was judged, the speed was within {error:.2g} rpm of its "
        f"reference, {moved}, and Σ|i| lay between {sums.min():.2f} A and {sums.max():.2f} A."
    ]


def _optimum(point: JudgedPoint | None) -> list[str]:
    if point is None:
        return []
    at_edge = point.best_deg - point.edge_deg < _AT_EDGE_DEG
    edge = ", which is the feasible edge" if at_edge else f"; the feasible edge is {point.edge_deg:.1f}°"
    return [
        f"At {point.speed_rpm:.0f} rpm and {point.torque_nm:.3g} N·m the least Σ|i| is "
        f"{point.least_current_sum_a:.2f} A, at {point.best_deg:.1f}°{edge}."
    ]


def _lasting(signals: RunSignals, holds: NDArray[np.bool_], begin: float) -> float | None:
    """Find when something began that lasted; the start of the longest stretch of it from a time on (s)."""
    padded = np.concatenate([[False], holds & (signals.time_s >= begin), [False]])
    edges = np.flatnonzero(np.diff(padded.astype(np.int8)))
    starts, ends = edges[::2], edges[1::2] - 1
    if starts.size == 0:
        return None
    lengths = signals.time_s[ends] - signals.time_s[starts]
    longest = int(np.argmax(lengths))
    return float(signals.time_s[starts[longest]]) if lengths[longest] >= LASTING_S else None


def loss_of_speed(signals: RunSignals) -> str | None:
    """Return how the speed was lost; None where it was maintained."""
    if lost_at(signals) is None:
        return None
    if abs(signals.speed_rpm[-1]) < _STANDING * float(np.max(np.abs(signals.speed_reference_rpm))):
        return "the motor stalls"
    point = judged_point(signals)
    if point is not None and _edge_passed(signals, point):
        return "the search takes the angle past the feasible edge, and the speed is lost"
    limit = signals.scenario.drive.rating.current_limit_a
    if signals.speed_error_rpm[-1] < 0.0 and signals.current_reference_a[-1] > 0.999 * limit:
        return f"the speed is lost with the current reference at its limit of {limit:g} A"
    return "the speed leaves its band and stays away"
