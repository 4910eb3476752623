"""The plant against a second simulation that shares no code with it.

The second one is written from the plant's description alone: a state machine in plain Python, the differential
equation of each of its modes integrated numerically (DOP853), and every switching instant found as a root of
the integrated current. The integrals are carried along as further states.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from scipy.integrate import OdeSolution, solve_ivp
from scipy.optimize import minimize_scalar

from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.half_bridge.plant.phases import make_phases
from drivegate_models.steady.steady_state import KEPT_TIME, SteadyState, cycles_from_rest

AGREEMENT = 1e-10
"""Greatest difference from the integrated means, relative to the scale of each."""

ON, OFF, SLIDE, FLOAT = "on", "off", "slide", "float"
CURRENT, MAGNITUDE, SQUARE, SHAPE_CURRENT, ENERGY, CORE, DRAG = range(7)


@dataclass(frozen=True)
class Point:
    """One operating point, from rest at angle 0."""

    rpm: float
    advance_deg: float
    reference: float
    band: float
    phases: int = 1
    cycles: int = 3
    conductance: float = 3e-3
    flat_deg: float = 98.0
    window_deg: float = 144.0
    resistance: float = 0.08

    def __str__(self) -> str:
        return f"{self.rpm:g}rpm-{self.advance_deg:g}deg-{self.reference:g}A-h{self.band:g}-m{self.phases}"


@dataclass
class Leg:
    """One phase on its leg: what it remembers between events, and what has been integrated so far."""

    drive: Drive
    point: Point
    lag: float
    state: np.ndarray = field(default_factory=lambda: np.zeros(7))
    latch: bool = True
    leaving: str = ""
    rectifying: int = 0
    turned: bool = False
    pieces: list[tuple[float, float, OdeSolution]] = field(default_factory=list)

    @property
    def electrical(self) -> float:
        return self.drive.pole_pairs * self.point.rpm * math.pi / 30.0

    @property
    def peak_emf(self) -> float:
        return self.drive.emf_constant * self.point.rpm * math.pi / 30.0

    def shape(self, time: float) -> float:
        """Trapezoid: a triangle wave of slope one, cut off at its ramps' width."""
        position = (self.electrical * time - self.lag + 0.5 * math.pi) % (2.0 * math.pi)
        triangle = 0.5 * math.pi - abs(position - math.pi)
        ramp = 0.5 * (math.pi - math.radians(self.point.flat_deg))
        return max(-1.0, min(1.0, triangle / ramp))

    def window(self, time: float) -> int:
        centre = (self.electrical * time - self.lag + math.radians(self.point.advance_deg)) % (2.0 * math.pi)
        half = 0.5 * math.radians(self.point.window_deg)
        if abs(centre - 0.5 * math.pi) < half:
            return 1
        return -1 if abs(centre - 1.5 * math.pi) < half else 0

    def boundaries(self, end: float) -> list[float]:
        """Times of the corners of the shape and of the edges of the windows."""
        ramp = 0.5 * (math.pi - math.radians(self.point.flat_deg))
        half = 0.5 * math.radians(self.point.window_deg)
        advance = math.radians(self.point.advance_deg)
        angles = [ramp, math.pi - ramp, 0.5 * math.pi - half - advance, 0.5 * math.pi + half - advance]
        turns = range(-4, 2 * self.point.cycles + 4)
        times = {(angle + turn * math.pi + self.lag) / self.electrical for angle in angles for turn in turns}
        cycle = 2.0 * math.pi / self.electrical
        times |= {cycle * k for k in range(1, self.point.cycles)} | {end}
        return sorted(time for time in times if 0.0 < time <= end)


def _mode(leg: Leg, sector: int, time: float) -> tuple[str, float]:
    """Return the mode and the terminal voltage in it (unused while sliding or floating)."""
    supply, band, reference = leg.drive.half_supply_voltage, leg.point.band, leg.point.reference
    current, emf = leg.state[CURRENT], leg.peak_emf * leg.shape(time)
    along = sector * current
    leaving, leg.leaving = leg.leaving, ""
    if sector != 0 and reference > 0.0:
        if band > 0.0:
            if along >= reference + band:
                leg.latch = False
            elif along <= max(reference - band, 0.0):
                leg.latch = True
        elif along != reference:
            leg.latch = along < reference
        else:
            needed = sector * emf + leg.drive.resistance * reference
            if leaving == "" and abs(needed) <= supply:
                return SLIDE, 0.0
            leg.latch = leaving == ON or (leaving == "" and needed > supply)
        if leg.latch:
            return ON, sector * supply
    if current != 0.0:
        return OFF, -math.copysign(supply, current)
    if leg.rectifying != 0 or abs(emf) > supply:
        return OFF, math.copysign(supply, leg.rectifying or emf)
    return FLOAT, 0.0


