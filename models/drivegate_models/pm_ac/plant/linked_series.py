"""Currents and link voltage between two events as power series, for a link with a capacitor.

The legs' voltages are multiples of the link's, whose current is that of the legs at its upper rail. With the voltage as
a further state the equations stay linear, with the rotor's cosine and sine as coefficients, so the solution is entire.
A coefficient takes one product of series for each coefficient before it.
"""

from __future__ import annotations

from math import sqrt
from typing import Final, NamedTuple

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.machine.rotor_frame import HALF_ROOT, RotorFrame, axis_of, from_phases
from drivegate_models.pm_ac.plant.circuit import UNBOUNDED, Circuit, circuit_of, drop_of, is_on_upper_rail
from drivegate_models.pm_ac.plant.dc_link import LinkState
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.plant.series import (
    CUT,
    LEAST_TERMS,
    LONGEST_HELD,
    TERMS,
    Series,
    product_term,
    term_count,
    turning_series,
)
from drivegate_models.pm_ac.plant.settling import Legs

LONGEST_LINKED: Final = 1.0
"""Maximum segment times the fastest rate, while no leg is held in a salient machine (1)."""
# Share by which the voltage may grow in an advance for the bound of the currents' slopes to be valid.
_GROWTH = 0.05
_NEGLIGIBLE = 1e-18


class Feed(NamedTuple):
    """What acts on the capacitor in a segment, apart from the bridge."""

    source: float
    """Voltage of the source (V)."""
    per_resistance: float
    """Conductance between source and capacitor (S); 0 while the source carries no current."""
    conductance: float
    """Conductance of the chopper and of the losses that the link supplies (S)."""
    per_capacitance: float
    """One over the capacitance (1/F); 0 while the bridge's diodes keep the capacitor at 0 V."""


class Connection(NamedTuple):
    """The voltage of a leg as a function of the link's."""

    upper: float
    """1 if the leg is at the upper rail, otherwise 0."""
    offset: float
    """Voltage from the rail (V)."""


@inlined
def linked_circuit(
    drive: PmAcDrive,
    speed: float,
    voltage: float,
    source: float,
    currents: tuple[float, float],
    conductance: float,
    duration: float,
) -> Circuit:
    """Return the constants of an advance whose link has this voltage (V) at the start.

    `source`: voltage of the source (V). `currents`: d-axis and q-axis currents at the start (A). `conductance`:
    greatest conductance at the capacitor besides the source's (S). `duration`: length of the advance (s). The bound of
    slopes holds for the greatest voltage that the link can reach; it is `UNBOUNDED` if none is known.
    """
    link = drive.dc_link
    direct, quadrature = currents
    top = max(voltage, source)
    reached = top * (1.0 + _GROWTH) + _GROWTH * drive.link_voltage
    bound = circuit_of(drive, speed, reached, direct, quadrature, duration)
    steepest = bound.steepest
    if steepest < UNBOUNDED:
        size = sqrt(direct * direct + quadrature * quadrature) + steepest * duration
        if top + duration * size / link.capacitance > reached:
            steepest = UNBOUNDED
    least = min(drive.direct_inductance, drive.quadrature_inductance)
    exchange = sqrt(1.5 / (least * link.capacitance))
    own = (1.0 / link.source_resistance + conductance) / link.capacitance
    return Circuit(
        bound.resistance,
        bound.direct,
        bound.quadrature,
        bound.flux,
        bound.electrical,
        voltage,
        bound.switch_drop,
        bound.diode_drop,
        bound.turn_on_energy,
        bound.turn_off_energy,
        bound.rate + exchange + own,
        bound.pace,
        steepest,
        bound.bend,
        bound.tie,
        bound.nothing,
    )


@inlined
def at_voltage(circuit: Circuit, voltage: float, bend: float) -> Circuit:
    """Return a circuit with another link voltage (V) and bound of the second derivative of a current (A/s2)."""
    return Circuit(
        circuit.resistance,
        circuit.direct,
        circuit.quadrature,
        circuit.flux,
        circuit.electrical,
        voltage,
        circuit.switch_drop,
        circuit.diode_drop,
        circuit.turn_on_energy,
        circuit.turn_off_energy,
        circuit.rate,
        circuit.pace,
        circuit.steepest,
        bend,
        circuit.tie,
        circuit.nothing,
    )


