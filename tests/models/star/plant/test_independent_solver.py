"""The star against a second simulation that shares no code with it.

The second one is written from the physics alone: legs with switches and diodes, windings that meet in a neutral.
At every event it tries each combination of phases that move and phases that are held, takes the one that the laws
of Kirchhoff and of the devices allow, integrates its differential equation numerically (DOP853), and finds the
next event as a root of the integrated solution.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.star.plant.drive import EVERY_HALF, ON_PWM, PWM_ON, UPPER_ONLY, StarDrive
from drivegate_models.star.plant.phases import advance_phases, make_phases

AGREEMENT = 1e-9
"""Greatest difference of a current or an integral, relative to the scale of each."""

VOLTAGE_TIE, CURRENT_TIE = 1e-7, 1e-9
INTEGRALS = ("magnitude", "square", "impulse", "energy", "core", "drag")
HELD, DOWN, UP = "held", "down", "up"
CHOPPING = {
    EVERY_HALF: {(1, 0), (1, 1), (-1, 0), (-1, 1)},
    UPPER_ONLY: {(1, 0), (1, 1)},
    PWM_ON: {(1, 0), (-1, 0)},
    ON_PWM: {(1, 1), (-1, 1)},
}


@dataclass(frozen=True)
class Point:
    """One operating point, from rest at angle 0."""

    rpm: float
    advance_deg: float
    reference: float
    band: float = 0.0
    regulation: int = EVERY_HALF
    phases: int = 3
    flat_deg: float = 120.0
    window_deg: float = 120.0
    cycles: float = 1.5
    changes: dict[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        return (
            f"{self.rpm:g}rpm-{self.advance_deg:g}deg-{self.reference:g}A-h{self.band:g}-m{self.phases}"
            f"-r{self.regulation}-flat{self.flat_deg:g}-window{self.window_deg:g}-{self.changes}"
        )


Watched = tuple[int, float | None, Callable[[float, np.ndarray], float]]


class Motion(NamedTuple):
    """What each phase does until the next event, and the voltage of its leg if it moves."""

    moves: tuple[str, ...]
    voltages: tuple[float, ...]


class Solver:
    """The second simulation."""

    def __init__(self, drive: StarDrive, point: Point) -> None:
        self.drive, self.point = drive, point
        self.count = point.phases
        self.speed = point.rpm * math.pi / 30.0
        self.electrical = drive.pole_pairs * self.speed
        self.latches = [True] * self.count
        self.sectors = [0] * self.count
        self.state = np.zeros(self.count + len(INTEGRALS))
        self.ramp = 0.5 * (math.pi - math.radians(point.flat_deg))
        self.half_window = 0.5 * math.radians(point.window_deg)
        self.time = 0.0
        self.advance = math.radians(point.advance_deg)

    def angle(self, phase: int, time: float) -> float:
        return self.electrical * time - 2.0 * math.pi * phase / self.count

    def shape(self, phase: int, time: float) -> float:
        """Trapezoid: a triangle wave of slope one, cut off at its ramps' width."""
        position = (self.angle(phase, time) + 0.5 * math.pi) % (2.0 * math.pi)
        return max(-1.0, min(1.0, (0.5 * math.pi - abs(position - math.pi)) / self.ramp))

    def shape_rate(self, phase: int, time: float) -> float:
        """Slope of a straight piece, at a time well inside it."""
        position = (self.angle(phase, time) + 0.5 * math.pi) % (2.0 * math.pi)
        is_flat = abs(0.5 * math.pi - abs(position - math.pi)) > self.ramp
        return 0.0 if is_flat else math.copysign(self.electrical / self.ramp, math.pi - position)

    def window(self, phase: int, time: float) -> tuple[int, int]:
        """Return sign and half of the window; the sign is 0 between windows."""
        position = (self.angle(phase, time) + self.advance) % (2.0 * math.pi)
        for sector, centre in ((1, 0.5 * math.pi), (-1, 1.5 * math.pi)):
            if abs(position - centre) < self.half_window:
                return sector, int(position > centre)
        return 0, 0

    def boundaries(self, end: float) -> list[float]:
        """Times of the corners of the shapes and of edges and middles of the windows."""
        middle, half = 0.5 * math.pi - self.advance, self.half_window
        angles = [self.ramp, math.pi - self.ramp, middle - half, middle, middle + half]
        lags = [2.0 * math.pi * k / self.count for k in range(self.count)]
        turns = range(-6, int(2 * self.point.cycles) + 6)
        times = sorted(
            (angle + turn * math.pi + lag) / self.electrical
            for angle in angles
            for turn in turns
            for lag in lags
        )
        kept = [0.0]
        for time in [*(time for time in times if 0.0 < time < end), end]:
            if time - kept[-1] > 1e-12 / self.electrical:
                kept.append(time)
        return kept

    def leg(self, phase: int, window: tuple[int, int], current: float, side: int) -> float:
        """Return the voltage of a leg for a current just below (-1) or just above (1) another."""
        drive, reference = self.drive, self.point.reference
        on_rail, by_diode = (
            drive.half_supply_voltage - drive.switch_drop,
            drive.half_supply_voltage + drive.diode_drop,
        )
        sign = math.copysign(1.0, current) if current != 0.0 else side
        sector = window[0]
        is_on = sector != 0 and reference > 0.0
        if is_on and window in CHOPPING[self.point.regulation]:
            along = sector * current
            is_on = along < reference or (along == reference and sector * side < 0)
            if self.point.band > 0.0:
                is_on = self.latches[phase]
        if not is_on or sign != sector:
            return -sign * by_diode if not is_on else sector * by_diode
        return sector * on_rail

    def compare(self, windows: list[tuple[int, int]]) -> None:
        """Let the comparators look at their currents, which an event may have left a little short of a level."""
        reference, band = self.point.reference, self.point.band
        for k, window in enumerate(windows):
            if window not in CHOPPING[self.point.regulation]:
                self.latches[k] = True
                continue
            along = window[0] * self.state[k]
            if along >= (reference + band) * (1.0 - 1e-11):
                self.latches[k] = False
            elif along <= max(reference - band, 0.0) * (1.0 + 1e-11):
                self.latches[k] = True

    def motion(self, windows: list[tuple[int, int]], time: float, rates: np.ndarray) -> Motion:
        """Return the only combination that the laws allow."""
        drive, currents = self.drive, self.state[: self.count]
        peak = drive.emf_constant * self.speed
        opposed = (
            np.array([peak * self.shape(k, time) for k in range(self.count)]) + drive.resistance * currents
        )
        below = np.array([self.leg(k, windows[k], currents[k], -1) for k in range(self.count)])
        above = np.array([self.leg(k, windows[k], currents[k], 1) for k in range(self.count)])
        choices = [(UP,) if below[k] == above[k] else (HELD, DOWN, UP) for k in range(self.count)]
        for moves in itertools.product(*choices):
            moving = [k for k in range(self.count) if moves[k] != HELD]
            voltages = np.where([move == DOWN for move in moves], below, above)
            if self.is_allowed(choices, moves, moving, voltages, below, above, opposed, rates):
                return Motion(moves, tuple(voltages))
        raise AssertionError(f"{self.point}: nothing is allowed at {time}: {currents}")

    def is_allowed(
        self,
        choices: list[tuple[str, ...]],
        moves: tuple[str, ...],
        moving: list[int],
        voltages: np.ndarray,
        below: np.ndarray,
        above: np.ndarray,
        opposed: np.ndarray,
        rates: np.ndarray,
    ) -> bool:
        lows, highs = above - opposed, below - opposed
        if not moving:
            pairs = itertools.permutations(range(self.count), 2)
            return all(later_positive(highs[j] - lows[k], rates[k] - rates[j], VOLTAGE_TIE) for j, k in pairs)
        neutral = float(np.mean((voltages - opposed)[moving]))
        neutral_rate = -float(np.mean(rates[moving]))
        for k in range(self.count):
            pull, pull_rate = voltages[k] - opposed[k] - neutral, -rates[k] - neutral_rate
            if moves[k] == HELD:
                if not later_positive(highs[k] - neutral, pull_rate, VOLTAGE_TIE):
                    return False
                if not later_positive(neutral - lows[k], -pull_rate, VOLTAGE_TIE):
                    return False
            elif len(choices[k]) > 1:
                sign = 1.0 if moves[k] == UP else -1.0
                if not later_positive(sign * pull, sign * pull_rate, VOLTAGE_TIE):
                    return False
        return True

    def run(self, end: float) -> None:
        edges = self.boundaries(end)
        for start, stop in itertools.pairwise(edges):
            middle = 0.5 * (start + stop)
            windows = [self.window(k, middle) for k in range(self.count)]
            for k, (sector, _) in enumerate(windows):
                if sector != self.sectors[k]:
                    self.latches[k] = True
                self.sectors[k] = sector
            time = start
            for _ in range(2000):
                if time >= stop:
                    break
                time = self.stretch(windows, middle, time, stop)
            else:
                raise AssertionError(f"{self.point}: no end of events at {time}")

    def stretch(self, windows: list[tuple[int, int]], middle: float, start: float, stop: float) -> float:
        """Integrate to the next event, or to the end of the piece."""
        count = self.count
        if self.point.band > 0.0:
            self.compare(windows)
        peak = self.drive.emf_constant * self.speed
        rates = peak * np.array([self.shape_rate(k, middle) for k in range(count)])
        self.time = start
        motion = self.motion(windows, start, rates)
        laws = self.laws(windows, motion, middle)
        found = solve_ivp(
            laws.equation,
            (start, stop),
            self.state,
            method="DOP853",
            rtol=1e-13,
            atol=1e-15 * max(1.0, self.point.reference),
            dense_output=True,
            max_step=(stop - start) / 4,
        )
        grid = np.unique(np.concatenate([np.linspace(start, stop, 41), found.t]))
        states = found.sol(grid).T
        best, landing = stop, []
        for phase, level, function in self.watch(windows, laws):
            values = list(map(function, grid, states))
            # What begins at its level, or a hair beyond, has just left it.
            for low, high, first, second in zip(grid, grid[1:], values, values[1:], strict=False):
                if first > 0.0 >= second:
                    time = brentq(lambda t, f=function: f(t, found.sol(t)), low, high, xtol=1e-18, rtol=1e-15)
                    # Later by no more than the root's precision: the same event.
                    if time < best - 1e-13 * (stop - start) - 1e-16:
                        best, landing = time, []
                    if time <= best + 1e-13 * (stop - start) + 1e-16:
                        landing.append((phase, level))
                    break
        self.state = np.array(found.sol(best))
        for phase, level in landing:
            if level is not None:
                self.state[phase] = level
        return best

    def laws(self, windows: list[tuple[int, int]], motion: Motion, middle: float) -> Laws:
        """Return what holds until the next event."""
        start = self.state[: self.count].copy()
        sides = [
            np.array([self.leg(k, windows[k], start[k], side) for k in range(self.count)]) for side in (-1, 1)
        ]
        return Laws(
            self.drive,
            self.drive.emf_constant * self.speed,
            middle,
            np.array([self.shape(k, middle) for k in range(self.count)]),
            np.array([self.shape_rate(k, middle) for k in range(self.count)]),
            np.array([move != HELD for move in motion.moves]),
            np.array(motion.voltages),
            *sides,
            self.time,
            start,
        )

    def levels(self, phase: int, window: tuple[int, int]) -> set[float]:
        """Return the currents at which a moving phase has an event."""
        reference, band = self.point.reference, self.point.band
        if window not in CHOPPING[self.point.regulation] or reference <= 0.0:
            return {0.0}
        if band == 0.0:
            return {0.0, window[0] * reference}
        if self.latches[phase]:
            return {0.0, window[0] * (reference + band)}
        return {0.0, window[0] * max(reference - band, 0.0)}

    def watch(self, windows: list[tuple[int, int]], laws: Laws) -> list[Watched]:
        """Return what is watched: positive until its event."""
        watched: list[Watched] = []
        for k in range(self.count):
            if laws.moving[k]:
                for level in self.levels(k, windows[k]):
                    watched.append((k, level, lambda _, y, k=k, level=level: float(y[k] - level)))
                    watched.append((k, level, lambda _, y, k=k, level=level: float(level - y[k])))
            elif laws.moved:
                watched.append((k, None, lambda t, y, k=k: float((laws.below - laws.wanted(t, y))[k])))
                watched.append((k, None, lambda t, y, k=k: float((laws.wanted(t, y) - laws.above)[k])))
        if not laws.moved:
            watched.append((0, None, laws.room))
        return watched