def _equations(
    leg: Leg, mode: str, voltage: float, side: float
) -> Callable[[float, np.ndarray], list[float]]:
    drive, reference = leg.drive, leg.point.reference
    supply, resistance, inductance, peak = (
        drive.half_supply_voltage,
        drive.resistance,
        drive.inductance,
        leg.peak_emf,
    )

    def flowing(time: float, state: np.ndarray) -> list[float]:
        current = float(state[0])
        shape = leg.shape(time)
        gap = voltage - resistance * current
        slope = (gap - peak * shape) / inductance
        return [slope, side * current, current * current, shape * current, voltage * current, gap * gap, 0.0]

    def sliding(time: float, state: np.ndarray) -> list[float]:
        current = float(state[0])
        shape = leg.shape(time)
        terminal = peak * shape + resistance * current
        # The limit of a vanishing band: the share of time on either rail gives the mean terminal voltage.
        share = 0.5 * (1.0 + terminal / supply)
        core = (
            share * (supply - resistance * current) ** 2
            + (1.0 - share) * (supply + resistance * current) ** 2
        )
        return [0.0, reference, current * current, shape * current, terminal * current, core, 0.0]

    def floating(time: float, state: np.ndarray) -> list[float]:
        return [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, (peak * leg.shape(time)) ** 2]

    return {ON: flowing, OFF: flowing, SLIDE: sliding, FLOAT: floating}[mode]


Event = tuple[str, Callable[[float, np.ndarray], float], int]


def _events(leg: Leg, mode: str, voltage: float, sector: int, side: float) -> Iterator[Event]:
    """Yield name, function and direction of everything that can end a mode before the next boundary."""
    drive, point = leg.drive, leg.point
    supply, peak = drive.half_supply_voltage, leg.peak_emf
    if mode == FLOAT:
        yield "rectify", lambda time, state: peak * leg.shape(time) - supply, 1
        yield "rectify", lambda time, state: peak * leg.shape(time) + supply, -1
        return
    if mode == SLIDE:
        needed = drive.resistance * point.reference
        yield ON, lambda time, state: sector * peak * leg.shape(time) + needed - supply, 1
        yield OFF, lambda time, state: sector * peak * leg.shape(time) + needed + supply, -1
        return
    if leg.state[CURRENT] != 0.0:
        yield "zero", lambda time, state: state[0], -int(side)
    if mode == ON:
        upper = point.reference + point.band
        yield "off", lambda time, state: sector * state[0] - upper, 1
    elif sector != 0 and point.reference > 0.0 and sector * side > 0.0:
        lower = max(point.reference - point.band, 0.0)
        if lower > 0.0:
            yield "on", lambda time, state: sector * state[0] - lower, -1
    if not leg.turned:
        yield "turn", lambda time, state: voltage - drive.resistance * state[0] - peak * leg.shape(time), 0


def _solved(
    equations: Callable[[float, np.ndarray], list[float]],
    time: float,
    end: float,
    state: np.ndarray,
    events: list[Event],
) -> tuple[Any, str]:
    """Integrate to the end or to the first event; return the solution and that event's name."""
    functions = []
    for _, function, direction in events:
        function.terminal, function.direction = True, direction  # type: ignore[attr-defined]
        functions.append(function)
    solution = solve_ivp(
        equations,
        (time, end),
        state,
        method="DOP853",
        rtol=1e-12,
        atol=1e-14,
        first_step=end - time,
        dense_output=True,
        events=functions,
    )
    assert solution.success, solution.message
    assert solution.t[-1] > time, f"the integration is stuck at {time!r} s"
    if solution.status == 0:
        return solution, ""
    fired = zip(events, solution.t_events, strict=True)
    return solution, next(event[0] for event, times in fired if times.size)


