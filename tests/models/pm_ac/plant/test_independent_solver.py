"""The PM AC drive against a second simulation that shares no code with it.

The second one is written from the physics alone: the flux linkage of the currents, in the frame that stands still,
integrated numerically (DOP853), and legs of two switches and two diodes. At every event it tries for a moment each
combination of legs that conduct one way, the other way, or not at all, and takes the one that stays lawful; the next
event is a root of the integrated solution.
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
from drivegate_models.pm_ac.plant.advance import advance_period, make_phases
from drivegate_models.pm_ac.plant.drive import CENTRED, FALLING, RISING, Modulator, PmAcDrive

AGREEMENT = 1e-11
"""Greatest difference of a current or an integral, relative to the scale of each."""

INTEGRALS = ("magnitude", "square", "impulse", "charge", "device")
THIRD = 2.0 * math.pi / 3.0
AXES = np.exp(1j * THIRD * np.arange(3))
BLOCKED = (0, 0, 0)
MODULATED = (1, 1, 1)


@dataclass(frozen=True)
class Point:
    """One operating point over some control periods."""

    rpm: float
    ratio: float = 0.8
    lead_deg: float = 90.0
    currents: tuple[float, float] = (0.0, 0.0)
    modes: tuple[tuple[int, int, int], ...] = (MODULATED,)
    alignment: int = CENTRED
    dead_time: float = 0.0
    drops: tuple[float, float] = (0.0, 0.0)
    angle: float = 0.3
    link: float = 120.0
    period: float = 1e-4
    periods: int = 6
    changes: dict[str, float] = field(default_factory=dict)

    def __str__(self) -> str:
        return (
            f"{self.rpm:g}rpm-{self.ratio:g}-{self.lead_deg:g}deg-{self.currents}-{self.modes}-a{self.alignment}"
            f"-dead{self.dead_time:g}-drops{self.drops}-{self.link:g}V-{self.changes}"
        )

    def ratios(self, angle: float) -> np.ndarray:
        """Duty ratios that follow the rotor, lead_deg ahead of the magnet's axis."""
        places = angle + math.radians(self.lead_deg) - THIRD * np.arange(3)
        return np.asarray(0.5 + 0.5 * self.ratio * np.cos(places))


class Law(NamedTuple):
    """What each leg does: its voltage, or none where it is held without a current."""

    signs: tuple[int, ...]
    voltages: tuple[float, ...]


