"""Events that end a segment: a current reaches zero, or the voltage of a held leg that of a diode or a switch."""

from __future__ import annotations

from typing import Final, NamedTuple

from drivegate_models.compilation.kernels import inlined, unallocating
from drivegate_models.machine.rotor_frame import RotorFrame, axis_of, phase_current
from drivegate_models.pm_ac.plant.circuit import Circuit, sagitta
from drivegate_models.pm_ac.plant.polynomial import NOWHERE, first_fall, size_of
from drivegate_models.pm_ac.plant.series import Series, phase_series, standing_phase_series, turning_series
from drivegate_models.pm_ac.plant.settling import Legs, is_relay

NOTHING: Final = 0
"""The segment has its maximum length."""
ZERO: Final = 1
"""The current of a leg reaches zero."""
RELEASE: Final = 2
"""A held leg begins to conduct."""
LAST_ZERO: Final = 3
"""The only current reaches zero."""
ONSET: Final = 4
"""The first current begins."""

SLACK: Final = 1e-13
"""Distance beyond a level that is an event, relative to the scale in the segment; it prevents repeated ties."""
BEYOND: Final = 2.0


class Event(NamedTuple):
    """The first event of a segment."""

    kind: int
    """`NOTHING`, `ZERO`, `RELEASE`, `LAST_ZERO` or `ONSET`."""
    share: float
    """Time of the event, as a share of the segment's length (1)."""
    leg: int
    """Leg with the current, or -1."""
    sign: int
    """Sign of the current before a zero, or after a release."""


@unallocating
def zero_of_current(
    circuit: Circuit,
    legs: Legs,
    series: Series,
    frame: RotorFrame,
    after: RotorFrame,
    count: int,
    length: float,
    is_standing: bool,
) -> Event:
    """Return the first event at which a current reaches zero while no leg is held.

    `count`: number of coefficients. `length`: length of the segment (s). `is_standing`: True for series of the currents
    in the stationary frame.
    """
    first = Event(NOTHING, 1.0, -1, 0)
    size = -1.0
    deviation = sagitta(circuit, length)
    for leg in range(3):
        if legs.sure[leg] != 0 or not is_relay(legs, leg):
            continue
        sign = legs.signs[leg]
        if min(sign * phase_current(frame, leg), sign * phase_current(after, leg)) > deviation:
            continue
        if size < 0.0:
            size = size_of(series.direct, count) + size_of(series.quadrature, count)
        if is_standing:
            standing_phase_series(series, leg, count)
        else:
            phase_series(circuit, series, frame, leg, count, length)
        share = first_fall(series.other, count, float(sign), 0.0, SLACK * size)
        if share < first.share or (share <= 1.0 and first.leg < 0):
            first = Event(ZERO, share, leg, sign)
    return first


@inlined
def last_zero(legs: Legs, series: Series, held: int, count: int) -> Event:
    """Return the event at which the current of the two other legs ends while one is held: `LAST_ZERO` or `NOTHING`."""
    first = Event(NOTHING, 1.0, -1, 0)
    ahead = (held + 1) % 3
    behind = (held + 2) % 3
    sign = 0
    if is_relay(legs, ahead):
        sign = legs.signs[ahead]
    elif is_relay(legs, behind):
        sign = -legs.signs[behind]
    if sign != 0:
        slack = SLACK * size_of(series.current, count)
        share = first_fall(series.current, count, float(sign), 0.0, slack) if slack > 0.0 else NOWHERE
        if share <= 1.0:
            first = Event(LAST_ZERO, share, -1, 0)
    return first


@unallocating
def end_of_hold(legs: Legs, series: Series, held: int, count: int) -> Event:
    """Return the first event in a segment in which a leg is held.

    `series`: series of the currents and of the held leg's voltage in the segment. `held`: index of the held leg.
    `count`: number of coefficients. Result: `RELEASE`, `LAST_ZERO` or `NOTHING`.
    """
    first = last_zero(legs, series, held, count)
    level = series.holding[0]
    scale = SLACK * (size_of(series.holding, count) + abs(legs.low[held]) + abs(legs.high[held]))
    for side in (-1, 1):
        series.holding[0] = level - (legs.high[held] if side < 0 else legs.low[held])
        share = first_fall(series.holding, count, float(side), 0.0, scale)
        if share < first.share or (share <= 1.0 and first.kind == NOTHING):
            # Above `high` the current becomes negative.
            first = Event(RELEASE, share, held, side)
    series.holding[0] = level
    return first


@inlined
def emf_series(circuit: Circuit, series: Series, first: int, second: int, count: int) -> None:
    """Write the series of the difference of two phases' back-EMFs (V), from the series of the rotor's rotation."""
    cosine_a, sine_a = axis_of(RotorFrame(0.0, 0.0, 1.0, 0.0), first)
    cosine_b, sine_b = axis_of(RotorFrame(0.0, 0.0, 1.0, 0.0), second)
    peak = circuit.electrical * circuit.flux
    for k in range(count):
        # The sine of theta plus each phase's own angle.
        series.other[k] = -peak * (
            series.sine[k] * (cosine_a - cosine_b) + series.cosine[k] * (sine_a - sine_b)
        )


@unallocating
def begin_of_current(
    circuit: Circuit, legs: Legs, series: Series, frame: RotorFrame, count: int, length: float
) -> Event:
    """Return the event at which the first current begins while none flows.

    `count`: number of coefficients. `length`: length of the segment (s). Result: `ONSET` or `NOTHING`.
    """
    first = Event(NOTHING, 1.0, -1, 0)
    turning_series(series.cosine, series.sine, count, frame.cosine, frame.sine, circuit.electrical * length)
    for j in range(3):
        for k in range(3):
            if j == k:
                continue
            # Current would begin to flow out of leg j and back into leg k.
            emf_series(circuit, series, j, k, count)
            series.other[0] += legs.high[k] - legs.low[j]
            # Use a larger distance than for a tie, so that the current does begin.
            slack = BEYOND * circuit.tie
            share = first_fall(series.other, count, 1.0, 0.0, slack) if slack > 0.0 else NOWHERE
            if share < first.share or (share <= 1.0 and first.kind == NOTHING):
                first = Event(ONSET, share, -1, 0)
    return first