@dataclass
class Laws:
    """What holds between two events."""

    drive: StarDrive
    peak: float
    middle: float
    offsets: np.ndarray
    slopes: np.ndarray
    moving: np.ndarray
    voltages: np.ndarray
    below: np.ndarray
    above: np.ndarray
    time: float
    start: np.ndarray

    def __post_init__(self) -> None:
        self.moved = int(self.moving.sum())
        self.chopping = ~self.moving & (self.start != 0.0)
        self.chopped = int(self.chopping.sum())
        # What moves alone stands still, since the currents sum to zero.
        alone = self.moved == 1 and self.start[int(np.argmax(self.moving))] == 0.0
        self.is_still = alone or not self.moved
        self.carries = (self.start != 0.0) | (self.moving & (not self.is_still))
        pulls = self.voltages - self.opposed(self.time, self.start) - self.neutral(self.time, self.start)
        later = np.mean(self.slopes[self.moving]) - self.slopes if self.moved else 0.0 * pulls
        direction = np.sign(np.where(np.abs(pulls) > VOLTAGE_TIE, pulls, later))
        self.signs = np.where(self.start != 0.0, np.sign(self.start), np.where(self.moving, direction, 0.0))

    def opposed(self, time: float, currents: np.ndarray) -> np.ndarray:
        """Return back-EMF and resistive drop of every phase."""
        return (
            self.peak * (self.offsets + self.slopes * (time - self.middle)) + self.drive.resistance * currents
        )

    def neutral(self, time: float, currents: np.ndarray) -> float:
        against = self.opposed(time, currents)
        if self.moved:
            return float((self.voltages - against)[self.moving].sum()) / self.moved
        return 0.5 * float((self.above - against).max() + (self.below - against).min())

    def wanted(self, time: float, state: np.ndarray) -> np.ndarray:
        """Return the leg voltages that would hold every current."""
        currents = state[: len(self.start)]
        return self.neutral(time, currents) + self.opposed(time, currents)

    def room(self, time: float, state: np.ndarray) -> float:
        """Return how much room the neutral has where no phase moves."""
        against = self.opposed(time, state[: len(self.start)])
        return float((self.below - against).min() - (self.above - against).max())

    def equation(self, time: float, state: np.ndarray) -> np.ndarray:
        """Return the rates of currents and integrals."""
        drive, currents = self.drive, state[: len(self.start)]
        held = self.wanted(time, state)
        legs = np.where(self.moving, self.voltages, held)
        pulls = legs - held
        shapes = self.offsets + self.slopes * (time - self.middle)
        gaps = self.peak * shapes + pulls
        ripple = float(((self.below - legs) * (legs - self.above))[self.chopping].sum())
        if not self.is_still:
            # One that chops by itself takes the neutral with it.
            connected = self.moved + self.chopped
            ripple *= (connected - 1) / connected
        # Rails, not legs: a forward drop is no voltage of the source.
        taken = float(legs @ currents) + self.dropped(legs, currents)
        squares = float((gaps * gaps)[self.carries].sum()) + ripple
        drag = drive.emf_constant * self.peak * float((shapes * shapes)[~self.carries].sum())
        integrals = [
            float(self.signs @ currents),
            float(currents @ currents),
            drive.emf_constant * float(shapes @ currents),
            taken,
            drive.core_loss_conductance * squares,
            drive.core_loss_conductance * drag,
        ]
        return np.concatenate([pulls / drive.inductance, integrals])

    def dropped(self, legs: np.ndarray, currents: np.ndarray) -> float:
        """Return the loss in forward drops (W)."""
        drive, total = self.drive, 0.0
        if drive.switch_drop == drive.diode_drop == 0.0:
            return total
        for k, sign in enumerate(self.signs):
            on, off = (self.below[k], self.above[k]) if sign > 0.0 else (self.above[k], self.below[k])
            share = (legs[k] - off) / (on - off) if self.chopping[k] else float(legs[k] * sign > 0.0)
            total += sign * currents[k] * (share * drive.switch_drop + (1.0 - share) * drive.diode_drop)
        return total


