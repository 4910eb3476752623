"""The modes of a phase between two events: its current slides along i*, it floats, or it conducts.

Each function solves for the first event that ends the stretch, adds the stretch's exact integrals, stores its
segment if there is space, and returns the state at the start of the next stretch.
"""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.half_bridge.plant.leg import connection, time_to_pass
from drivegate_models.half_bridge.plant.stretch import Demand, Motion, Stretch, Sums, Winding, with_peak
from drivegate_models.machine.segments import store_segment
from drivegate_models.machine.winding_current import (
    crossing_time,
    current_after,
    current_integrals,
    turning_time,
)


@inlined
def _kept(
    rows: NDArray[np.float64],
    stretch: Stretch,
    index: int,
    length: float,
    current: float,
    slope: float,
    curvature: float,
    voltage: float,
    voltage_rate: float,
    rate: float,
) -> int:
    """Store the segment of a stretch, and return the next index."""
    shape, shape_rate = stretch.shape, stretch.shape_rate
    return store_segment(
        rows,
        stretch.phase,
        index,
        stretch.time,
        length,
        current,
        slope,
        curvature,
        shape,
        shape_rate,
        voltage,
        voltage_rate,
        rate,
    )


@inlined
def slide(
    winding: Winding,
    demand: Demand,
    stretch: Stretch,
    upper: float,
    lower: float,
    sums: Sums,
    motion: Motion,
    rows: NDArray[np.float64],
) -> tuple[float, bool, Sums, Motion]:
    """Maintain the current at i* by the ideal regulator, until a rail's voltage is no longer sufficient.

    `upper`, `lower`: voltages of the half-sources (V). `rows`, shape (m, n, segments.FIELDS): receives the segment.
    Returns `length`: length of the stretch (s); `is_whole`: true if it has the maximum length, because no event of the
    phase ended it; `sums`: integrals with the stretch; `motion`: state of the phase after the stretch.
    """
    sector = demand.sector
    reference = demand.reference
    front_source = upper if sector > 0 else lower
    back_source = lower if sector > 0 else upper
    front = front_source - winding.switch_drop
    back = back_source + winding.diode_drop
    needed = sector * stretch.emf + winding.resistance * reference
    needed_rate = sector * stretch.emf_rate
    length = stretch.length
    depart = motion.depart
    kept = motion.kept
    wait = time_to_pass(needed, needed_rate, -back, front)
    is_whole = not wait < length
    if not is_whole:
        # By rounding the voltage may already be beyond the rail.
        length = max(wait, 0.0)
        # If the required voltage rises, the front rail is no longer sufficient; if it falls, the back rail is not.
        depart = -1 if needed_rate > 0.0 else 1
    if length > 0.0:
        # The switch's duty ratio, the limit of a vanishing band.
        share = (needed + 0.5 * needed_rate * length + back) / (front + back)
        # The share is linear in time, and all integrals are linear in the share: its mean makes them exact.
        charge = reference * length
        drawn = share * front_source * charge
        returned = (1.0 - share) * back_source * charge
        drop = winding.resistance * reference
        shape_mean = stretch.shape + 0.5 * stretch.shape_rate * length
        sums = Sums(
            sums.magnitude + charge,
            sums.square + reference * charge,
            sums.shape_current + sector * shape_mean * charge,
            sums.upper + (drawn if sector > 0 else -returned),
            sums.lower + (-returned if sector > 0 else drawn),
            sums.exchanged + (drawn + returned),
            sums.returned + returned,
            sums.device + (share * winding.switch_drop + (1.0 - share) * winding.diode_drop) * charge,
            # The gap voltage switches between the rails, however small the band.
            sums.core + (share * (front - drop) ** 2 + (1.0 - share) * (back + drop) ** 2) * length,
            sums.drag,
            sums.peak,
        )
        kept = _kept(
            rows, stretch, kept, length, motion.current, 0.0, 0.0, sector * needed, stretch.emf_rate, 0.0
        )
    return length, is_whole, sums, Motion(motion.current, motion.latch, depart, 0, kept)


