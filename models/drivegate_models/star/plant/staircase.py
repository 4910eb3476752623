"""Terminal voltage of a leg: gates, diodes and the ideal comparator make it a falling staircase of the current.

The terminal voltage, relative to the middle of the link, is a falling step function of the phase current alone. It has
three treads: below a first level the current flows back through the upper diode, above a second level it continues
through the lower diode, and between the two the switch of the window is on::

    gates off                    levels 0 and 0        (no middle tread)
    upper switch on              0 and infinity        middle +V, less the switch's drop
    lower switch on              -infinity and 0       middle -V, plus the switch's drop
    ideal regulator, positive    0 and i*              as the upper switch on
    ideal regulator, negative    -i* and 0             as the lower switch on

At a level the voltage is any between those of the treads on both sides.
"""

from __future__ import annotations

from math import inf
from typing import Final, NamedTuple

from drivegate_models.compilation.kernels import inlined

LOWEST: Final = 0
"""The tread below the first level: upper diode."""
MIDDLE: Final = 1
"""The tread between the levels: the window's switch."""
HIGHEST: Final = 2
"""The tread above the second level: lower diode."""


class Circuit(NamedTuple):
    """Constants of machine and inverter over one advance."""

    resistance: float
    """Winding resistance R of a phase (ohm)."""
    inverse_inductance: float
    """1/L (1/H)."""
    rate: float
    """R/L (1/s)."""
    longest: float
    """Longest stretch for which the series of `winding_current` are used (s)."""
    source: float
    """Voltage of half the link (V)."""
    switch_drop: float
    """Forward drop of a switch (V)."""
    diode_drop: float
    """Forward drop of a diode (V)."""
    reference: float
    """Current reference i* (A); 0 blocks the gates."""
    band: float
    """Half-width h of the current band (A)."""
    window: float
    """Width of each conduction window (rad electrical)."""
    regulation: int
    """Which halves of the windows chop, as in `drive.StarDrive`."""
    turn_on_energy: float
    """Energy lost at each turn-on of a switch (J)."""
    turn_off_energy: float
    """Energy lost at each turn-off of a switch (J)."""
    emf_constant: float
    """Peak back-EMF of a phase per shaft speed (V s/rad)."""
    emf_peak: float
    """Peak back-EMF of a phase at the present speed (V)."""
    core_loss_conductance: float
    """Core loss of a phase over the square of the gap voltage (S)."""


class Staircase(NamedTuple):
    """The levels of a leg's staircase, and the switch of its middle tread."""

    first: float
    """Current between the lowest and the middle tread (A)."""
    second: float
    """Current between the middle and the highest tread (A)."""
    gate: int
    """Switch of the middle tread: 1 upper, -1 lower, 0 none."""


@inlined
def staircase(gate: int, is_ideal: bool, reference: float) -> Staircase:
    """Return the staircase of a leg.

    `gate`: switch that is on, or that the ideal regulator uses: 1 upper, -1 lower, 0 none. `is_ideal`: true if the
    ideal regulator chops. `reference`: current reference i* (A). Result: its levels, infinite where a tread is
    unlimited.
    """
    end = reference if is_ideal else inf
    return Staircase(-end if gate < 0 else 0.0, end if gate > 0 else 0.0, gate)


@inlined
def tread_voltage(circuit: Circuit, gate: int, tread: int) -> float:
    """Return the terminal voltage on a tread (V)."""
    if tread == MIDDLE:
        return gate * (circuit.source - circuit.switch_drop)
    back = circuit.source + circuit.diode_drop
    return back if tread == LOWEST else -back


@inlined
def treads_at(steps: Staircase, current: float) -> tuple[int, int]:
    """Return the treads below and above a current: two at a level, the same one between levels.

    `current`: phase current (A), exactly a level if it has reached one. Returns `below`, `above`: `LOWEST`, `MIDDLE`
    or `HIGHEST`.
    """
    # Exact comparisons are sufficient: an event at a level sets the current to the level itself.
    if current < steps.first:
        return LOWEST, LOWEST
    if current > steps.second:
        return HIGHEST, HIGHEST
    below = LOWEST if current == steps.first else MIDDLE
    above = HIGHEST if current == steps.second else MIDDLE
    return below, above


@inlined
def levels_of(steps: Staircase, tread: int) -> tuple[float, float]:
    """Return the minimum and maximum current of a tread (A)."""
    if tread == LOWEST:
        return -inf, steps.first
    if tread == HIGHEST:
        return steps.second, inf
    return steps.first, steps.second
