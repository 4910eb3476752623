"""The data of a phase's advance: constants, the stretch between two events, and sums.

They are plain numbers in named tuples, which the compiler stores in registers.
"""

from __future__ import annotations

from typing import NamedTuple

from drivegate_models.compilation.kernels import inlined


class Winding(NamedTuple):
    """Constants of leg and winding over one advance."""

    resistance: float
    """Winding resistance R (ohm)."""
    inverse_inductance: float
    """1/L (1/H)."""
    rate: float
    """R/L (1/s)."""
    longest: float
    """Longest stretch for which the series of `winding_current` are used (s)."""
    switch_drop: float
    """Forward drop of a switch (V)."""
    diode_drop: float
    """Forward drop of a diode (V)."""


class Demand(NamedTuple):
    """The commands of a phase's regulator in one stretch."""

    reference: float
    """Current reference i* (A)."""
    band: float
    """Half-width h of the current band (A)."""
    sector: int
    """Window: 1, -1, or 0 between windows."""
    gate: int
    """Switch that is on: 1 upper, -1 lower, 0 none."""


class Stretch(NamedTuple):
    """Start, maximum length and back-EMF of a stretch."""

    phase: int
    time: float
    """Start, from the beginning of the advance (s)."""
    length: float
    """Time to the next corner of the back-EMF, edge of a window, or end of the advance (s)."""
    shape: float
    """Back-EMF shape at the start (1)."""
    shape_rate: float
    """Rate of the shape (1/s)."""
    emf: float
    """Back-EMF at the start (V)."""
    emf_rate: float
    """Rate of the back-EMF (V/s)."""


class Sums(NamedTuple):
    """Exact integrals of one phase over one advance, named as in `ledger`; stored in registers, not in memory."""

    magnitude: float
    square: float
    shape_current: float
    """Integral of back-EMF shape times current (A s)."""
    upper: float
    lower: float
    exchanged: float
    returned: float
    device: float
    core: float
    """Integral of the squared gap voltage while connected (V2 s)."""
    drag: float
    """Integral of the squared back-EMF shape while floating (s)."""
    peak: float


class Motion(NamedTuple):
    """State of a phase between two stretches."""

    current: float
    """Phase current (A)."""
    latch: int
    """Comparator: 1 on, 0 off."""
    depart: int
    """Direction in which a slide has just ended, times the sector's sign: 1, -1, or 0 for none."""
    conducting: int
    """Sign of a current that has just begun to flow in a floating phase, or 0."""
    kept: int
    """Number of segments stored."""


@inlined
def no_sums(peak: float) -> Sums:
    """Return integrals of 0 at the start of an advance, with the current's magnitude as the peak (A)."""
    return Sums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, peak)


@inlined
def with_peak(sums: Sums, peak: float) -> Sums:
    """Return the same integrals with another peak of the current's magnitude (A)."""
    return Sums(
        sums.magnitude,
        sums.square,
        sums.shape_current,
        sums.upper,
        sums.lower,
        sums.exchanged,
        sums.returned,
        sums.device,
        sums.core,
        sums.drag,
        peak,
    )
