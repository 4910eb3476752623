"""The segments of a period of a link with a capacitor: their series, each from the end of the one before."""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivegate_models.compilation.kernels import inlined
from drivegate_models.machine.rotor_frame import RotorFrame, of_phase, phase_current, turned
from drivegate_models.machine.sine import small_cosine_sine
from drivegate_models.pm_ac.plant import dc_link
from drivegate_models.pm_ac.plant.circuit import UNBOUNDED, Circuit
from drivegate_models.pm_ac.plant.dc_link import BATTERY, CHOPPER, SOURCE, VOLTAGE, LinkState
from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.plant.linked_series import CUT, PER_ORDER, Feed
from drivegate_models.pm_ac.plant.polynomial import extremes
from drivegate_models.pm_ac.plant.rows import (
    ACROSS,
    ALONG,
    COSINE,
    DEVIATION,
    LINK_ACROSS,
    LINK_ALONG,
    PHASE_ENDS,
    SERIES_ACROSS,
    SERIES_ALONG,
    SERIES_ORDERS,
    SERIES_VOLTAGE,
    SINE,
    TIME,
    WIDTH,
)
from drivegate_models.pm_ac.plant.series import LEAST_TERMS, Series
from drivegate_models.pm_ac.plant.settling import Legs

LONGEST_QUIET: Final = 0.5
"""Maximum segment times the fastest rate (1): the first term that the series leave out is below 1e-12 there."""
_LEAST_LINK: Final = 0.1
"""Least voltage of the link over its nominal one (1)."""
_TWO_THIRDS: Final = 2.0 / 3.0


class Band(NamedTuple):
    """Voltages of the link between which nothing happens (V)."""

    lowest: float
    highest: float


class Segment(NamedTuple):
    """The end of a segment."""

    along: float
    """Current along the first phase's axis (A)."""
    across: float
    """Current across the first phase's axis (A)."""
    voltage: float
    """Voltage of the link (V)."""
    deviation: float
    """Maximum distance of a phase current from its chord (A)."""
    bulge: float
    """Maximum distance of the voltage from its chord (V)."""
    orders: int
    """Number of coefficients that are not zero (1)."""


class Passed(NamedTuple):
    """The segments before one with a possible event."""

    segments: int
    """Number of these segments (1)."""
    frame: RotorFrame
    """Currents after the last of them."""
    voltage: float
    """Voltage of the link after the last of them (V)."""
    orders: int
    """Greatest number of coefficients of any of them that are not zero (1)."""


@inlined
def band_of(drive: PmAcDrive, link: LinkState, source: float, follows_thresholds: bool) -> Band:
    """Return the voltages of the link between which neither source nor chopper changes."""
    constants = drive.dc_link
    state = link.state
    lowest, highest = _LEAST_LINK * drive.link_voltage, UNBOUNDED
    if constants.source != BATTERY and source > 0.0:
        if state[SOURCE] != 0.0:
            highest = source
        else:
            lowest = max(lowest, source)
    if follows_thresholds and constants.chopper_conductance > 0.0:
        if state[CHOPPER] == 0.0:
            highest = min(highest, constants.chopper_on)
        else:
            lowest = max(lowest, constants.chopper_off)
    return Band(lowest, highest)


@inlined
def _write_series(
    circuit: Circuit,
    feed: Feed,
    frame: RotorFrame,
    voltage: float,
    length: float,
    series: Series,
    rows: NDArray[np.float64],
    n: int,
) -> Segment:
    """Write the series of currents and voltage in a segment, as `linked_series.free_linked_series` does."""
    along, across = _TWO_THIRDS * rows[LINK_ALONG + n], _TWO_THIRDS * rows[LINK_ACROSS + n]
    # The devices' drops, without the link's voltage at the start of the period.
    pushed_a = rows[ALONG + n] - circuit.link * along
    pushed_b = rows[ACROSS + n] - circuit.link * across
    current_a, current_b = turned(frame, frame.direct, frame.quadrature)
    rows[SERIES_ALONG + n], rows[SERIES_ACROSS + n], rows[SERIES_VOLTAGE + n] = current_a, current_b, voltage
    end_a, end_b, end_v = current_a, current_b, voltage
    angle = circuit.electrical * length
    magnet_a, magnet_b = circuit.flux * frame.cosine, circuit.flux * frame.sine
    per_direct, per_quadrature = 1.0 / circuit.direct, 1.0 / circuit.quadrature
    mean, swing = 0.5 * (per_direct + per_quadrature), 0.5 * (per_direct - per_quadrature)
    turns = 1
    if swing != 0.0:
        series.flux[0], series.current[0] = turned(
            frame, circuit.direct * frame.direct, circuit.quadrature * frame.quadrature
        )
        series.cosine[0] = frame.cosine * frame.cosine - frame.sine * frame.sine
        series.sine[0] = 2.0 * frame.sine * frame.cosine
    source = feed.source
    bend = bulge = 0.0
    size, begin = abs(current_a) + abs(current_b), abs(voltage)
    orders = SERIES_ORDERS
    for k in range(1, SERIES_ORDERS):
        step = length * PER_ORDER[k]
        turned_by = angle * PER_ORDER[k]
        magnet_a, magnet_b = -turned_by * magnet_b, turned_by * magnet_a
        flux_a = step * (pushed_a + along * voltage - circuit.resistance * current_a) - magnet_a
        flux_b = step * (pushed_b + across * voltage - circuit.resistance * current_b) - magnet_b
        pushed_a = pushed_b = 0.0
        bridge = 1.5 * (along * current_a + across * current_b)
        charging = (source - voltage) * feed.per_resistance - feed.conductance * voltage - bridge
        source = 0.0
        voltage = step * feed.per_capacitance * charging
        current_a = mean * flux_a
        current_b = mean * flux_b
        if swing != 0.0:
            series.flux[k] = flux_a
            series.current[k] = flux_b
            series.cosine[k] = -2.0 * turned_by * series.sine[k - 1]
            series.sine[k] = 2.0 * turned_by * series.cosine[k - 1]
            if turns == k and abs(swing) * (abs(series.cosine[k]) + abs(series.sine[k])) > CUT * mean:
                turns = k + 1
            varied_a = varied_b = 0.0
            for j in range(turns):
                varied_a += series.cosine[j] * series.flux[k - j] + series.sine[j] * series.current[k - j]
                varied_b += series.sine[j] * series.flux[k - j] - series.cosine[j] * series.current[k - j]
            current_a += swing * varied_a
            current_b += swing * varied_b
        rows[SERIES_ALONG + k * WIDTH + n] = current_a
        rows[SERIES_ACROSS + k * WIDTH + n] = current_b
        rows[SERIES_VOLTAGE + k * WIDTH + n] = voltage
        end_a += current_a
        end_b += current_b
        end_v += voltage
        curved = 0.125 * k * (k - 1)
        term = abs(current_a) + abs(current_b)
        size += term
        bend += curved * term
        bulge += curved * abs(voltage)
        least = CUT * size
        is_small = term <= least and mean * (abs(magnet_a) + abs(magnet_b)) <= least
        if is_small and abs(voltage) <= CUT * begin and turns <= k and k >= LEAST_TERMS:
            orders = k + 1
            break
    for k in range(orders, SERIES_ORDERS):
        rows[SERIES_ALONG + k * WIDTH + n] = 0.0
        rows[SERIES_ACROSS + k * WIDTH + n] = 0.0
        rows[SERIES_VOLTAGE + k * WIDTH + n] = 0.0
    return Segment(end_a, end_b, end_v, bend, bulge, orders)


