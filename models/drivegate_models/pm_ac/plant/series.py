"""The currents between two events as power series of the share of the segment's time, 0 to 1.

Speed and leg voltages are constant in a segment, so the equations in the rotor frame are linear with a voltage that
rotates backward. With all terms multiplied by powers of the length, each coefficient is computed from the preceding
one. There is no division by resistance, speed or a difference, so none of them is a special case when zero.
"""

from __future__ import annotations

from math import sqrt
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.machine.rotor_frame import HALF_ROOT, RotorFrame, axis_of, of_phase
from drivegate_models.pm_ac.plant.circuit import Circuit
from drivegate_models.pm_ac.plant.polynomial import value_at

TERMS: Final = 40
"""Maximum number of coefficients."""
LONGEST: Final = 0.25
"""Maximum segment times the fastest rate (1)."""
LONGEST_HELD: Final = 0.125
"""The same while a leg is held in a salient machine, per root of smaller over larger inductance (1).

The inductance seen by the other two legs then varies with the angle. It is zero at a complex angle, whose imaginary
part is artanh of that root.
"""

CUT: Final = 1e-17
LEAST_TERMS: Final = 4


class Series(NamedTuple):
    """Coefficients in one segment, each of shape (TERMS,); overwritten for every segment."""

    direct: NDArray[np.float64]
    """d-axis current (A)."""
    quadrature: NDArray[np.float64]
    """q-axis current (A)."""
    other: NDArray[np.float64]
    """Quantity in which an event is searched: a phase current (A) or a voltage (V)."""
    cosine: NDArray[np.float64]
    """Cosine of an angle (1)."""
    sine: NDArray[np.float64]
    """Sine of that angle (1)."""
    flux: NDArray[np.float64]
    """Flux linkage of the currents (V s)."""
    current: NDArray[np.float64]
    """Current between the other two legs while one is held (A)."""
    holding: NDArray[np.float64]
    """Voltage of a held leg (V)."""
    slopes: NDArray[np.float64]
    """Work space for a derivative."""


def make_series() -> Series:
    return Series(*(np.zeros(TERMS) for _ in Series._fields))


@inlined
def longest_segment(circuit: Circuit, held: int, duration: float) -> float:
    """Return the maximum length of a segment for fast convergence of its series (s)."""
    share = LONGEST
    if 0 <= held <= 2 and circuit.direct != circuit.quadrature:
        ratio = circuit.direct / circuit.quadrature
        share = LONGEST_HELD * sqrt(min(ratio, 1.0 / ratio))
    return share / circuit.rate if circuit.rate * duration > share else duration


@inlined
def term_count(reach: float) -> int:
    """Return the number of terms of a series of entire functions, for an argument `reach` (1)."""
    count = 1
    term = 1.0
    while (term > CUT or count < LEAST_TERMS) and count < TERMS:
        term *= reach / count
        count += 1
    return count


@inlined
def free_series(
    circuit: Circuit, series: Series, frame: RotorFrame, direct: float, quadrature: float, length: float
) -> int:
    """Write the series of the currents while no leg is held.

    `series`: receives `direct` and `quadrature`. `direct`, `quadrature`: d-axis and q-axis voltages at the start (V).
    `length`: length of the segment (s). Result: number of coefficients.
    """
    electrical = circuit.electrical
    per_direct = 1.0 / circuit.direct
    per_quadrature = 1.0 / circuit.quadrature
    # The voltage induced by the magnet does not rotate with the others.
    opposed = electrical * circuit.flux
    flux_d = circuit.direct * frame.direct
    flux_q = circuit.quadrature * frame.quadrature
    current_d = frame.direct
    current_q = frame.quadrature
    series.direct[0] = current_d
    series.quadrature[0] = current_q
    count = term_count(circuit.rate * length)
    for k in range(1, count):
        step = length / k
        rate_d = direct - circuit.resistance * current_d + electrical * flux_q
        rate_q = quadrature - circuit.resistance * current_q - electrical * flux_d - opposed
        opposed = 0.0
        flux_d = step * rate_d
        flux_q = step * rate_q
        direct, quadrature = step * electrical * quadrature, -step * electrical * direct
        current_d = flux_d * per_direct
        current_q = flux_q * per_quadrature
        series.direct[k] = current_d
        series.quadrature[k] = current_q
    return count


@inlined
def turning_series(
    cosines: NDArray[np.float64],
    sines: NDArray[np.float64],
    count: int,
    cosine: float,
    sine: float,
    angle: float,
) -> None:
    """Write the series of cosine and sine of an angle that increases linearly by `angle` (rad) over the segment."""
    cosines[0] = cosine
    sines[0] = sine
    for k in range(1, count):
        step = angle / k
        cosines[k] = -step * sines[k - 1]
        sines[k] = step * cosines[k - 1]


@inlined
def product_term(first: NDArray[np.float64], second: NDArray[np.float64], order: int) -> float:
    """Return a coefficient of the product of two series."""
    total = 0.0
    for k in range(order + 1):
        total += first[k] * second[order - k]
    return total


