"""A phase current in one segment of a control period: its value and derivatives at both ends, and its bounds."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.rotor_frame import RotorFrame, of_phase, turned
from drivegate_models.pm_ac.plant.circuit import Circuit
from drivegate_models.pm_ac.plant.jets import Currents, Jet, Rates, derivatives, in_stationary_frame
from drivegate_models.pm_ac.plant.quiet import curvature
from drivegate_models.pm_ac.plant.rows import (
    ACROSS,
    ALONG,
    COSINE,
    DIRECT,
    PHASE,
    QUADRATURE,
    SINE,
    TIME,
    WIDTH,
)


class PhaseSegment(NamedTuple):
    begin: Jet
    """Current and derivatives at the start (A)."""
    end: Jet
    """Current and derivatives at the end (A)."""
    length: float
    """Length of the segment (s)."""
    change: float
    """Bound of the change of the slope within half of the segment from an end (A/s)."""


@inlined
def frame_at(rows: NDArray[np.float64], n: int) -> RotorFrame:
    """Return the currents and the rotor's angle at an instant."""
    return RotorFrame(rows[DIRECT + n], rows[QUADRATURE + n], rows[COSINE + n], rows[SINE + n])


@inlined
def derivatives_at(rates: Rates, rows: NDArray[np.float64], frame: RotorFrame, n: int) -> Currents:
    """Return the currents and their derivatives at an instant, with the voltages of a segment."""
    along, across = rows[ALONG + n], rows[ACROSS + n]
    return derivatives(
        rates,
        frame.direct,
        frame.quadrature,
        rates.per_direct * (frame.cosine * along + frame.sine * across),
        rates.per_quadrature * (frame.cosine * across - frame.sine * along),
    )


@inlined
def current_at(rows: NDArray[np.float64], n: int, leg: int) -> float:
    """Return the current of a phase at an instant (A)."""
    return float(rows[PHASE + leg * WIDTH + n])


@inlined
def _along_phase(leg: int, frame: RotorFrame, direct: float, quadrature: float) -> float:
    """Return the value of a phase for a d-q quantity."""
    along, across = turned(frame, direct, quadrature)
    return of_phase(leg, along, across)


@inlined
def _of_phase(leg: int, frame: RotorFrame, currents: Currents) -> Jet:
    """Return the current of a phase with its derivatives, from those in the stationary frame."""
    d, q = currents.direct, currents.quadrature
    return Jet(
        _along_phase(leg, frame, d.value, q.value),
        _along_phase(leg, frame, d.slope, q.slope),
        _along_phase(leg, frame, d.bend, q.bend),
        _along_phase(leg, frame, d.jerk, q.jerk),
    )


@inlined
def phase_segment(
    circuit: Circuit, rates: Rates, rows: NDArray[np.float64], n: int, leg: int
) -> PhaseSegment:
    """Return a phase current in a segment.

    `rows`: with currents and rotor at both ends, voltages and times, as in `rows`. `n`: index of the segment. `leg`:
    index of the phase.
    """
    frame = frame_at(rows, n)
    after = frame_at(rows, n + 1)
    begin = in_stationary_frame(derivatives_at(rates, rows, frame, n), circuit.electrical)
    end = in_stationary_frame(derivatives_at(rates, rows, after, n), circuit.electrical)
    length = rows[TIME + 1 + n] - rows[TIME + n]
    change = 0.5 * length * curvature(circuit, begin, length)
    return PhaseSegment(_of_phase(leg, frame, begin), _of_phase(leg, after, end), length, change)


@inlined
def is_steep(before: float, after: float, deviation: float) -> bool:
    """Return True if a current is monotone, from its values at both ends and the maximum sagitta (A).

    Its slope differs from the chord's by at most half of the segment's length times the bound of the curvature,
    which is four times the sagitta over the length.
    """
    return bool(abs(after - before) > 4.0 * deviation)


@inlined
def is_monotone(phase: PhaseSegment) -> bool:
    """Return True if a current is monotone in a segment, from its slopes at both ends."""
    first, last = phase.begin.slope, phase.end.slope
    return bool(min(first, last) > phase.change or max(first, last) < -phase.change)


@inlined
def is_bent_one_way(circuit: Circuit, phase: PhaseSegment) -> bool:
    """Return True if a current's slope is strictly monotone in a segment, with a margin.

    The second derivative differs from its own chord by at most an eighth of its curvature's bound times the square of
    the length; this is at most a quarter of its smaller value at an end.
    """
    reach = circuit.pace * phase.length
    least = 0.5 * reach * reach * circuit.bend
    first, last = phase.begin.bend, phase.end.bend
    return bool(min(first, last) > least or max(first, last) < -least)
