"""Integrals of one segment for the ledger: exact integrals of series, and Gauss-Legendre quadrature for products."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.machine import ledger
from drivegate_models.machine.rotor_frame import RotorFrame, of_phase, phase_current
from drivegate_models.machine.sine import small_cosine_sine
from drivegate_models.pm_ac.plant.circuit import Circuit, drop_of, is_on_upper_rail, sagitta
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.plant.polynomial import (
    extremes,
    first_fall,
    integral_to,
    size_of,
    value_at,
)
from drivegate_models.pm_ac.plant.series import TERMS, Series, phase_series
from drivegate_models.pm_ac.plant.settling import FREE, Legs

FOUR_PLACES: Final = (0.06943184420297371, 0.33000947820757187, 0.6699905217924281, 0.9305681557970262)
"""Places on [0, 1] of the four-point rule, which is exact up to degree 7."""
FOUR_WEIGHTS: Final = (0.17392742256872679, 0.3260725774312732, 0.3260725774312732, 0.17392742256872679)

# Places and weights of the rules with 3, 4 and 5 points, in this order.
PLACES: Final = (
    0.1127016653792583,
    0.5,
    0.8872983346207417,
    *FOUR_PLACES,
    0.04691007703066802,
    0.23076534494715845,
    0.5,
    0.7692346550528415,
    0.9530899229693319,
)
WEIGHTS: Final = (
    0.27777777777777785,
    0.4444444444444444,
    0.27777777777777785,
    *FOUR_WEIGHTS,
    0.11846344252809464,
    0.23931433524968315,
    0.28444444444444433,
    0.23931433524968315,
    0.11846344252809464,
)
# Segment times the fastest rate up to which three and four points have a relative error below 1e-13 for a product. If a
# current begins at zero, the coefficient of order k of its square is that of order 2 times the (k - 2)th power of this.
THREE_POINTS: Final = 7e-3
FOUR_POINTS: Final = 9e-2
_CROSSING = 1e-14
_CROSSINGS = 16


class Sums(NamedTuple):
    """Integrals over a segment."""

    square: float
    """Integral of the squared d-q current (A2 s)."""
    impulse: float
    """Integral of the torque (N m s)."""
    along: float
    """Integral of the current along the axis of the first phase (A s)."""
    across: float
    """Integral of the current across the axis of the first phase (A s)."""


@inlined
def _sums(
    circuit: Circuit,
    drive: PmAcDrive,
    series: Series,
    frame: RotorFrame,
    count: int,
    length: float,
    is_free: bool,
) -> Sums:
    """Return the integrals of squares, products and currents in the stationary frame over a segment."""
    reach = circuit.rate * length
    points = 5
    offset = 7
    if is_free and reach <= THREE_POINTS:
        points = 3
        offset = 0
    elif is_free and reach <= FOUR_POINTS:
        points = 4
        offset = 3
    square = 0.0
    product = 0.0
    quadrature_sum = 0.0
    along = 0.0
    across = 0.0
    for n in range(offset, offset + points):
        direct = value_at(series.direct, count, PLACES[n])
        quadrature = value_at(series.quadrature, count, PLACES[n])
        cosine, sine = small_cosine_sine(circuit.electrical * length * PLACES[n])
        weight = WEIGHTS[n]
        square += weight * (direct * direct + quadrature * quadrature)
        product += weight * (direct * quadrature)
        quadrature_sum += weight * quadrature
        along += weight * (cosine * direct - sine * quadrature)
        across += weight * (sine * direct + cosine * quadrature)
    saliency = drive.direct_inductance - drive.quadrature_inductance
    per_ampere = 1.5 * drive.pole_pairs * length
    return Sums(
        square * length,
        per_ampere * (circuit.flux * quadrature_sum + saliency * product),
        length * (frame.cosine * along - frame.sine * across),
        length * (frame.sine * along + frame.cosine * across),
    )


@unallocating
def magnitude_of(series: Series, count: int) -> float:
    """Return the integral of the magnitude of the phase current in `other`, per segment length (A)."""
    slack = _CROSSING * size_of(series.other, count)
    if slack == 0.0:
        return 0.0
    total = 0.0
    at = 0.0
    before = 0.0
    sign = 1.0 if value_at(series.other, count, 1e-3) >= 0.0 else -1.0
    for _ in range(_CROSSINGS):
        following = first_fall(series.other, count, sign, at, slack)
        end = following if following <= 1.0 else 1.0
        now = integral_to(series.other, count, end)
        total += abs(now - before)
        before = now
        at = end
        sign = -sign
        if following > 1.0:
            return total
    return total + abs(integral_to(series.other, count, 1.0) - before)


@inlined
def add_leg(
    circuit: Circuit,
    series: Series,
    frame: RotorFrame,
    after: RotorFrame,
    leg: int,
    charge: float,
    count: int,
    length: float,
    is_smooth: bool,
    peak: float,
) -> tuple[float, float]:
    """Return the integral of a current's magnitude over a segment (A s), and the maximum magnitude so far (A)."""
    begin = phase_current(frame, leg)
    end = phase_current(after, leg)
    peak = max(peak, abs(begin), abs(end))
    deviation = sagitta(circuit, length)
    least = min(begin, end) if begin > 0.0 else -max(begin, end)
    keeps_sign = is_smooth and least > deviation
    is_steady = abs(end - begin) > 8.0 * deviation
    stays_below = is_smooth and (is_steady or max(abs(begin), abs(end)) + deviation <= peak)
    if not (keeps_sign and stays_below):
        phase_series(circuit, series, frame, leg, count, length)
    return magnitude_and_peak(series, charge, count, length, keeps_sign, stays_below, peak)