def later_positive(value: float, rate: float, tie: float) -> bool:
    """Return whether a straight line is not negative from now on."""
    if abs(value) > tie:
        return value > 0.0
    return rate >= -1e-3


CHOSEN = [
    Point(500, 0, 20),
    Point(500, 0, 20, regulation=UPPER_ONLY),
    Point(500, 10, 20, regulation=PWM_ON),
    Point(500, 10, 20, regulation=ON_PWM),
    Point(300, 30, 8),
    Point(900, 30, 30),
    Point(1500, 70.9, 130 / 3),
    Point(1500, 70.2, 130 / 3, flat_deg=150),
    Point(1500, 46.4, 36, flat_deg=150, window_deg=150),
    Point(1500, 60, 130 / 3, flat_deg=150, changes={"inductance": 0.432e-3}),
    Point(2400, 85, 40),
    Point(3500, 0, 0),
    Point(3500, 60, 10),
    Point(6000, 80, 40),
    Point(1352.1, 0, 0),
    Point(500, 0, 20, window_deg=180),
    Point(500, 20, 20, window_deg=60),
    Point(800, 45, 20, flat_deg=0),
    Point(1200, 20, 15, changes={"switch_drop": 0.9, "diode_drop": 0.7}),
    Point(600, 0, 25, changes={"switch_drop": 1.2}),
    Point(600, 0, 25, changes={"diode_drop": 1.2}, regulation=UPPER_ONLY),
    Point(3600, 30, 5, changes={"switch_drop": 0.9, "diode_drop": 0.7}),
    Point(500, 0, 20, band=2),
    Point(500, 15, 20, band=2, regulation=UPPER_ONLY),
    Point(500, 15, 20, band=2, regulation=PWM_ON),
    Point(500, 15, 20, band=2, regulation=ON_PWM),
    Point(1000, 30, 30, band=1),
    Point(900, 30, 2, band=4),
    Point(1500, 55, 43, band=2),
    Point(700, 0, 10, band=2, changes={"switch_drop": 0.9, "diode_drop": 0.7}),
    Point(500, 0, 20, phases=5, window_deg=144, flat_deg=98),
    Point(1500, 55, 26, phases=5, window_deg=144, flat_deg=98),
    Point(500, 10, 20, phases=5, regulation=UPPER_ONLY),
    Point(800, 20, 20, phases=7, window_deg=150, flat_deg=110),
    Point(800, 20, 20, band=3, phases=5, window_deg=108, flat_deg=130),
    Point(2500, 60, 20, phases=9, window_deg=120, flat_deg=150),
    Point(500, 0, 1e-9),
    Point(500, 0, 20, changes={"resistance": 0.0}),
    Point(800, 10, 20, changes={"resistance": 2.0}),
    Point(500, 90, 20),
]