def _advance(leg: Leg, time: float, end: float, sector: int) -> float:
    """Integrate one mode until it ends and return when it did."""
    mode, voltage = _mode(leg, sector, time)
    current = leg.state[CURRENT]
    gap = voltage - leg.peak_emf * leg.shape(time)
    side = math.copysign(1.0, current if current != 0.0 else (-leg.rectifying or gap))
    leg.rectifying = 0
    events = list(_events(leg, mode, voltage, sector, side))
    equations = _equations(leg, mode, voltage, side)
    solution, name = _solved(equations, time, end, leg.state, events)
    if name == "turn":
        # Up to its turning point the current is monotone, so that no pair of crossings can hide in one step.
        events = [event for event in events if event[0] != "turn"]
        solution, name = _solved(equations, time, float(solution.t[-1]), leg.state, events)
        name = name or "turn"
    stop = float(solution.t[-1])
    leg.pieces.append((time, stop, solution.sol))
    leg.state = solution.y[:, -1].copy()
    leg.turned = name == "turn"
    if name not in ("", "turn"):
        if name == "zero":
            leg.state[CURRENT] = 0.0
        elif name == "rectify":
            leg.rectifying = 1 if leg.shape(stop) > 0.0 else -1
            leg.turned = True
        elif mode == SLIDE:
            leg.leaving = name
            leg.turned = True
        else:
            leg.latch = name == "on"
            edge = max(leg.point.reference - leg.point.band, 0.0)
            leg.state[CURRENT] = sector * (edge if leg.latch else leg.point.reference + leg.point.band)
    return stop


def _simulate(leg: Leg) -> np.ndarray:
    """Integrate all cycles and return what the integrals grew by in the last one."""
    cycle = 2.0 * math.pi / leg.electrical
    last = cycle * (leg.point.cycles - 1)
    time, sector, before = 0.0, 0, np.zeros(7)
    for boundary in leg.boundaries(cycle * leg.point.cycles):
        following = leg.window(0.5 * (time + boundary))
        if following != sector and following != 0:
            leg.latch = True
        sector = following
        while time < boundary:
            time = _advance(leg, time, boundary, sector)
        if boundary == last:
            before = leg.state.copy()
            leg.pieces.clear()
    return leg.state - before


def _torque(legs: list[Leg], pieces: list[OdeSolution], times: np.ndarray) -> np.ndarray:
    total = np.zeros(times.size)
    for leg, piece in zip(legs, pieces, strict=True):
        shapes = np.array([leg.shape(time) for time in times])
        total += leg.drive.emf_constant * shapes * piece(times)[CURRENT]
    return total


def _torque_range(legs: list[Leg]) -> tuple[float, float]:
    """Return the extremes of the torque over the last cycle, refined between samples."""
    instants = sorted({time for leg in legs for start, stop, _ in leg.pieces for time in (start, stop)})
    positions = [0] * len(legs)
    spans = []
    for start, stop in pairwise(instants):
        for k, leg in enumerate(legs):
            while positions[k] < len(leg.pieces) - 1 and leg.pieces[positions[k]][1] <= start:
                positions[k] += 1
        pieces = [leg.pieces[positions[k]][2] for k, leg in enumerate(legs)]
        samples = _torque(legs, pieces, np.linspace(start, stop, 9))
        spans.append((start, stop, pieces, samples))
    bounds = []
    for sign in (1.0, -1.0):
        best = min(float((sign * samples).min()) for *_, samples in spans)
        for start, stop, pieces, samples in sorted(spans, key=lambda span: float((sign * span[3]).min()))[:4]:
            grid, middle = np.linspace(start, stop, 9), int(np.argmin(sign * samples))
            found = minimize_scalar(
                lambda time, sign=sign, pieces=pieces: float(
                    sign * _torque(legs, pieces, np.array([time]))[0]
                ),
                bounds=(grid[max(middle - 1, 0)], grid[min(middle + 1, 8)]),
                method="bounded",
                options={"xatol": 1e-13},
            )
            best = min(best, float(found.fun))
        bounds.append(sign * best)
    return bounds[0], bounds[1]


