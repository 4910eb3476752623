"""Currents and link voltage between two events as power series, for a link with a capacitor.

The legs' voltages are multiples of the link's, whose current is that of the legs at its upper rail. With the voltage as
a further state the equations stay linear, so the solution is entire. The currents are in the stationary frame, in which
a leg's voltage has a constant direction. There only a salient machine has coefficients that vary: cosine and sine of
twice the rotor's angle.
"""

from __future__ import annotations

from math import sqrt
from typing import Final, NamedTuple

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.machine.rotor_frame import HALF_ROOT, RotorFrame, axis_of, from_phases, turned
from drivegate_models.pm_ac.plant.circuit import UNBOUNDED, Circuit, circuit_of, drop_of, is_on_upper_rail
from drivegate_models.pm_ac.plant.dc_link import CURRENT, DcLink, LinkState
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.plant.polynomial import value_at
from drivegate_models.pm_ac.plant.series import (
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
# Coefficient over the size of its series from which on the rest is negligible: a hundredth of what counts as an event.
CUT = 1e-15
PER_ORDER = (0.0, *(1.0 / order for order in range(1, TERMS)))


class Feed(NamedTuple):
    """What acts on the capacitor in a segment, apart from the bridge."""

    source: float
    """Voltage of the source (V)."""
    per_resistance: float
    """Conductance between source and capacitor (S); 0 while the source carries no current, or has an inductance."""
    conductance: float
    """Conductance of the chopper and of the losses that the link supplies (S)."""
    per_capacitance: float
    """One over the capacitance (1/F); 0 while the bridge's diodes keep the capacitor at 0 V."""
    per_inductance: float
    """One over the inductance of the source (1/H); 0 while it carries no current, or has none."""
    resistance: float
    """Resistance of the source (ohm)."""


class Connection(NamedTuple):
    """The voltage of a leg as a function of the link's."""

    upper: float
    """1 if the leg is at the upper rail, otherwise 0."""
    offset: float
    """Voltage from the rail (V)."""


@inlined
def rate_of_source(link: DcLink) -> float:
    """Return the fastest rate of capacitor and source, for a source with an inductance (1/s)."""
    inductance = link.source_inductance
    return 1.0 / sqrt(inductance * link.capacitance) + link.source_resistance / inductance


@inlined
def linked_circuit(
    drive: PmAcDrive,
    speed: float,
    voltage: float,
    source: float,
    supplied: float,
    currents: tuple[float, float],
    conductance: float,
    duration: float,
) -> Circuit:
    """Return the constants of an advance whose link has this voltage (V) at the start.

    `source`: voltage of the source (V). `supplied`: its current at the start, if it has an inductance (A). `currents`:
    d-axis and q-axis currents at the start (A). `conductance`: greatest conductance at the capacitor besides the
    source's (S). `duration`: length of the advance (s). The bound of slopes holds for the greatest voltage that the
    link can reach; it is `UNBOUNDED` if none is known.
    """
    link = drive.dc_link
    direct, quadrature = currents
    top = max(voltage, source)
    drained = 0.0
    own = (1.0 / link.source_resistance + conductance) / link.capacitance
    if link.source_inductance > 0.0:
        own = rate_of_source(link) + conductance / link.capacitance
        # The energy in the oscillation about the source's voltage grows only by what bridge and losses take.
        apart = voltage - source
        top = source + sqrt(apart * apart + link.source_inductance / link.capacitance * supplied * supplied)
        drained = conductance * source
    reached = top * (1.0 + _GROWTH) + _GROWTH * drive.link_voltage
    bound = circuit_of(drive, speed, reached, direct, quadrature, duration)
    steepest = bound.steepest
    if steepest < UNBOUNDED:
        size = sqrt(direct * direct + quadrature * quadrature) + steepest * duration
        if top + duration * (size + drained) / link.capacitance > reached:
            steepest = UNBOUNDED
    least = min(drive.direct_inductance, drive.quadrature_inductance)
    exchange = sqrt(1.5 / (least * link.capacitance))
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
    supplied = (source - voltage) * feed.per_resistance if feed.per_inductance == 0.0 else link.source[k]
    current = supplied - link.bridge[k] - feed.conductance * voltage
    return float(feed.per_capacitance * current)


@inlined
def _begin_link(circuit: Circuit, link: LinkState, bridge: float) -> None:
    """Begin the series of the link, with the current into the bridge at the start (A)."""
    link.voltage[0] = circuit.link
    link.bridge[0] = bridge
    link.source[0] = link.state[CURRENT]


@inlined
def _extend_link(feed: Feed, link: LinkState, step: float, k: int) -> None:
    """Write the coefficients of order `k` of voltage and source, from those before; `step`: length over `k` (s)."""
    link.voltage[k] = step * _own_rate(feed, link, k - 1)
    if feed.per_inductance != 0.0:
        source = feed.source if k == 1 else 0.0
        driving = source - link.voltage[k - 1] - feed.resistance * link.source[k - 1]
        link.source[k] = step * feed.per_inductance * driving


@inlined
def _is_link_small(feed: Feed, link: LinkState, size: float, k: int) -> bool:
    """Return True if the coefficients of order `k` of the link are negligible; `size`: that of the currents (A)."""
    if abs(link.voltage[k]) > CUT * abs(link.voltage[0]):
        return False
    return feed.per_inductance == 0.0 or abs(link.source[k]) <= CUT * (size + abs(link.source[0]))


@unallocating
def idle_series(circuit: Circuit, feed: Feed, link: LinkState, length: float) -> int:
    """Write the series of the link's voltage while no current flows in the bridge; return the number of terms."""
    count = term_count(circuit.rate * length)
    _begin_link(circuit, link, 0.0)
    for k in range(1, count):
        _extend_link(feed, link, length / k, k)
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

    `series`: receives the currents along and across the first phase's axis as `direct` and `quadrature`. `link`:
    receives `voltage` and `bridge`. `length`: length of the segment (s). Result: number of coefficients.
    """
    first = connection_of(circuit, legs, 0)
    second = connection_of(circuit, legs, 1)
    third = connection_of(circuit, legs, 2)
    along, across = from_phases(first.upper, second.upper, third.upper)
    pushed_a, pushed_b = from_phases(first.offset, second.offset, third.offset)
    current_a, current_b = turned(frame, frame.direct, frame.quadrature)
    voltage, bridge = link.voltage, link.bridge
    _begin_link(circuit, link, 1.5 * (along * current_a + across * current_b))
    series.direct[0] = current_a
    series.quadrature[0] = current_b
    angle = circuit.electrical * length
    magnet_a, magnet_b = circuit.flux * frame.cosine, circuit.flux * frame.sine
    per_direct, per_quadrature = 1.0 / circuit.direct, 1.0 / circuit.quadrature
    mean, swing = 0.5 * (per_direct + per_quadrature), 0.5 * (per_direct - per_quadrature)
    # Flux linkage of the currents, and cosine and sine of twice the angle, for a machine with saliency.
    fluxes_a, fluxes_b = series.flux, series.current
    fluxes_a[0], fluxes_b[0] = turned(
        frame, circuit.direct * frame.direct, circuit.quadrature * frame.quadrature
    )
    doubles, double_sines = series.cosine, series.sine
    doubles[0] = frame.cosine * frame.cosine - frame.sine * frame.sine
    double_sines[0] = 2.0 * frame.sine * frame.cosine
    turns = 1
    size = abs(current_a) + abs(current_b)
    for k in range(1, TERMS):
        step = length * PER_ORDER[k]
        pushed_a += along * voltage[k - 1] - circuit.resistance * current_a
        pushed_b += across * voltage[k - 1] - circuit.resistance * current_b
        turned_by = angle * PER_ORDER[k]
        magnet_a, magnet_b = -turned_by * magnet_b, turned_by * magnet_a
        flux_a = step * pushed_a - magnet_a
        flux_b = step * pushed_b - magnet_b
        pushed_a = pushed_b = 0.0
        current_a = mean * flux_a
        current_b = mean * flux_b
        if swing != 0.0:
            fluxes_a[k] = flux_a
            fluxes_b[k] = flux_b
            doubles[k] = -2.0 * turned_by * double_sines[k - 1]
            double_sines[k] = 2.0 * turned_by * doubles[k - 1]
            if turns == k and abs(swing) * (abs(doubles[k]) + abs(double_sines[k])) > CUT * mean:
                turns = k + 1
            varied_a = varied_b = 0.0
            for j in range(turns):
                varied_a += doubles[j] * fluxes_a[k - j] + double_sines[j] * fluxes_b[k - j]
                varied_b += double_sines[j] * fluxes_a[k - j] - doubles[j] * fluxes_b[k - j]
            current_a += swing * varied_a
            current_b += swing * varied_b
        series.direct[k] = current_a
        series.quadrature[k] = current_b
        _extend_link(feed, link, step, k)
        bridge[k] = 1.5 * (along * current_a + across * current_b)
        term = abs(current_a) + abs(current_b)
        size += term
        is_small = (
            term <= CUT * size
            and _is_link_small(feed, link, size, k)
            and mean * (abs(magnet_a) + abs(magnet_b)) <= CUT * size
            and turns <= k
        )
        if is_small and k >= LEAST_TERMS:
            return k + 1
    return TERMS


@inlined
def bend_of(series: Series, count: int, length: float) -> float:
    """Return a bound of the second derivative of any phase current in a segment, from its series (A/s2)."""
    total = 0.0
    for k in range(2, count):
        total += k * (k - 1) * (abs(series.direct[k]) + abs(series.quadrature[k]))
    return total / (length * length)


@inlined
def linked_end(series: Series, count: int, cosine: float, sine: float) -> RotorFrame:
    """Return the currents at the end of a segment, with the cosine and sine of its angle."""
    along = value_at(series.direct, count, 1.0)
    across = value_at(series.quadrature, count, 1.0)
    return RotorFrame(cosine * along + sine * across, cosine * across - sine * along, cosine, sine)


@unallocating
def turn_into_rotor_frame(
    circuit: Circuit, series: Series, frame: RotorFrame, count: int, length: float
) -> None:
    """Replace the series of the currents in the stationary frame by those in the rotor frame.

    `frame`: at the start of the segment. `count`: number of coefficients. `length`: length of the segment (s).
    """
    turning_series(series.cosine, series.sine, count, frame.cosine, frame.sine, circuit.electrical * length)
    for k in range(count - 1, -1, -1):
        direct = product_term(series.cosine, series.direct, k) + product_term(
            series.sine, series.quadrature, k
        )
        series.quadrature[k] = product_term(series.cosine, series.quadrature, k) - product_term(
            series.sine, series.direct, k
        )
        series.direct[k] = direct


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

    `series`: receives `current`, `holding`, and the currents along and across the first phase's axis as `direct` and
    `quadrature`. `link`: receives `voltage` and `bridge`. `held`:
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
    if swing != 0.0:
        turning_series(doubles, double_sines, count, double_cosine, 2.0 * sine * cosine, 2.0 * angle)
    currents, flux = series.current, series.flux
    voltage, bridge = link.voltage, link.bridge
    inductance = mean + swing * double_cosine
    per_inductance = 1.0 / inductance
    currents[0] = sine * frame.direct + cosine * frame.quadrature
    flux[0] = inductance * currents[0]
    _begin_link(circuit, link, HALF_ROOT * rails * currents[0])
    emf = circuit.electrical * circuit.flux
    size = 0.0
    used = count
    for k in range(1, count):
        step = length * PER_ORDER[k]
        forced = gain * voltage[k - 1]
        if k == 1:
            forced += constant
        flux[k] = step * (forced - circuit.resistance * currents[k - 1] - emf * cosines[k - 1])
        varied = 0.0
        if swing != 0.0:
            for n in range(1, k + 1):
                varied += doubles[n] * currents[k - n]
        currents[k] = (flux[k] - swing * varied) * per_inductance
        _extend_link(feed, link, step, k)
        bridge[k] = HALF_ROOT * rails * currents[k]
        size += abs(currents[k])
        rest = max(abs(currents[k]), abs(currents[k - 1]))
        is_small = abs(cosines[k]) + abs(sines[k]) <= CUT and _is_link_small(feed, link, size, k)
        if k >= LEAST_TERMS and rest <= CUT * size and is_small:
            used = k + 1
            break
    for k in range(used):
        series.holding[k] = circuit.flux * cosines[k]
        if swing != 0.0:
            series.holding[k] -= swing * product_term(currents, double_sines, k)
    share = 0.5 * (ahead.upper + behind.upper)
    for k in range(used):
        change = 1.5 * (k + 1) * series.holding[k + 1] / length if k < used - 1 else 0.0
        series.holding[k] = change + share * voltage[k]
    series.holding[0] += 0.5 * (ahead.offset + behind.offset)
    # The current between the other two legs is across the axis of the held one.
    across, along = axis_of(RotorFrame(0.0, 0.0, 1.0, 0.0), held)
    for k in range(used):
        series.direct[k] = along * currents[k]
        series.quadrature[k] = across * currents[k]
    return used