@inlined
def longest_linked(circuit: Circuit, held: int, duration: float) -> float:
    """Return the maximum length of a segment for fast convergence of its series (s)."""
    share = LONGEST_LINKED
    if 0 <= held <= 2 and circuit.direct != circuit.quadrature:
        ratio = circuit.direct / circuit.quadrature
        share = LONGEST_HELD * sqrt(min(ratio, 1.0 / ratio))
    return share / circuit.rate if circuit.rate * duration > share else duration


@inlined
def connection_of(circuit: Circuit, legs: Legs, leg: int) -> Connection:
    """Return the connection of a leg with a current."""
    sign = legs.signs[leg]
    gate = legs.gates[leg]
    upper = 1.0 if is_on_upper_rail(gate, sign) else 0.0
    return Connection(upper, -sign * drop_of(circuit, gate, sign))


@inlined
def _own_rate(feed: Feed, link: LinkState, k: int) -> float:
    """Return the coefficient of order `k` of the capacitor's current over its capacitance (V/s)."""
    source = feed.source if k == 0 else 0.0
    voltage = link.voltage[k]
    current = (source - voltage) * feed.per_resistance - link.bridge[k] - feed.conductance * voltage
    return float(feed.per_capacitance * current)


@unallocating
def idle_series(circuit: Circuit, feed: Feed, link: LinkState, length: float) -> int:
    """Write the series of the link's voltage while no current flows in the bridge; return the number of terms."""
    count = term_count(circuit.rate * length)
    link.voltage[0] = circuit.link
    link.bridge[0] = 0.0
    for k in range(1, count):
        link.voltage[k] = length / k * _own_rate(feed, link, k - 1)
        link.bridge[k] = 0.0
    return count


@unallocating
def free_linked_series(
    circuit: Circuit,
    feed: Feed,
    legs: Legs,
    series: Series,
    link: LinkState,
    frame: RotorFrame,
    length: float,
) -> int:
    """Write the series of currents and link while no leg is held.

    `series`: receives `direct` and `quadrature`. `link`: receives `voltage` and `bridge`. `length`: length of the
    segment (s). Result: number of coefficients.
    """
    first = connection_of(circuit, legs, 0)
    second = connection_of(circuit, legs, 1)
    third = connection_of(circuit, legs, 2)
    along, across = from_phases(first.upper, second.upper, third.upper)
    drop_a, drop_b = from_phases(first.offset, second.offset, third.offset)
    cosine, sine = frame.cosine, frame.sine
    # The share of the link's voltage along the rotor's axes, and the drops, turn backward.
    switched_d, switched_q = series.cosine, series.sine
    switched_d[0] = cosine * along + sine * across
    switched_q[0] = cosine * across - sine * along
    drop_d = cosine * drop_a + sine * drop_b
    drop_q = cosine * drop_b - sine * drop_a
    electrical = circuit.electrical
    opposed = electrical * circuit.flux
    direct, quadrature = series.direct, series.quadrature
    direct[0] = frame.direct
    quadrature[0] = frame.quadrature
    flux_d = circuit.direct * frame.direct
    flux_q = circuit.quadrature * frame.quadrature
    voltage, bridge = link.voltage, link.bridge
    voltage[0] = circuit.link
    bridge[0] = 1.5 * (switched_d[0] * frame.direct + switched_q[0] * frame.quadrature)
    is_connected = along != 0.0 or across != 0.0
    per_direct = 1.0 / circuit.direct
    per_quadrature = 1.0 / circuit.quadrature
    count = term_count(circuit.rate * length)
    turns = 1
    for k in range(1, count):
        step = length / k
        pushed_d, pushed_q = drop_d, drop_q
        if is_connected:
            for j in range(min(k, turns)):
                pushed_d += switched_d[j] * voltage[k - 1 - j]
                pushed_q += switched_q[j] * voltage[k - 1 - j]
        rate_d = pushed_d - circuit.resistance * direct[k - 1] + electrical * flux_q
        rate_q = pushed_q - circuit.resistance * quadrature[k - 1] - electrical * flux_d - opposed
        opposed = 0.0
        voltage[k] = step * _own_rate(feed, link, k - 1)
        flux_d = step * rate_d
        flux_q = step * rate_q
        direct[k] = flux_d * per_direct
        quadrature[k] = flux_q * per_quadrature
        drop_d, drop_q = step * electrical * drop_q, -step * electrical * drop_d
        drawn = 0.0
        if is_connected:
            switched_d[k] = step * electrical * switched_q[k - 1]
            switched_q[k] = -step * electrical * switched_d[k - 1]
            if turns == k and abs(switched_d[k]) + abs(switched_q[k]) > _NEGLIGIBLE:
                turns = k + 1
            for j in range(turns):
                drawn += switched_d[j] * direct[k - j] + switched_q[j] * quadrature[k - j]
        bridge[k] = 1.5 * drawn
    return count