@inlined
def float_free(
    winding: Winding,
    demand: Demand,
    stretch: Stretch,
    upper: float,
    lower: float,
    sums: Sums,
    motion: Motion,
    rows: NDArray[np.float64],
) -> tuple[float, bool, Sums, Motion]:
    """Carry no current until the back-EMF passes a rail, or leaves the dead zone of a closed switch.

    Arguments and results are those of `slide`.
    """
    # With a switch on, only the dead zone between its drop and its diode's drop remains.
    high = upper + winding.diode_drop if demand.gate >= 0 else -(lower - winding.switch_drop)
    low = -(lower + winding.diode_drop) if demand.gate <= 0 else upper - winding.switch_drop
    length = stretch.length
    conducting = 0
    kept = motion.kept
    wait = time_to_pass(stretch.emf, stretch.emf_rate, low, high)
    is_whole = not wait < length
    if not is_whole:
        length = max(wait, 0.0)
        conducting = -1 if stretch.emf_rate > 0.0 else 1
    if length > 0.0:
        shape = stretch.shape
        shape_rate = stretch.shape_rate
        squares = length * (shape * shape + shape_rate * length * (shape + shape_rate * length / 3.0))
        sums = Sums(
            sums.magnitude,
            sums.square,
            sums.shape_current,
            sums.upper,
            sums.lower,
            sums.exchanged,
            sums.returned,
            sums.device,
            sums.core,
            sums.drag + squares,
            sums.peak,
        )
        kept = _kept(rows, stretch, kept, length, 0.0, 0.0, 0.0, stretch.emf, stretch.emf_rate, 0.0)
    return length, is_whole, sums, Motion(motion.current, motion.latch, motion.depart, conducting, kept)


@inlined
def _start_slope(
    winding: Winding, demand: Demand, stretch: Stretch, motion: Motion, voltage: float, side: int
) -> float:
    """Return the slope of the current at the start of a stretch, without rounding errors in its sign (A/s)."""
    slope = (voltage - stretch.emf - winding.resistance * motion.current) * winding.inverse_inductance
    if motion.conducting != 0 or (motion.current == 0.0 and side * slope < 0.0):
        # The current has just begun to flow.
        return 0.0
    if motion.depart * demand.sector * slope < 0.0:
        # The current has just left a slide.
        return 0.0
    return slope


@inlined
def _comparator_level(demand: Demand, side: int) -> tuple[float, bool]:
    """Return the current at which the comparator switches (A), and True if the current can reach it."""
    if demand.gate != 0:
        return demand.gate * (demand.reference + demand.band), side == demand.gate
    level = demand.sector * max(demand.reference - demand.band, 0.0)
    chops = demand.sector != 0 and demand.reference > 0.0 and side == demand.sector
    # The event of zero current covers a level of zero.
    return level, chops and level != 0.0


@inlined
def _conducted(
    winding: Winding,
    stretch: Stretch,
    sums: Sums,
    start: float,
    slope: float,
    curvature: float,
    length: float,
    rail: int,
    side: int,
    source: float,
    voltage: float,
) -> tuple[float, Sums]:
    """Return the current at the end of a stretch without events (A), and the integrals with the stretch."""
    resistance = winding.resistance
    returning = rail * side < 0
    end, end_slope, first, second, square = current_integrals(start, slope, curvature, winding.rate, length)
    peak = sums.peak
    if slope * end_slope < 0.0:
        turn = turning_time(slope, curvature, winding.rate)
        extreme, _ = current_after(start, slope, curvature, winding.rate, turn)
        peak = max(peak, abs(extreme))
    magnitude = side * first
    energy = rail * source * first
    shape_end = stretch.shape + stretch.shape_rate * length
    core = sums.core + voltage * (voltage * length - 2.0 * resistance * first)
    return end, Sums(
        sums.magnitude + magnitude,
        sums.square + square,
        sums.shape_current + (shape_end * first - stretch.shape_rate * second),
        sums.upper + energy if rail > 0 else sums.upper,
        sums.lower if rail > 0 else sums.lower + energy,
        sums.exchanged + source * magnitude,
        sums.returned + source * magnitude if returning else sums.returned,
        sums.device + (winding.diode_drop if returning else winding.switch_drop) * magnitude,
        core + resistance * resistance * square,
        sums.drag,
        peak,
    )