class Solver:
    """The second simulation; the state is the flux linkage of the currents, and the integrals."""

    def __init__(self, drive: PmAcDrive, point: Point) -> None:
        self.drive, self.point = drive, point
        self.speed = point.rpm * math.pi / 30.0
        self.electrical = drive.pole_pairs * self.speed
        self.time = 0.0
        self.gates = [-1, -1, -1]
        self.commands = [-1, -1, -1]
        self.waits: list[float | None] = [None, None, None]
        current = complex(*point.currents)
        self.state = np.zeros(2 + len(INTEGRALS))
        self.set_current(current * np.exp(1j * point.angle))

    def angle(self, time: float) -> float:
        return self.point.angle + self.electrical * time

    def set_current(self, current: complex) -> None:
        """Set the flux linkage to that of a current of the frame that stands still."""
        turn = np.exp(1j * self.angle(self.time))
        rotor = current / turn
        flux = complex(
            self.drive.direct_inductance * rotor.real, self.drive.quadrature_inductance * rotor.imag
        )
        self.state[:2] = (flux * turn).real, (flux * turn).imag

    def rotor_current(self, time: float, state: np.ndarray) -> complex:
        flux = complex(state[0], state[1]) / np.exp(1j * self.angle(time))
        return complex(flux.real / self.drive.direct_inductance, flux.imag / self.drive.quadrature_inductance)

    def currents(self, time: float, state: np.ndarray) -> np.ndarray:
        current = self.rotor_current(time, state) * np.exp(1j * self.angle(time))
        return np.asarray((current * AXES.conj()).real)

    def slope_laws(self, time: float, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the slopes of the phase currents without voltage, and what each leg's voltage adds."""
        turn = np.exp(1j * self.angle(time))
        rotor = self.rotor_current(time, state)

        def slopes(voltage: complex, is_whole: bool) -> np.ndarray:
            induced = voltage
            turning = 0j
            if is_whole:
                flux = complex(state[0], state[1]) / turn + self.drive.magnet_flux
                induced = voltage - self.drive.resistance * rotor - 1j * self.electrical * flux
                turning = 1j * self.electrical * rotor
            rate = complex(
                induced.real / self.drive.direct_inductance, induced.imag / self.drive.quadrature_inductance
            )
            return np.asarray(((rate + turning) * turn * AXES.conj()).real)

        free = slopes(0j, True)
        per_volt = np.array([slopes(2.0 / 3.0 * axis / turn, False) for axis in AXES]).T
        return free, per_volt

    def voltages(self, law: Law, time: float, state: np.ndarray) -> np.ndarray:
        """Return the voltage of each leg, that of held ones such that their currents have no slope."""
        known = np.array(law.voltages)
        held = [k for k in range(3) if law.signs[k] == 0]
        if not held:
            return known
        if len(held) == 3:
            # The neutral's place is free; all legs agree with one at the middle of what each allows.
            turn = np.exp(1j * self.angle(time))
            emf = (1j * self.electrical * self.drive.magnet_flux * turn * AXES.conj()).real
            limits = [self.limits(k) for k in range(3)]
            lows = [low - e for (low, _), e in zip(limits, emf, strict=True)]
            highs = [high - e for (_, high), e in zip(limits, emf, strict=True)]
            neutral = 0.5 * (max(lows) + min(highs))
            return np.asarray(emf + neutral)
        (leg,) = held
        free, per_volt = self.slope_laws(time, state)
        others = [k for k in range(3) if k != leg]
        known[leg] = -(free[leg] + per_volt[leg, others] @ known[others]) / per_volt[leg, leg]
        return known

    def limits(self, leg: int) -> tuple[float, float]:
        """Return the voltage of a leg for a positive and for a negative current."""
        switch, diode = self.point.drops
        upper_on, lower_on = self.gates[leg] == 1, self.gates[leg] == -1
        positive = self.point.link - switch if upper_on else -diode
        negative = switch if lower_on else self.point.link + diode
        return positive, negative

    def rate(self, law: Law, time: float, state: np.ndarray) -> np.ndarray:
        voltages = self.voltages(law, time, state)
        voltage = 2.0 / 3.0 * np.sum(voltages * AXES)
        rotor = self.rotor_current(time, state)
        phase = self.currents(time, state)
        turn = np.exp(1j * self.angle(time))
        emf = 1j * self.electrical * self.drive.magnet_flux
        flux_rate = voltage - (self.drive.resistance * rotor + emf) * turn
        flux = complex(state[0], state[1]) / turn + self.drive.magnet_flux
        torque = 1.5 * self.drive.pole_pairs * (flux.conjugate() * rotor).imag
        switch, diode = self.point.drops
        charge = device = 0.0
        for leg in range(3):
            sign = law.signs[leg]
            upper = self.gates[leg] == 1 or (self.gates[leg] == 0 and sign < 0)
            charge += phase[leg] if upper and sign != 0 else 0.0
            drop = switch if self.gates[leg] == sign else diode
            device += drop * sign * phase[leg]
        return np.array(
            [
                flux_rate.real,
                flux_rate.imag,
                float(np.array(law.signs) @ phase),
                float(phase @ phase),
                torque,
                charge,
                device,
            ]
        )

    def momentary(self, law: Law, step: float) -> np.ndarray:
        """Return the state after a moment, by the classical method of Runge and Kutta."""
        time, state = self.time, self.state
        first = self.rate(law, time, state)
        second = self.rate(law, time + step / 2, state + step / 2 * first)
        third = self.rate(law, time + step / 2, state + step / 2 * second)
        fourth = self.rate(law, time + step, state + step * third)
        return np.asarray(state + step / 6 * (first + 2 * second + 2 * third + fourth))

    def law(self, stop: float) -> Law:
        """Return the only combination that stays lawful for a moment."""
        current = self.currents(self.time, self.state)
        scale = np.sum(np.abs(current)) + 1e-12
        choices = []
        for leg in range(3):
            if abs(current[leg]) > 1e-11 * scale and abs(current[leg]) > 1e-13:
                choices.append((1 if current[leg] > 0 else -1,))
            else:
                choices.append((0, 1, -1))
        step = min(1e-4 * self.point.period, 0.05 * (stop - self.time))
        best, margin = None, -math.inf
        for signs in itertools.product(*choices):
            held = [leg for leg in range(3) if signs[leg] == 0]
            fixed = [leg for leg in range(3) if self.limits(leg)[0] == self.limits(leg)[1]]
            # Without any current at all one leg may be driven: its phase is at the leg's voltage, nothing else.
            if len(held) == 2 or (len(held) == 1 and held[0] in fixed) or (len(held) == 3 and len(fixed) > 1):
                continue
            law = Law(signs, tuple(self.limits(k)[0 if signs[k] >= 0 else 1] for k in range(3)))
            after = self.momentary(law, step)
            then = self.currents(self.time + step, after)
            voltages = self.voltages(law, self.time + step, after)
            inductance = max(self.drive.direct_inductance, self.drive.quadrature_inductance)
            margins = []
            for leg in range(3):
                low, high = self.limits(leg)
                if leg in fixed and signs[leg] == 0:
                    continue
                if signs[leg] == 0:
                    margins.append(min(voltages[leg] - low, high - voltages[leg]))
                elif len(choices[leg]) > 1:
                    margins.append(signs[leg] * then[leg] * inductance / step)
            worst = min(margins, default=math.inf)
            if worst > margin:
                best, margin = law, worst
        assert best is not None
        return best

    def run_period(self, index: int, modes: tuple[int, int, int]) -> None:
        """Follow one control period."""
        period = self.point.period
        begin = index * period
        edges: list[tuple[float, int, int]] = []
        ratios = self.point.ratios(self.angle(begin))
        for leg in range(3):
            share = float(min(max(ratios[leg], 0.0), 1.0))
            start, stop = {
                CENTRED: (0.5 - 0.5 * share, 0.5 + 0.5 * share),
                RISING: (1.0 - share, 1.0),
                FALLING: (0.0, share),
            }[self.point.alignment]
            edges += [(begin, leg, 1 if start <= 0.0 < stop else -1)]
            edges += [(begin + start * period, leg, 1)] if 0.0 < start < stop else []
            edges += [(begin + stop * period, leg, -1)] if start < stop < 1.0 else []
        end = begin + period
        self.time = begin
        while True:
            for leg in range(3):
                wait = self.waits[leg]
                if wait is not None and wait <= self.time + 1e-18:
                    self.waits[leg] = None
            for time, leg, command in edges:
                if time <= self.time and command != self.commands[leg]:
                    self.commands[leg] = command
                    self.waits[leg] = time + self.point.dead_time if self.point.dead_time > 0.0 else None
            edges = [edge for edge in edges if edge[0] > self.time]
            if self.time >= end:
                break
            for leg in range(3):
                waits = self.waits[leg] is not None
                self.gates[leg] = 0 if waits or modes[leg] == 0 else self.commands[leg]
            pending = [wait for wait in self.waits if wait is not None]
            stop = min([end, *(edge[0] for edge in edges), *pending])
            for _ in range(200):
                if self.time >= stop:
                    break
                self.stretch(stop)
            else:
                raise AssertionError(f"{self.point}: no end of events at {self.time}")

    def stretch(self, stop: float) -> None:
        """Integrate to the next event, or to the next change of a gate."""
        law = self.law(stop)
        start = self.time
        scale = max(self.drive.current_limit, 1.0)
        found = solve_ivp(
            lambda time, state: self.rate(law, time, state),
            (start, stop),
            self.state,
            method="DOP853",
            rtol=1e-13,
            atol=1e-17 * scale * self.drive.direct_inductance,
            dense_output=True,
            max_step=(stop - start) / 2,
        )
        best, landing = stop, None
        grid = np.unique(np.concatenate([np.linspace(start, stop, 17), found.t]))
        states = found.sol(grid).T
        for leg in range(3):
            for function in self.watched(law, leg):
                values = list(map(function, grid, states))
                for low, high, first, second in zip(grid, grid[1:], values, values[1:], strict=False):
                    if first > 0.0 >= second:
                        time = brentq(lambda t, f=function: f(t, found.sol(t)), low, high, xtol=1e-20)
                        if time < best:
                            best, landing = time, leg
                        break
        self.state = np.array(found.sol(best)) if best < stop else found.y[:, -1]
        self.time = best
        if landing is not None and law.signs[landing] != 0:
            current = self.currents(best, self.state)
            current[landing] = 0.0
            rest = 0.5 * (current[(landing + 1) % 3] - current[(landing + 2) % 3])
            current[(landing + 1) % 3], current[(landing + 2) % 3] = rest, -rest
            if 0 in law.signs:
                current[:] = 0.0
            self.set_current(complex(2.0 / 3.0 * np.sum(current * AXES)))

    def watched(self, law: Law, leg: int) -> list[Callable[[float, np.ndarray], float]]:
        """Return what is positive until a leg's event."""
        sign = law.signs[leg]
        if sign != 0:
            return [lambda t, y: float(sign * self.currents(t, y)[leg])]
        low, high = self.limits(leg)
        return [
            lambda t, y: float(self.voltages(law, t, y)[leg] - low),
            lambda t, y: float(high - self.voltages(law, t, y)[leg]),
        ]


CHOSEN = [
    Point(750),
    Point(750, currents=(-3.0, 5.0)),
    Point(0),
    Point(0, currents=(2.0, -1.0), dead_time=3e-6),
    Point(0, modes=(BLOCKED,), currents=(4.0, 3.0), periods=20),
    Point(-900, lead_deg=-90, dead_time=2e-6),
    Point(1500, ratio=1.3, lead_deg=130, currents=(-5.0, 3.0)),
    Point(750, dead_time=2e-6),
    Point(750, ratio=0.1, dead_time=5e-6),
    Point(200, ratio=0.05, dead_time=1e-5),
    Point(750, dead_time=2e-6, drops=(1.2, 0.8)),
    Point(750, drops=(1.2, 0.8), currents=(-1.0, 1.0)),
    Point(750, drops=(0.0, 0.8)),
    Point(750, drops=(1.2, 0.0)),
    Point(1000, modes=(BLOCKED,), currents=(-4.0, 5.0), periods=25),
    Point(9000, modes=(BLOCKED,), periods=30),
    Point(9000, modes=(BLOCKED,), periods=30, drops=(1.2, 0.8), currents=(-3.0, 1.0)),
    Point(-9000, modes=(BLOCKED,), periods=20),
    Point(6000, modes=(MODULATED, BLOCKED), currents=(-5.0, 2.0), dead_time=2e-6, periods=12),
    Point(1500, modes=((1, 1, 0),), periods=12, currents=(0.0, 3.0)),
    Point(1500, modes=((1, 0, 0),), periods=12),
    Point(750, alignment=RISING, dead_time=2e-6),
    Point(750, alignment=FALLING, dead_time=2e-6),
    Point(750, changes={"resistance": 0.0}),
    Point(750, changes={"resistance": 0.0}, dead_time=2e-6, ratio=0.2),
    Point(9000, modes=(BLOCKED,), changes={"resistance": 0.0}, periods=20),
    Point(0, modes=(BLOCKED,), changes={"resistance": 0.0}, currents=(4.0, 3.0), periods=20),
    Point(750, changes={"quadrature_inductance": 8.72e-3}, dead_time=2e-6),
    Point(750, changes={"quadrature_inductance": 34.88e-3}, dead_time=2e-6, ratio=0.3),
    Point(9000, modes=(BLOCKED,), changes={"quadrature_inductance": 34.88e-3}, periods=30),
    Point(9000, modes=(BLOCKED,), changes={"quadrature_inductance": 2.18e-3}, periods=30),
    Point(750, changes={"resistance": 30.0}, dead_time=2e-6),
    Point(3000, modes=(BLOCKED,), changes={"resistance": 30.0}, periods=20, link=20.0),
    Point(750, link=0.0, currents=(3.0, 3.0), dead_time=2e-6),
]


def _drawn(seed: int) -> Point:
    """Return a point anywhere in the range of sense."""
    draw = np.random.default_rng(seed)
    modes = [(MODULATED,), (MODULATED,), (BLOCKED,), (MODULATED, BLOCKED), ((1, 0, 1), MODULATED)]
    direct = 8.72e-3
    size = float(draw.choice([0.0, 0.1, 1.0]))
    return Point(
        rpm=float(draw.choice([0.0, 100.0, 700.0, 2000.0, 8000.0]) * draw.uniform(-1.0, 1.0)),
        ratio=float(draw.uniform(0.0, 1.4)),
        lead_deg=float(draw.uniform(-180, 180)),
        currents=(float(draw.uniform(-6, 6) * size), float(draw.uniform(-6, 6) * size)),
        modes=modes[draw.integers(len(modes))],
        alignment=int(draw.choice([CENTRED, CENTRED, RISING, FALLING])),
        dead_time=float(draw.choice([0.0, 2e-6, 8e-6, 3e-5])),
        drops=(float(draw.choice([0.0, 1.2])), float(draw.choice([0.0, 0.8]))),
        angle=float(draw.uniform(0, 6.2)),
        link=float(draw.choice([120.0, 40.0])),
        periods=8,
        changes={
            "resistance": float(draw.choice([0.0, 0.57, 5.0])),
            "quadrature_inductance": direct * float(draw.choice([1.0, 2.6, 4.0])),
        },
    )


# The chosen ones take every branch, which is what is tested without compilation.
POINTS = [
    *(pytest.param(point, marks=pytest.mark.kernel) for point in CHOSEN),
    *map(_drawn, range(40)),
]


def differences(interior: Callable[..., PmAcDrive], point: Point) -> dict[str, float]:
    """Return how far both simulations are apart, relative to the scale of each quantity."""
    drive = interior(
        modulator=Modulator(dead_time=point.dead_time),
        switch_drop=point.drops[0],
        diode_drop=point.drops[1],
        **point.changes,
    )
    solver = Solver(drive, point)
    phases, totals = make_phases(), np.zeros(ledger.ENTRIES)
    phases.rotor_currents[:] = point.currents
    peak = max(float(np.hypot(*point.currents)), 1e-3)
    current_error = 0.0
    for k in range(point.periods):
        modes = point.modes[k % len(point.modes)]
        angle = solver.angle(k * point.period)
        ratios = point.ratios(angle)
        status = advance_period(
            drive,
            phases,
            angle,
            solver.speed,
            point.link,
            ratios,
            np.array(modes, np.int64),
            point.alignment,
            point.period,
            totals,
        )
        assert status == COMPLETED
        solver.run_period(k, modes)
        expected = solver.currents((k + 1) * point.period, solver.state)
        peak = max(peak, float(totals[ledger.PEAK]))
        current_error = max(current_error, float(np.max(np.abs(phases.currents - expected))))
    time = point.periods * point.period
    integrals = dict(zip(INTEGRALS, solver.state[2:], strict=True))
    scales = {
        "magnitude": peak * time,
        "square": peak * peak * time,
        "impulse": (drive.magnet_flux + drive.quadrature_inductance * peak) * 3.0 * peak * time,
        "charge": peak * time,
        "device": max(sum(point.drops), 1.0) * peak * time,
    }
    values = {
        "magnitude": totals[ledger.MAGNITUDE],
        "square": totals[ledger.SQUARE],
        "impulse": totals[ledger.IMPULSE],
        "charge": (totals[ledger.UPPER] + totals[ledger.LOWER]) / point.link if point.link else 0.0,
        "device": totals[ledger.DEVICE],
    }
    if point.link == 0.0:
        integrals["charge"] = 0.0
    apart = {name: abs(values[name] - integrals[name]) / scales[name] for name in INTEGRALS}
    apart["currents"] = current_error / peak
    return apart


@pytest.mark.one_in(6)
@pytest.mark.parametrize("point", POINTS, ids=str)
def test_currents_and_integrals_agree_with_a_numerical_solver(
    interior: Callable[..., PmAcDrive], point: Point
) -> None:
    apart = differences(interior, point)
    worst = max(apart, key=apart.__getitem__)
    assert apart[worst] <= AGREEMENT, f"{worst} apart by {apart[worst]:.1e} of its scale: {apart}"
