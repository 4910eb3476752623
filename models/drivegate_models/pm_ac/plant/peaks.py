"""The maximum phase current of a control period, and the currents that may reach zero in it."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.pm_ac.plant.circuit import Circuit, sagitta
from drivegate_models.pm_ac.plant.interpolation import interpolant_of, interpolated, interpolated_slope
from drivegate_models.pm_ac.plant.jets import Rates
from drivegate_models.pm_ac.plant.phase_segments import (
    PhaseSegment,
    current_at,
    frame_at,
    is_bent_one_way,
    is_monotone,
    is_steep,
    phase_segment,
)
from drivegate_models.pm_ac.plant.polynomial import extremes
from drivegate_models.pm_ac.plant.rows import ACROSS, ALONG, TIME
from drivegate_models.pm_ac.plant.series import Series, free_series, phase_series
from drivegate_models.pm_ac.plant.settling import Legs

# Maximum steps toward a maximum current. Each reduces the error to at most a quarter, and the current contains its
# square.
_STEPS: Final = 14
_REACHED: Final = 1e-8


class Range(NamedTuple):
    """Range of a phase current at the ends of segments (A)."""

    lowest: float
    highest: float


class Ranges(NamedTuple):
    """Ranges of the three phase currents at the ends of segments (A)."""

    first: Range
    second: Range
    third: Range
    deviation: float
    """Maximum distance of a current from the chord of any segment (A)."""


@inlined
def _range_of(rows: NDArray[np.float64], count: int, leg: int) -> Range:
    """Return the range of a phase current at the ends of all segments (A)."""
    lowest = highest = current_at(rows, 0, leg)
    for n in range(1, count + 1):
        current = current_at(rows, n, leg)
        lowest, highest = min(lowest, current), max(highest, current)
    return Range(lowest, highest)


@inlined
def ranges_of(circuit: Circuit, rows: NDArray[np.float64], count: int, longest: float) -> Ranges:
    """Return the ranges of the phase currents at the ends of all segments, of which `longest` is the longest (s)."""
    return Ranges(
        _range_of(rows, count, 0),
        _range_of(rows, count, 1),
        _range_of(rows, count, 2),
        sagitta(circuit, longest),
    )


@inlined
def keeps_sign(legs: Legs, leg: int, range_of_leg: Range, deviation: float) -> bool:
    """Return True if a current has the sign of its leg throughout, from its range at the ends of segments."""
    if legs.sure[leg] != 0:
        return True
    return bool((range_of_leg.lowest if legs.signs[leg] > 0 else -range_of_leg.highest) > deviation)


@inlined
def _turning_value(phase: PhaseSegment) -> float:
    """Return a current at the zero of its monotone slope (A)."""
    begin, end, length = phase.begin, phase.end, phase.length
    share = begin.slope / (begin.slope - end.slope)
    for _ in range(_STEPS):
        slope = interpolated_slope(begin, end, length, share)
        step = slope / (length * (begin.bend + share * (end.bend - begin.bend)))
        share = min(max(share - step, 0.0), 1.0)
        if abs(step) < _REACHED:
            break
    return interpolated(interpolant_of(begin, end, length), share)


@inlined
def _top_of_series(
    circuit: Circuit, series: Series, rows: NDArray[np.float64], n: int, leg: int, length: float
) -> float:
    """Return the maximum magnitude of a phase current in a segment (A), from its series."""
    frame = frame_at(rows, n)
    along, across = rows[ALONG + n], rows[ACROSS + n]
    direct = frame.cosine * along + frame.sine * across
    quadrature = frame.cosine * across - frame.sine * along
    count = free_series(circuit, series, frame, direct, quadrature, length)
    phase_series(circuit, series, frame, leg, count, length)
    lowest, highest = extremes(series.other, count, series.slopes)
    return max(-lowest, highest)


@unallocating
def top_within(
    circuit: Circuit, rates: Rates, series: Series, rows: NDArray[np.float64], n: int, leg: int
) -> float:
    """Return the maximum magnitude of a phase current within a segment, if it exceeds those at its ends.

    `rows`: with currents and rotor at both ends, voltages and times, as in `rows`. `n`: index of the segment, of at
    most `two_points.SHORT` over the circuit's rate. `leg`: index of the phase.
    """
    phase = phase_segment(circuit, rates, rows, n, leg)
    if is_monotone(phase):
        return 0.0
    if not is_bent_one_way(circuit, phase):
        return _top_of_series(circuit, series, rows, n, leg, phase.length)
    if phase.begin.slope * phase.end.slope >= 0.0:
        return 0.0
    return abs(_turning_value(phase))


@inlined
def _top(
    circuit: Circuit,
    rates: Rates,
    series: Series,
    rows: NDArray[np.float64],
    count: int,
    leg: int,
    most: float,
) -> float:
    """Return the maximum magnitude of a phase current, or `most` if that is larger (A)."""
    top = most
    after = current_at(rows, 0, leg)
    for n in range(count):
        before = after
        after = current_at(rows, n + 1, leg)
        deviation = sagitta(circuit, rows[TIME + 1 + n] - rows[TIME + n])
        greatest = max(abs(before), abs(after))
        if greatest + deviation > top and not is_steep(before, after, deviation):
            top = max(top, top_within(circuit, rates, series, rows, n, leg))
    return top


@inlined
def peak_of(
    circuit: Circuit,
    rates: Rates,
    ranges: Ranges,
    series: Series,
    rows: NDArray[np.float64],
    count: int,
) -> float:
    """Return the maximum magnitude of any phase current in a control period (A).

    `rows`: with currents and rotor at the ends of all segments, voltages and times, as in `rows`. `count`: number of
    segments.
    """
    first = max(ranges.first.highest, -ranges.first.lowest)
    second = max(ranges.second.highest, -ranges.second.lowest)
    third = max(ranges.third.highest, -ranges.third.lowest)
    peak = max(first, second, third)
    least = peak - ranges.deviation
    if first > least:
        peak = _top(circuit, rates, series, rows, count, 0, peak)
    if second > least:
        peak = _top(circuit, rates, series, rows, count, 1, peak)
    if third > least:
        peak = _top(circuit, rates, series, rows, count, 2, peak)
    return peak