@inlined
def conduct(
    winding: Winding,
    demand: Demand,
    stretch: Stretch,
    rail: int,
    side: int,
    source: float,
    sums: Sums,
    motion: Motion,
    rows: NDArray[np.float64],
) -> tuple[float, bool, Sums, Motion]:
    """Conduct the current between winding and a rail until it reaches the comparator's level, or zero.

    `rail` and `side` are the phase's rail and the sign of its current (1 or -1), `source` the voltage of that rail's
    half-source (V). The other arguments and the results are those of `slide`.
    """
    rate = winding.rate
    current = motion.current
    latch = motion.latch
    kept = motion.kept
    # For longer times the series are not exact; the rest is a separate stretch.
    length = min(stretch.length, winding.longest)
    is_whole = stretch.length <= winding.longest
    returning = rail * side < 0
    voltage = rail * (source + winding.diode_drop if returning else source - winding.switch_drop)
    slope = _start_slope(winding, demand, stretch, motion, voltage, side)
    curvature = stretch.emf_rate * winding.inverse_inductance
    end, end_slope = current_after(current, slope, curvature, rate, length)

    zero_time = crossing_time(current, slope, curvature, rate, length, end, end_slope, 0.0, side < 0)
    level, reachable = _comparator_level(demand, side)
    level_time = inf
    if reachable:
        # With a switch on the current rises to its level, with a freewheeling diode it falls.
        rising = demand.gate > 0 if demand.gate != 0 else demand.sector < 0
        level_time = crossing_time(current, slope, curvature, rate, length, end, end_slope, level, rising)
    at_level = level_time <= zero_time and level_time <= length
    at_zero = not at_level and zero_time <= length
    if at_level or at_zero:
        length = level_time if at_level else zero_time
        is_whole = False
    if length > 0.0:
        end, sums = _conducted(
            winding, stretch, sums, current, slope, curvature, length, rail, side, source, voltage
        )
        kept = _kept(rows, stretch, kept, length, current, slope, curvature, voltage, 0.0, rate)
        current = end
    # Set the current to the exact level of the event, without rounding errors.
    if at_level:
        current = level
        latch = 0 if demand.gate != 0 else 1
    elif at_zero:
        current = 0.0
        if demand.gate == 0 and side == demand.sector and 0.0 < demand.reference <= demand.band:
            # The comparator's lower edge is at zero.
            latch = 1
    peak = max(sums.peak, abs(current))
    return length, is_whole, with_peak(sums, peak), Motion(current, latch, 0, 0, kept)


@inlined
def not_sliding(
    winding: Winding,
    demand: Demand,
    stretch: Stretch,
    upper: float,
    lower: float,
    sums: Sums,
    motion: Motion,
    rows: NDArray[np.float64],
) -> tuple[float, bool, Sums, Motion]:
    """Float or conduct, as determined by gates, diodes and the back-EMF.

    Arguments and results are those of `slide`.
    """
    rail, side = connection(
        demand.gate,
        motion.current,
        motion.conducting,
        stretch.emf,
        stretch.emf_rate,
        upper,
        lower,
        winding.switch_drop,
        winding.diode_drop,
    )
    if rail == 0:
        return float_free(winding, demand, stretch, upper, lower, sums, motion, rows)
    source = upper if rail > 0 else lower
    return conduct(winding, demand, stretch, rail, side, source, sums, motion, rows)
