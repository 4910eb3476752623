"""What a phase does from one event to the next: its current slides along i*, it floats, or it conducts.

Each function solves for the first event that ends the stretch, adds the stretch's exact integrals, keeps its
segment where there is room, and says how the next stretch begins.
"""

from __future__ import annotations

from math import inf

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.half_bridge.plant.leg import connection, time_to_pass
from drivegate_models.half_bridge.plant.stretch import Demand, Motion, Stretch, Sums, Winding, with_peak
from drivegate_models.machine.segments import keep_segment
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
    """Keep the segment of a stretch, and return the next index."""
    shape, shape_rate = stretch.shape, stretch.shape_rate
    return keep_segment(
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
    """Hold the current at i*, as the ideal regulator does, until a rail no longer can.

    Parameters
    ----------
    winding : Winding
        Constants.
    demand : Demand
        What the regulator is to do.
    stretch : Stretch
        Where it begins.
    upper, lower : float
        Voltages of the half-sources (V).
    sums : Sums
        Integrals so far.
    motion : Motion
        Where the phase stands.
    rows : ndarray, shape (m, n, segments.FIELDS)
        Receives the segment.

    Returns
    -------
    length : float
        Length of the stretch (s).
    is_whole : bool
        Whether no event of its own ended it.
    sums : Sums
        With the stretch.
    motion : Motion
        At its end.
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
        # By rounding the voltage may lie beyond the rail already.
        length = max(wait, 0.0)
        # The rail in front no longer suffices where the need rises, the one behind where it falls.
        depart = -1 if needed_rate > 0.0 else 1
    if length > 0.0:
        # The switch's share of time, the limit of a band that shrinks to nothing.
        share = (needed + 0.5 * needed_rate * length + back) / (front + back)
        # The share is linear in time, and all integrals are linear in the share: its mean makes them exact.
        charge = reference * length
        taken = share * front_source * charge
        given = (1.0 - share) * back_source * charge
        drop = winding.resistance * reference
        shape_mean = stretch.shape + 0.5 * stretch.shape_rate * length
        sums = Sums(
            sums.magnitude + charge,
            sums.square + reference * charge,
            sums.shape_current + sector * shape_mean * charge,
            sums.upper + (taken if sector > 0 else -given),
            sums.lower + (-given if sector > 0 else taken),
            sums.exchanged + (taken + given),
            sums.returned + given,
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

    Parameters
    ----------
    winding, demand, stretch, upper, lower, sums, motion, rows
        As in `slide`.

    Returns
    -------
    length, is_whole, sums, motion
        As in `slide`.
    """
    # A switch that is on leaves only the dead zone between its own drop and its diode's.
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
    """Return the slope of the current at the start of a stretch, without what is left of it by rounding (A/s)."""
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
    """Return the current at which the comparator switches (A), and whether the current can come to it."""
    if demand.gate != 0:
        return demand.gate * (demand.reference + demand.band), side == demand.gate
    level = demand.sector * max(demand.reference - demand.band, 0.0)
    chops = demand.sector != 0 and demand.reference > 0.0 and side == demand.sector
    # A level of zero is met by the event of zero current.
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
    """Return the current at the end of a stretch without events, and the integrals with it."""
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
    """Let the current flow between winding and a rail until it reaches the comparator's level, or zero.

    Parameters
    ----------
    winding, demand, stretch, sums, motion, rows
        As in `slide`.
    rail, side : int
        Rail that the phase is connected to, and sign of its current: 1 or -1.
    source : float
        Voltage of that rail's half-source (V).

    Returns
    -------
    length, is_whole, sums, motion
        As in `slide`.
    """
    rate = winding.rate
    current = motion.current
    latch = motion.latch
    kept = motion.kept
    # Beyond, the series are not exact; the rest follows as a stretch of its own.
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
        # A switch that is on lets the current rise to its level, a freewheeling diode lets it fall.
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
    # An event ends exactly where it is, whatever rounding has left of it.
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
    """Float or conduct, as gates, diodes and the back-EMF have it.

    Parameters
    ----------
    winding, demand, stretch, upper, lower, sums, motion, rows
        As in `slide`.

    Returns
    -------
    length, is_whole, sums, motion
        As in `slide`.
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