def _drawn(seed: int) -> Point:
    """Return a point anywhere in the range of sense."""
    draw = np.random.default_rng(seed)
    band = float(draw.choice([0.0, 0.0, 1.0, 3.0]))
    return Point(
        rpm=float(draw.uniform(150, 4000)),
        advance_deg=float(draw.uniform(0, 90)),
        reference=float(draw.choice([0.0, 5.0, 20.0, 43.0]) * draw.uniform(0.5, 1.0)),
        band=band,
        regulation=int(draw.choice([EVERY_HALF, EVERY_HALF, UPPER_ONLY, PWM_ON, ON_PWM])),
        phases=int(draw.choice([3, 3, 3, 5, 7])),
        flat_deg=float(draw.uniform(10, 170)),
        window_deg=float(draw.uniform(60, 180)),
        cycles=1.0,
        changes={
            "resistance": float(draw.choice([0.0, 0.048, 0.5])),
            "inductance": float(draw.choice([1.728e-3, 0.5e-3, 4e-3])),
            "switch_drop": float(draw.choice([0.0, 0.9])),
            "diode_drop": float(draw.choice([0.0, 0.7])),
        },
    )


# The chosen ones take every branch, which is what is tested without compilation.
POINTS = [
    *(pytest.param(point, marks=pytest.mark.kernel) for point in CHOSEN),
    *map(_drawn, range(40)),
]