@inlined
def _extend_range(
    link: LinkState, series: Series, rows: NDArray[np.float64], n: int, begin: float, end: Segment
) -> None:
    """Extend the range of the link's voltage by that of a segment."""
    totals = link.totals
    lowest, highest = min(begin, end.voltage), max(begin, end.voltage)
    if highest - lowest <= 8.0 * end.bulge and (
        highest + end.bulge > totals[dc_link.HIGHEST] or lowest - end.bulge < totals[dc_link.LOWEST]
    ):
        for k in range(SERIES_ORDERS):
            series.other[k] = rows[SERIES_VOLTAGE + k * WIDTH + n]
        lowest, highest = extremes(series.other, SERIES_ORDERS, series.slopes)
    totals[dc_link.HIGHEST] = max(totals[dc_link.HIGHEST], highest)
    totals[dc_link.LOWEST] = min(totals[dc_link.LOWEST], lowest)


@inlined
def keeps_sign(sign: int, begin: float, end: float, deviation: float) -> bool:
    """Return True if a current keeps a sign in a segment, from its ends and its maximum distance from the chord (A)."""
    least = min(sign * begin, sign * end)
    is_monotone = abs(end - begin) > 8.0 * deviation
    return least > deviation or (is_monotone and least >= 0.0)


@inlined
def propagate_linked(
    circuit: Circuit,
    feed: Feed,
    legs: Legs,
    link: LinkState,
    series: Series,
    frame: RotorFrame,
    band: Band,
    count: int,
    rows: NDArray[np.float64],
) -> Passed:
    """Write the series of the segments before one with a possible event."""
    voltage = link.state[VOLTAGE]
    begin = frame
    orders = 0
    for leg in range(3):
        rows[PHASE_ENDS + leg * WIDTH] = phase_current(frame, leg)
    for n in range(count):
        length = rows[TIME + 1 + n] - rows[TIME + n]
        if circuit.rate * length > LONGEST_QUIET:
            return Passed(n, frame, voltage, orders)
        rows[COSINE + n], rows[SINE + n] = frame.cosine, frame.sine
        end = _write_series(circuit, feed, frame, voltage, length, series, rows, n)
        deviation = end.deviation
        rows[DEVIATION + n] = deviation
        for leg in range(3):
            before = rows[PHASE_ENDS + leg * WIDTH + n]
            current = of_phase(leg, end.along, end.across)
            rows[PHASE_ENDS + leg * WIDTH + n + 1] = current
            if legs.sure[leg] == 0 and not keeps_sign(legs.signs[leg], before, current, deviation):
                return Passed(n, frame, voltage, orders)
        if min(voltage, end.voltage) - end.bulge <= band.lowest:
            return Passed(n, frame, voltage, orders)
        if max(voltage, end.voltage) + end.bulge >= band.highest:
            return Passed(n, frame, voltage, orders)
        _extend_range(link, series, rows, n, voltage, end)
        orders = max(orders, end.orders)
        voltage = end.voltage
        by_cosine, by_sine = small_cosine_sine(circuit.electrical * (rows[TIME + 1 + n] - rows[TIME]))
        cosine, sine = turned(begin, by_cosine, by_sine)
        frame = RotorFrame(
            cosine * end.along + sine * end.across, cosine * end.across - sine * end.along, cosine, sine
        )
    return Passed(count, frame, voltage, orders)