@inlined
def magnitude_and_peak(
    series: Series,
    charge: float,
    count: int,
    length: float,
    keeps_sign: bool,
    stays_below: bool,
    peak: float,
) -> tuple[float, float]:
    """Return the integral of a current's magnitude (A s) and the maximum magnitude so far (A), as `add_leg`.

    The series of the current is in `other` unless it keeps its sign and stays below the maximum.
    """
    if not stays_below:
        lowest, highest = extremes(series.other, count, series.slopes)
        peak = max(peak, -lowest, highest)
    return abs(charge) if keeps_sign else length * magnitude_of(series, count), peak


@inlined
def extend_torque_range(drive: PmAcDrive, series: Series, count: int, bounds: NDArray[np.float64]) -> None:
    """Extend a range by the torque over a segment (N m)."""
    saliency = drive.direct_inductance - drive.quadrature_inductance
    per_ampere = 1.5 * drive.pole_pairs
    terms = min(2 * count - 1, TERMS)
    for k in range(terms):
        product = 0.0
        for n in range(max(0, k - count + 1), min(k, count - 1) + 1):
            product += series.direct[n] * series.quadrature[k - n]
        linear = drive.magnet_flux * series.quadrature[k] if k < count else 0.0
        series.other[k] = per_ampere * (linear + saliency * product)
    lowest, highest = extremes(series.other, terms, series.slopes)
    bounds[0] = min(bounds[0], lowest)
    bounds[1] = max(bounds[1], highest)


@inlined
def supply_leg(legs: Legs, held: int) -> int:
    """Return the leg whose current is that of the link, -1 if the link carries none."""
    upper = 0
    only_upper = -1
    only_lower = -1
    for leg in range(3):
        if leg == held:
            continue
        if is_on_upper_rail(legs.gates[leg], legs.signs[leg]):
            upper += 1
            only_upper = leg
        else:
            only_lower = leg
    if upper == 1:
        return only_upper
    # The sum of two currents from the upper rail returns through the third leg.
    return only_lower if upper == 2 and only_lower >= 0 else -1


@inlined
def add_charge(
    circuit: Circuit,
    legs: Legs,
    leg: int,
    supply: int,
    charge: float,
    magnitude: float,
    magnitudes: NDArray[np.float64],
    totals: NDArray[np.float64],
) -> None:
    """Add a leg's charge and magnitude (A s) in a segment to magnitudes, drops and the link's energies."""
    add_magnitude(circuit, legs, leg, magnitude, magnitudes, totals)
    if leg == supply:
        exchanged = circuit.link * magnitude
        drawn = circuit.link * charge
        if not is_on_upper_rail(legs.gates[leg], legs.signs[leg]):
            drawn = -drawn
        add_exchange(drawn, exchanged, totals)


@inlined
def add_magnitude(
    circuit: Circuit,
    legs: Legs,
    leg: int,
    magnitude: float,
    magnitudes: NDArray[np.float64],
    totals: NDArray[np.float64],
) -> None:
    """Add the magnitude of a leg's charge (A s) in a segment to magnitudes and drops."""
    magnitudes[leg] += magnitude
    totals[ledger.MAGNITUDE] += magnitude
    totals[ledger.DEVICE] += drop_of(circuit, legs.gates[leg], legs.signs[leg]) * magnitude


@inlined
def add_exchange(drawn: float, exchanged: float, totals: NDArray[np.float64]) -> None:
    """Add the energy drawn from the link, and that exchanged with it either way (J), to the link's energies."""
    totals[ledger.UPPER] += 0.5 * drawn
    totals[ledger.LOWER] += 0.5 * drawn
    totals[ledger.EXCHANGED] += exchanged
    totals[ledger.RETURNED] += 0.5 * (exchanged - drawn)


@unallocating
def add_segment(
    drive: PmAcDrive,
    circuit: Circuit,
    legs: Legs,
    series: Series,
    frame: RotorFrame,
    after: RotorFrame,
    held: int,
    count: int,
    length: float,
    magnitudes: NDArray[np.float64],
    bounds: NDArray[np.float64],
    totals: NDArray[np.float64],
) -> None:
    """Add a segment with currents to the ledger.

    - `held`: `settling.FREE` or the held leg.
    - `count`: number of coefficients.
    - `length`: length of the segment (s).
    - `magnitudes`, shape (3,): the integrals of the current magnitudes (A s) are added to it.
    - `bounds`, shape (2,): minimum and maximum torque (N m), extended; not computed with shape (0,).
    - `totals`, shape (ledger.ENTRIES,): the exact integrals are added to it.
    """
    sums = _sums(circuit, drive, series, frame, count, length, held == FREE)
    totals[ledger.SQUARE] += 1.5 * sums.square
    totals[ledger.IMPULSE] += sums.impulse
    supply = supply_leg(legs, held)
    peak = totals[ledger.PEAK]
    for leg in range(3):
        if leg == held:
            continue
        charge = of_phase(leg, sums.along, sums.across)
        magnitude, peak = add_leg(
            circuit, series, frame, after, leg, charge, count, length, held == FREE, peak
        )
        add_charge(circuit, legs, leg, supply, charge, magnitude, magnitudes, totals)
    totals[ledger.PEAK] = peak
    if bounds.size > 0:
        extend_torque_range(drive, series, count, bounds)