def differences(star: Callable[..., StarDrive], point: Point) -> dict[str, float]:
    """Return how far both simulations are apart, relative to the scale of each quantity."""
    drive = star(
        phases=point.phases,
        flat_deg=point.flat_deg,
        window_deg=point.window_deg,
        hysteresis_band=point.band,
        regulation=point.regulation,
        core_loss_conductance=3e-3,
        **point.changes,
    )
    solver = Solver(drive, point)
    end = point.cycles * 2.0 * math.pi / solver.electrical
    solver.run(end)
    phases, totals = make_phases(drive), np.zeros(ledger.ENTRIES)
    pieces = 7
    for k in range(pieces):
        status = advance_phases(
            drive,
            phases,
            solver.electrical * end * k / pieces,
            solver.speed,
            48.0,
            48.0,
            float(point.reference),
            solver.advance,
            end / pieces,
            totals,
        )
        assert status == COMPLETED
    current = max(totals[ledger.PEAK], point.reference, 1e-12)
    expected = dict(zip(INTEGRALS, solver.state[point.phases :], strict=True))
    emf = drive.emf_constant * solver.speed
    scales = {
        "magnitude": current * end,
        "square": current * current * end,
        "impulse": drive.emf_constant * current * end,
        "energy": 48.0 * current * end,
        "core": 3e-3 * (48.0 + emf) ** 2 * end,
        "drag": 3e-3 * drive.emf_constant * emf * end,
    }
    values = {
        "magnitude": totals[ledger.MAGNITUDE],
        "square": totals[ledger.SQUARE],
        "impulse": totals[ledger.IMPULSE],
        "energy": totals[ledger.UPPER] + totals[ledger.LOWER],
        "core": totals[ledger.CORE_SOURCE],
        "drag": totals[ledger.CORE_DRAG_IMPULSE],
    }
    apart = {name: abs(values[name] - expected[name]) / scales[name] for name in INTEGRALS}
    apart["currents"] = float(np.max(np.abs(phases.currents - solver.state[: point.phases]))) / current
    return apart


@pytest.mark.one_in(12)
@pytest.mark.parametrize("point", POINTS, ids=str)
def test_currents_and_integrals_agree_with_a_numerical_solver(
    star: Callable[..., StarDrive], point: Point
) -> None:
    apart = differences(star, point)
    worst = max(apart, key=apart.__getitem__)
    assert apart[worst] <= AGREEMENT, f"{worst} apart by {apart[worst]:.1e} of its scale: {apart}"
