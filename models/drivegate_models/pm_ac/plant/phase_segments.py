"""A phase current in one segment of a control period: its value and derivatives at both ends, and what bounds it."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.rotor_frame import RotorFrame, of_phase, turned
from drivegate_models.pm_ac.plant.circuit import Circuit
from drivegate_models.pm_ac.plant.jets import Currents, Jet, Rates, derivatives, standing
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
    """A phase current in a segment."""

    begin: Jet
    """At its start (A)."""
    end: Jet
    """At its end."""
    length: float
    """Of the segment (s)."""
    change: float
    """Bound of how far the slope can be from that at an end, half of the segment away (A/s)."""


@inlined
def frame_at(rows: NDArray[np.float64], n: int) -> RotorFrame:
    """Return the currents and the rotor at an instant."""
    return RotorFrame(rows[DIRECT + n], rows[QUADRATURE + n], rows[COSINE + n], rows[SINE + n])


@inlined
def derivatives_at(rates: Rates, rows: NDArray[np.float64], frame: RotorFrame, n: int) -> Currents:
    """Return the derivatives of the currents at an instant under the voltages of a segment."""
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
    """Return the share of a phase in a quantity of axes that lie where the rotor's are."""
    along, across = turned(frame, direct, quadrature)
    return of_phase(leg, along, across)


@inlined
def _of_phase(leg: int, frame: RotorFrame, currents: Currents) -> Jet:
    """Return the current of a phase and its derivatives from those along standing axes."""
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

    Parameters
    ----------
    circuit : Circuit
        Constants of the advance.
    rates : Rates
        Its equations.
    rows : ndarray
        Currents and rotor at both ends, voltages and times, as `rows` has them.
    n : int
        The segment.
    leg : int
        The phase.

    Returns
    -------
    PhaseSegment
        At both ends.
    """
    frame = frame_at(rows, n)
    after = frame_at(rows, n + 1)
    begin = standing(derivatives_at(rates, rows, frame, n), circuit.electrical)
    end = standing(derivatives_at(rates, rows, after, n), circuit.electrical)
    length = rows[TIME + 1 + n] - rows[TIME + n]
    change = 0.5 * length * curvature(circuit, begin, length)
    return PhaseSegment(_of_phase(leg, frame, begin), _of_phase(leg, after, end), length, change)


@inlined
def is_steep(before: float, behind: float, deviation: float) -> bool:
    """Return whether a current only rises or only falls, by its values at both ends and the greatest sagitta.

    Its slope is no further from that of the chord than half of the segment's length times the bound of the curvature,
    which is four times the sagitta over the length.
    """
    return bool(abs(behind - before) > 4.0 * deviation)


@inlined
def is_monotone(phase: PhaseSegment) -> bool:
    """Return whether a current only rises or only falls in a segment, by its slopes at both ends."""
    first, last = phase.begin.slope, phase.end.slope
    return bool(min(first, last) > phase.change or max(first, last) < -phase.change)


@inlined
def is_bent_one_way(circuit: Circuit, phase: PhaseSegment) -> bool:
    """Return whether a current's slope only rises or only falls in a segment, and nowhere hardly so.

    The bend is no further from its own chord than an eighth of its curvature's bound times the square of the length; a
    quarter of the lesser bend is what may be missing.
    """
    reach = circuit.pace * phase.length
    least = 0.5 * reach * reach * circuit.bend
    first, last = phase.begin.bend, phase.end.bend
    return bool(min(first, last) > least or max(first, last) < -least)