@inlined
def bend_of(circuit: Circuit, series: Series, count: int, length: float) -> float:
    """Return a bound of the second derivative of any phase current in a segment, from its series (A/s2)."""
    angle = abs(circuit.electrical) * length
    total = 0.0
    for k in range(count):
        size = abs(series.direct[k]) + abs(series.quadrature[k])
        total += size * (k * (k - 1) + angle * (2.0 * k + angle))
    return total / (length * length)


@unallocating
def held_linked_series(
    circuit: Circuit,
    feed: Feed,
    legs: Legs,
    series: Series,
    link: LinkState,
    frame: RotorFrame,
    held: int,
    length: float,
) -> int:
    """Write the series of currents, link and the leg's own voltage while a leg is held at zero current.

    As `series.held_series`, with the voltage between the other two legs as a function of the link's.

    `series`: receives `direct`, `quadrature`, `current` and `holding`. `link`: receives `voltage` and `bridge`. `held`:
    index of the held leg. `length`: length of the segment (s). Result: number of coefficients.
    """
    ahead = connection_of(circuit, legs, (held + 1) % 3)
    behind = connection_of(circuit, legs, (held + 2) % 3)
    rails = ahead.upper - behind.upper
    gain = rails / (2.0 * HALF_ROOT)
    constant = (ahead.offset - behind.offset) / (2.0 * HALF_ROOT)
    cosine, sine = axis_of(frame, held)
    angle = circuit.electrical * length
    mean = 0.5 * (circuit.quadrature + circuit.direct)
    swing = 0.5 * (circuit.quadrature - circuit.direct)
    double_cosine = cosine * cosine - sine * sine
    count = TERMS if swing != 0.0 else term_count(circuit.rate * length)
    cosines, sines = series.cosine, series.sine
    doubles, double_sines = series.direct, series.quadrature
    turning_series(cosines, sines, count, cosine, sine, angle)
    turning_series(doubles, double_sines, count, double_cosine, 2.0 * sine * cosine, 2.0 * angle)
    currents, flux = series.current, series.flux
    voltage, bridge = link.voltage, link.bridge
    inductance = mean + swing * double_cosine
    currents[0] = sine * frame.direct + cosine * frame.quadrature
    flux[0] = inductance * currents[0]
    voltage[0] = circuit.link
    bridge[0] = HALF_ROOT * rails * currents[0]
    emf = circuit.electrical * circuit.flux
    size = 0.0
    used = count
    for k in range(1, count):
        step = length / k
        forced = gain * voltage[k - 1]
        if k == 1:
            forced += constant
        flux[k] = step * (forced - circuit.resistance * currents[k - 1] - emf * cosines[k - 1])
        varied = 0.0
        for n in range(1, k + 1):
            varied += doubles[n] * currents[k - n]
        currents[k] = (flux[k] - swing * varied) / inductance
        voltage[k] = step * _own_rate(feed, link, k - 1)
        bridge[k] = HALF_ROOT * rails * currents[k]
        size += abs(currents[k])
        rest = max(abs(currents[k]), abs(currents[k - 1]))
        is_small = abs(cosines[k]) + abs(sines[k]) <= CUT and abs(voltage[k]) <= CUT * abs(voltage[0])
        if k >= LEAST_TERMS and rest <= CUT * size and is_small:
            used = k + 1
            break
    for k in range(used):
        series.holding[k] = circuit.flux * cosines[k] - swing * product_term(currents, double_sines, k)
    share = 0.5 * (ahead.upper + behind.upper)
    for k in range(used):
        change = 1.5 * (k + 1) * series.holding[k + 1] / length if k < used - 1 else 0.0
        series.holding[k] = change + share * voltage[k]
    series.holding[0] += 0.5 * (ahead.offset + behind.offset)
    for k in range(used):
        series.direct[k] = product_term(currents, sines, k)
        series.quadrature[k] = product_term(currents, cosines, k)
    return used
