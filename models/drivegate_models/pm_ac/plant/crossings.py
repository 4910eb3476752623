"""Currents that cross zero in a control period without changing a voltage, as with ideal switches.

This period is still computed at once. Only the magnitudes of the currents, and the energy exchanged with the link, need
parts of one sign: the segment with the zero is divided there.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.machine.rotor_frame import of_phase
from drivegate_models.pm_ac.plant.circuit import Circuit, has_drops, sagitta
from drivegate_models.pm_ac.plant.integrals import FOUR_PLACES, FOUR_WEIGHTS
from drivegate_models.pm_ac.plant.interpolation import (
    Interpolant,
    interpolant_of,
    interpolated,
    interpolated_slope,
)
from drivegate_models.pm_ac.plant.jets import Rates
from drivegate_models.pm_ac.plant.modulator import BLANKED, Gates
from drivegate_models.pm_ac.plant.phase_segments import (
    PhaseSegment,
    current_at,
    is_monotone,
    is_steep,
    phase_segment,
)
from drivegate_models.pm_ac.plant.rows import (
    CHARGE_ACROSS,
    CHARGE_ALONG,
    LINK_ACROSS,
    LINK_ALONG,
    TIME,
)

_STEPS: Final = 60
_REACHED: Final = 1e-9
# The link's current over a leg's current is 1, 1/2 with either sign, or 0.
_SUPPLIES: Final = 0.75


class Returning(NamedTuple):
    """Excess of the sum of magnitudes of parts over the magnitude of their sum."""

    magnitude: float
    """Integral of a current's magnitude over the period beyond the magnitude of its integral (A s)."""
    exchanged: float
    """Integral of the magnitude of the link's current over all segments beyond the sum of the magnitudes of its
    integrals over each (A s)."""


@inlined
def ignores_sign(circuit: Circuit, gates: Gates, leg: int) -> bool:
    """Return True if the sign of a leg's current affects no voltage and no loss in a period."""
    energies = circuit.turn_on_energy + circuit.turn_off_energy
    blanked = 0
    for position in range(gates.counts[leg]):
        blanked += 1 if gates.gates[leg, position] == BLANKED else 0
    return not has_drops(circuit) and energies == 0.0 and blanked == 0


@inlined
def _zero(phase: PhaseSegment, interpolant: Interpolant) -> float:
    """Return the share of a segment at which a monotone current crosses zero."""
    begin, end, length = phase.begin, phase.end, phase.length
    sign = 1.0 if begin.value > 0.0 else -1.0
    low, high = 0.0, 1.0
    share = begin.value / (begin.value - end.value)
    for _ in range(_STEPS):
        value = interpolated(interpolant, share)
        if sign * value > 0.0:
            low = share
        else:
            high = share
        slope = length * interpolated_slope(begin, end, length, share)
        following = share - value / slope if slope != 0.0 else high
        if not low <= following <= high:
            following = 0.5 * (low + high)
        step = abs(following - share)
        share = following
        if step < _REACHED:
            break
    return share


@inlined
def _charge_to_zero(phase: PhaseSegment) -> float:
    """Return the integral of a current from the segment's start to its zero (A s)."""
    interpolant = interpolant_of(phase.begin, phase.end, phase.length)
    share = _zero(phase, interpolant)
    total = 0.0
    for n in range(4):
        total += FOUR_WEIGHTS[n] * interpolated(interpolant, share * FOUR_PLACES[n])
    return phase.length * share * total


@unallocating
def passes_zero(circuit: Circuit, rates: Rates, rows: NDArray[np.float64], count: int, leg: int) -> bool:
    """Return True if a current in a period is monotone in every segment in which it is near zero.

    `rows`: with currents, rotor, voltages and times of all segments, as in `rows`. `count`: number of segments. `leg`:
    leg with the current. Result: if True, a segment has one zero if the current has two signs at its ends, and none
    otherwise.
    """
    after = current_at(rows, 0, leg)
    for n in range(count):
        before = after
        after = current_at(rows, n + 1, leg)
        deviation = sagitta(circuit, rows[TIME + 1 + n] - rows[TIME + n])
        is_near = before * after < 0.0 or min(abs(before), abs(after)) <= deviation
        if (
            is_near
            and not is_steep(before, after, deviation)
            and not is_monotone(phase_segment(circuit, rates, rows, n, leg))
        ):
            return False
    return True


@unallocating
def returning_of(
    circuit: Circuit, rates: Rates, rows: NDArray[np.float64], count: int, leg: int
) -> Returning:
    """Return the excess of the magnitudes of a current that crosses zero.

    `rows`: with currents, rotor, voltages, times and charges of all segments, as in `rows`. `count`: number of
    segments, each of at most `two_points.SHORT` over the circuit's rate. `leg`: leg with the current, for which
    `passes_zero` is True.
    """
    magnitude, whole, exchanged = 0.0, 0.0, 0.0
    after = current_at(rows, 0, leg)
    for n in range(count):
        before = after
        after = current_at(rows, n + 1, leg)
        charge = of_phase(leg, rows[CHARGE_ALONG + n], rows[CHARGE_ACROSS + n])
        parts = abs(charge)
        if before * after < 0.0:
            first = _charge_to_zero(phase_segment(circuit, rates, rows, n, leg))
            parts = abs(first) + abs(charge - first)
            if abs(of_phase(leg, rows[LINK_ALONG + n], rows[LINK_ACROSS + n])) > _SUPPLIES:
                exchanged += parts - abs(charge)
        magnitude += parts
        whole += charge
    return Returning(magnitude - abs(whole), exchanged)
