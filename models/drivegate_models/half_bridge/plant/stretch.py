"""What the pieces of a phase's advance pass to each other: constants, the stretch between two events, and sums.

All of it is plain numbers in named tuples, which the compiler keeps in registers.
"""

from __future__ import annotations

from typing import NamedTuple

from drivegate_models.compilation.kernels import inlined


class Winding(NamedTuple):
    """Constants of leg and winding over one advance."""

    resistance: float
    """(ohm)."""
    inverse_inductance: float
    """(1/H)."""
    rate: float
    """R/L (1/s)."""
    longest: float
    """Longest stretch for which the series of `winding_current` are used (s)."""
    switch_drop: float
    """(V)."""
    diode_drop: float
    """(V)."""


class Demand(NamedTuple):
    """What the regulator of a phase is to do in one stretch."""

    reference: float
    """Current reference i* (A)."""
    band: float
    """Half-width h of the current band (A)."""
    sector: int
    """Window: 1, -1, or 0 between windows."""
    gate: int
    """Switch that is on: 1 upper, -1 lower, 0 none."""


class Stretch(NamedTuple):
    """Where a stretch begins, and the longest that it may last."""

    phase: int
    """Index of the phase."""
    time: float
    """From the beginning of the advance (s)."""
    length: float
    """To the next corner of the back-EMF, edge of a window, or end of the advance (s)."""
    shape: float
    """Back-EMF shape at its start (1)."""
    shape_rate: float
    """Its rate (1/s)."""
    emf: float
    """Back-EMF at its start (V)."""
    emf_rate: float
    """Its rate (V/s)."""


class Sums(NamedTuple):
    """Exact integrals of one phase over one advance, as `ledger` names them; kept in registers, not in memory."""

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
    """Where a phase stands between two stretches."""

    current: float
    """(A)."""
    latch: int
    """Comparator: 1 on, 0 off."""
    depart: int
    """Direction in which a slide has just been left, along the sector's sign: 1, -1, or 0 for none."""
    conducting: int
    """Sign of the current that a floating phase has just begun to carry, or 0."""
    kept: int
    """Number of segments kept."""


@inlined
def no_sums(peak: float) -> Sums:
    """Return the integrals at the start of an advance.

    Parameters
    ----------
    peak : float
        Magnitude of the current there (A).

    Returns
    -------
    Sums
        All 0 but for the peak.
    """
    return Sums(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, peak)


@inlined
def with_peak(sums: Sums, peak: float) -> Sums:
    """Return the same integrals with another peak.

    Parameters
    ----------
    sums : Sums
        Integrals so far.
    peak : float
        Greatest magnitude of the current so far (A).

    Returns
    -------
    Sums
        With that peak.
    """
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
