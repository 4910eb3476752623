"""A short segment in which no current is near an event, from the derivatives of the currents at its two ends.

With the equations of the rotor frame, each derivative of the currents needs only a few products. The currents at the
end are the Taylor series with the first eight derivatives.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine import ledger
from drivegate_models.machine.rotor_frame import RotorFrame, of_phase, turned
from drivegate_models.machine.sine import small_cosine_sine
from drivegate_models.pm_ac.plant.circuit import Circuit, rotor_voltages
from drivegate_models.pm_ac.plant.integrals import add_charge, supply_leg
from drivegate_models.pm_ac.plant.jets import (
    Currents,
    Rates,
    Step,
    derivatives,
    following_step,
    in_stationary_frame,
)
from drivegate_models.pm_ac.plant.settling import FREE, Legs
from drivegate_models.pm_ac.plant.two_points import SHORTEST, sums_between


class Passed(NamedTuple):
    """Result for a segment."""

    is_quiet: bool
    """True if no event is possible in it; otherwise nothing has been added."""
    frame: RotorFrame
    """Currents and angle at its end."""


@inlined
def _at_end(
    rates: Rates, begin: Currents, driven: float, driven_across: float, length: float, is_shortest: bool
) -> tuple[float, float]:
    """Return the currents at the end of a segment (A)."""
    power = 0.5 * length * length
    direct = length * begin.direct.slope + power * begin.direct.bend
    quadrature = length * begin.quadrature.slope + power * begin.quadrature.bend
    power *= length * (1.0 / 3.0)
    last_d = power * begin.direct.jerk
    last_q = power * begin.quadrature.jerk
    direct += last_d
    quadrature += last_q
    # Two derivatives rotate the voltages by half a turn.
    power *= rates.direct_turning * rates.quadrature_turning
    step = Step(last_d, last_q, power * driven, power * driven_across)
    for order in range(4, 9):
        if is_shortest and order == 7:
            break
        step = following_step(rates, length, step, order)
        direct += step.direct
        quadrature += step.quadrature
    return begin.direct.value + direct, begin.quadrature.value + quadrature


@inlined
def curvature(circuit: Circuit, begin: Currents, length: float) -> float:
    """Return a bound of the second derivative of any phase current over a segment (A/s2)."""
    direct, quadrature = begin.direct, begin.quadrature
    reach = circuit.pace * length
    size = abs(direct.bend) + abs(quadrature.bend) + length * (abs(direct.jerk) + abs(quadrature.jerk))
    return size + 0.5 * reach * reach * circuit.bend


@inlined
def _keeps_sign(legs: Legs, leg: int, begin: float, end: float, is_monotone: bool, deviation: float) -> bool:
    """Return True if a current has the sign of its leg throughout a segment."""
    if legs.sure[leg] != 0:
        return True
    sign = legs.signs[leg]
    least = min(sign * begin, sign * end)
    return bool(least > deviation or (is_monotone and least >= 0.0))


@inlined
def pass_quietly(
    pole_pairs: float,
    circuit: Circuit,
    rates: Rates,
    legs: Legs,
    frame: RotorFrame,
    length: float,
    magnitudes: NDArray[np.float64],
    totals: NDArray[np.float64],
) -> Passed:
    """Pass a segment without a held leg, and add it to the ledger if no current is near an event in it.

    - `pole_pairs`: pole pairs of the machine (1).
    - `length`: length of the segment, at most `two_points.SHORT` over the circuit's rate (s).
    - `magnitudes`, shape (3,): the integrals of the current magnitudes (A s) are added to it.
    - `totals`, shape (ledger.ENTRIES,): the exact integrals are added to it.
    - Result: not quiet if a current may reach zero, or a new maximum within the segment.
    """
    is_shortest = circuit.rate * length <= SHORTEST
    voltages = legs.voltages
    direct, quadrature = rotor_voltages(frame, voltages[0], voltages[1], voltages[2])
    driven = direct * rates.per_direct
    across = quadrature * rates.per_quadrature
    begin = derivatives(rates, frame.direct, frame.quadrature, driven, across)
    end_d, end_q = _at_end(rates, begin, driven, across, length, is_shortest)
    cosine, sine = small_cosine_sine(circuit.electrical * length)
    end = derivatives(
        rates,
        end_d,
        end_q,
        (cosine * direct + sine * quadrature) * rates.per_direct,
        (cosine * quadrature - sine * direct) * rates.per_quadrature,
    )
    after = RotorFrame(
        end_d,
        end_q,
        frame.cosine * cosine - frame.sine * sine,
        frame.sine * cosine + frame.cosine * sine,
    )
    begin_standing = in_stationary_frame(begin, circuit.electrical)
    end_standing = in_stationary_frame(end, circuit.electrical)
    begin_a, begin_b = turned(frame, begin.direct.value, begin.quadrature.value)
    end_a, end_b = turned(after, end_d, end_q)
    begin_slope_a, begin_slope_b = turned(frame, begin_standing.direct.slope, begin_standing.quadrature.slope)
    end_slope_a, end_slope_b = turned(after, end_standing.direct.slope, end_standing.quadrature.slope)
    change = 0.5 * length * curvature(circuit, begin_standing, length)
    deviation = 0.25 * length * change
    peak = totals[ledger.PEAK]
    for leg in range(3):
        first = of_phase(leg, begin_a, begin_b)
        last = of_phase(leg, end_a, end_b)
        first_slope = of_phase(leg, begin_slope_a, begin_slope_b)
        last_slope = of_phase(leg, end_slope_a, end_slope_b)
        is_monotone = min(first_slope, last_slope) > change or max(first_slope, last_slope) < -change
        top = max(abs(first), abs(last))
        if not is_monotone and top + deviation > peak:
            return Passed(False, frame)
        if not _keeps_sign(legs, leg, first, last, is_monotone, deviation):
            return Passed(False, frame)
        peak = max(peak, top)
    totals[ledger.PEAK] = peak

    # Two calls, so that each is compiled without the code that only the other needs.
    if is_shortest:
        sums = sums_between(circuit, begin, end, frame, after, length, True)
    else:
        sums = sums_between(circuit, begin, end, frame, after, length, False)
    totals[ledger.SQUARE] += 1.5 * sums.square
    totals[ledger.IMPULSE] += 1.5 * pole_pairs * sums.torque
    supply = supply_leg(legs, FREE)
    for leg in range(3):
        charge = of_phase(leg, sums.along, sums.across)
        add_charge(circuit, legs, leg, supply, charge, abs(charge), magnitudes, totals)
    return Passed(True, after)