@unallocating
def phase_series(
    circuit: Circuit, series: Series, frame: RotorFrame, leg: int, count: int, length: float
) -> None:
    """Write the series of a phase current to `other`.

    `series`: with `direct` and `quadrature`. `leg`: index of the phase. `count`: number of coefficients. `length`:
    length of the segment (s).
    """
    cosine, sine = axis_of(frame, leg)
    turning_series(series.cosine, series.sine, count, cosine, sine, circuit.electrical * length)
    for k in range(count):
        series.other[k] = product_term(series.cosine, series.direct, k) - product_term(
            series.sine, series.quadrature, k
        )


@inlined
def standing_phase_series(series: Series, leg: int, count: int) -> None:
    """Write the series of a phase current to `other`, from currents in the stationary frame.

    `series`: `direct` and `quadrature` contain the currents along and across the first phase's axis. `leg`: index of
    the phase. `count`: number of coefficients.
    """
    for k in range(count):
        series.other[k] = of_phase(leg, series.direct[k], series.quadrature[k])


@unallocating
def held_series(
    circuit: Circuit,
    series: Series,
    frame: RotorFrame,
    held: int,
    voltages: NDArray[np.float64],
    length: float,
) -> int:
    """Write the series of the currents, and of the leg's own voltage, while a leg is held at zero current.

    T is the angle from the phase's axis to the d axis. The current m from the next leg to the one after it has the
    flux linkage ``m (L_S + L_D cos 2T)`` in its own direction, and ``psi cos T - m L_D sin 2T`` along the phase's
    axis, where 2 L_S = L_q + L_d and 2 L_D = L_q - L_d.

    `series`: receives `direct`, `quadrature`, `current` and `holding`. `frame`: currents at the start, with zero in the
    held leg. `held`: index of that leg. `voltages`, shape (3,): voltages of the legs (V); that of the held leg is not
    used. `length`: length of the segment (s). Result: number of coefficients.
    """
    ahead = voltages[(held + 1) % 3]
    behind = voltages[(held + 2) % 3]
    driving = (ahead - behind) / (2.0 * HALF_ROOT)
    cosine, sine = axis_of(frame, held)
    angle = circuit.electrical * length
    mean = 0.5 * (circuit.quadrature + circuit.direct)
    swing = 0.5 * (circuit.quadrature - circuit.direct)
    double_cosine = cosine * cosine - sine * sine
    count = TERMS if swing != 0.0 else term_count(circuit.rate * length)
    cosines = series.cosine
    sines = series.sine
    # The arrays of the currents contain the double angle until the currents are known.
    doubles = series.direct
    double_sines = series.quadrature
    turning_series(cosines, sines, count, cosine, sine, angle)
    turning_series(doubles, double_sines, count, double_cosine, 2.0 * sine * cosine, 2.0 * angle)
    currents = series.current
    flux = series.flux
    inductance = mean + swing * double_cosine
    currents[0] = sine * frame.direct + cosine * frame.quadrature
    flux[0] = inductance * currents[0]
    emf = circuit.electrical * circuit.flux
    rest = 1.0
    size = 0.0
    used = count
    for k in range(1, count):
        forced = driving if k == 1 else 0.0
        flux[k] = length / k * (forced - circuit.resistance * currents[k - 1] - emf * cosines[k - 1])
        varied = 0.0
        for n in range(1, k + 1):
            varied += doubles[n] * currents[k - n]
        currents[k] = (flux[k] - swing * varied) / inductance
        size += abs(currents[k])
        rest = max(abs(currents[k]), abs(currents[k - 1]))
        if k >= LEAST_TERMS and rest <= CUT * size and abs(cosines[k]) + abs(sines[k]) <= CUT:
            used = k + 1
            break
    for k in range(used):
        series.holding[k] = circuit.flux * cosines[k] - swing * product_term(currents, double_sines, k)
    for k in range(used - 1):
        series.holding[k] = 1.5 * (k + 1) * series.holding[k + 1] / length
    series.holding[used - 1] = 0.0
    series.holding[0] += 0.5 * (ahead + behind)
    for k in range(used):
        series.direct[k] = product_term(currents, sines, k)
        series.quadrature[k] = product_term(currents, cosines, k)
    return used


@inlined
def shorten(series: Series, count: int, share: float) -> None:
    """Rescale the series of the currents to a share of their segment."""
    shorten_both(series.direct, series.quadrature, count, share)


@inlined
def shorten_one(series: NDArray[np.float64], count: int, share: float) -> None:
    """Rescale a series, shape (n,), to a share of its segment."""
    power = 1.0
    for k in range(count):
        series[k] *= power
        power *= share


@inlined
def shorten_both(first: NDArray[np.float64], second: NDArray[np.float64], count: int, share: float) -> None:
    """Rescale two series, shape (n,), to a share of their segment."""
    power = 1.0
    for k in range(count):
        first[k] *= power
        second[k] *= power
        power *= share


@inlined
def at_end(series: Series, count: int, cosine: float, sine: float) -> RotorFrame:
    """Return the currents at the end of a segment, with the cosine and sine of its angle."""
    return RotorFrame(
        value_at(series.direct, count, 1.0), value_at(series.quadrature, count, 1.0), cosine, sine
    )