def _integrated(drive: Drive, point: Point) -> dict[str, float]:
    """Return the means over the last cycle by numerical integration."""
    legs = [Leg(drive, point, k * math.pi / drive.phases) for k in range(drive.phases)]
    totals = sum((_simulate(leg) for leg in legs), np.zeros(7)) * legs[0].electrical / (2.0 * math.pi)
    peak = max(
        abs(float(piece(time)[CURRENT])) for leg in legs for *ends, piece in leg.pieces for time in ends
    )
    lowest, highest = _torque_range(legs)
    supply, conductance = drive.half_supply_voltage, drive.core_loss_conductance
    return {
        "torque": drive.emf_constant * totals[SHAPE_CURRENT],
        "current_sum": totals[MAGNITUDE],
        "exchanged_power": supply * totals[MAGNITUDE],
        "source_power": totals[ENERGY],
        "copper_loss": drive.resistance * totals[SQUARE],
        "core_loss": conductance * (totals[CORE] + totals[DRAG]),
        "core_source_power": conductance * totals[CORE],
        "current_peak": peak,
        "torque_lowest": lowest,
        "torque_highest": highest,
    }


def _scales(drive: Drive, expected: dict[str, float]) -> dict[str, float]:
    """Return what each difference is measured against; a power as small as a loss is judged as a power."""
    current = max(expected["current_sum"], expected["current_peak"])
    power = drive.half_supply_voltage * current
    torque = drive.emf_constant * current
    return {
        name: torque if name.startswith("torque") else current if name.startswith("current") else power
        for name in expected
    } | {"copper_loss": expected["copper_loss"], "core_loss": max(expected["core_loss"], 1e-3)}


POINTS = [
    # Chopping below the rail.
    Point(200, 0, 2, 0.25, cycles=2),
    Point(350, 20, 10, 1.0, phases=2, cycles=2),
    Point(500, 33, 26, 0.25, cycles=2),
    Point(500, 0, 5, 0.25, phases=3, cycles=2),
    Point(800, 33, 14, 0.25, phases=5),
    Point(1000, 60, 8, 0.25, cycles=4),
    # The ideal regulator.
    Point(250, 10, 26, 0.0, phases=5),
    Point(500, 33, 26, 0.0, phases=5),
    Point(900, 0, 12, 0.0, phases=3),
    Point(1200, 40, 26, 0.0, phases=5),
    Point(1400, 20, 6, 0.0, phases=5),
    # A back-EMF above the rail.
    Point(1500, 52.5, 26, 0.0, phases=5, cycles=4),
    Point(1500, 58, 18, 0.25, phases=5, cycles=4),
    Point(1500, 0, 10, 0.25, phases=5),
    Point(1800, 70, 26, 0.25, phases=5),
    Point(2000, 85, 26, 0.0, phases=5),
    # Floating phases rectify.
    Point(1700, 0, 2, 0.25, phases=5),
    Point(2500, 45, 4, 0.25, phases=5),
    Point(2500, 80, 20, 0.25, phases=5),
    Point(2200, 10, 0, 0.25, phases=5),
    # A current that outlives the gap between two windows; windows that touch; a band wider than the reference.
    Point(1500, 85, 26, 0.25, phases=5, window_deg=176.0),
    Point(1100, 45, 12, 0.25, phases=4, window_deg=180.0, flat_deg=60.0),
    Point(1300, 50, 2, 3.0, phases=3, flat_deg=0.0),
    Point(900, 85, 20, 0.0, phases=3, flat_deg=150.0, resistance=0.0),
    Point(1600, 30, 24, 0.25, phases=5, flat_deg=170.0, resistance=0.8),
]


@pytest.mark.one_in(4)
@pytest.mark.kernel
@pytest.mark.parametrize("point", POINTS, ids=str)
def test_cycles_from_rest_match_numerical_integration(motor: Callable[..., Drive], point: Point) -> None:
    drive = motor(
        phases=point.phases,
        hysteresis_band=point.band,
        core_loss_conductance=point.conductance,
        flat_deg=point.flat_deg,
        window_deg=point.window_deg,
        resistance=point.resistance,
    )
    speed = point.rpm * math.pi / 30.0
    state: SteadyState = cycles_from_rest(
        drive,
        make_phases(drive, KEPT_TIME),
        speed,
        drive.half_supply_voltage,
        float(point.reference),
        math.radians(point.advance_deg),
        point.cycles,
    )
    expected = _integrated(drive, point)
    scales = _scales(drive, expected)
    differences = {
        name: abs(getattr(state, name) - value) / (scales[name] or 1.0) for name, value in expected.items()
    }
    worst = max(differences, key=lambda name: differences[name])
    assert differences[worst] <= AGREEMENT, (
        f"{worst} is {getattr(state, worst)!r}, by integration {expected[worst]!r}: "
        f"apart by {differences[worst]:.2e} of the scale"
    )
