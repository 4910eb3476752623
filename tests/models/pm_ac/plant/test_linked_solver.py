"""A PM AC drive on a link with a capacitor against a numerical solver that shares no code with the plant.

The solver of the ideal link gets one more state, the capacitor's voltage, which its legs then follow. Source, chopper
and an empty capacitor change its equations at roots of the integrated solution.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq
from tests.models.pm_ac.plant.test_independent_solver import AXES, BLOCKED, MODULATED, Law, Point, Solver

from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.pm_ac.plant import dc_link
from drivegate_models.pm_ac.plant.advance import make_phases
from drivegate_models.pm_ac.plant.dc_link import BATTERY, RECTIFIER, DcLink, charge_link
from drivegate_models.pm_ac.plant.drive import FALLING, RISING, Modulator, PmAcDrive
from drivegate_models.pm_ac.plant.linked_advance import advance_linked_period

AGREEMENT = 1e-9
"""Greatest difference of currents, voltage and integrals, relative to the scale of each."""
VOLTAGE, CURRENT = 7, 11
"""Places of the link's voltage and of its source's current in the solver's state."""
LIMIT = 400.0
ON, OFF, BURNING = 140.0, 132.0, 0.05
"""Thresholds (V) and conductance (S) of the chopper."""


@dataclass(frozen=True)
class LinkedPoint(Point):
    """An operating point with a link of its own; its `link` is the voltage of the source."""

    source: int = BATTERY
    capacitance: float = 2e-4
    resistance: float = 0.5
    inductance: float = 0.0
    begin: float | None = None
    sources: tuple[float, ...] = ()
    """Voltages of the source in consecutive periods (V); 0 while it is lost."""
    chopper: float = 0.0
    brake: float = math.nan
    lost: float = 0.0
    """Core and switching loss that the link supplies (W)."""

    def __str__(self) -> str:
        kind = "battery" if self.source == BATTERY else "rectifier"
        source = f"{self.capacitance:g}F-{self.resistance:g}ohm-{self.inductance:g}H"
        own = f"{source}-{self.begin}-{self.sources}-{self.chopper}-{self.brake}"
        return f"{kind}-{own}-{self.lost}-{super().__str__()}"

    @property
    def constants(self) -> DcLink:
        own = (self.capacitance, self.resistance, self.source, LIMIT, 0.0, 0.0, ON, OFF, self.chopper)
        return DcLink(*own, self.inductance)

    def source_in(self, period: int) -> float:
        return self.sources[period % len(self.sources)] if self.sources else self.link


class LinkedSolver(Solver):
    """The state has five more entries.

    They are the voltage, the charge of the source, the energy into the bridge and into the chopper, and the current of
    a source with an inductance.
    """

    point: LinkedPoint

    def __init__(self, drive: PmAcDrive, point: LinkedPoint) -> None:
        super().__init__(drive, point)
        self.volt = point.link if point.begin is None else point.begin
        self.state = np.concatenate([self.state, [self.volt, 0.0, 0.0, 0.0, 0.0]])
        self.source = point.link
        self.conducts = self.burns = self.is_empty = False
        self.lost = 0.0
        self.brake_end = -1.0

    def begin_period(self, index: int) -> None:
        """Connect the source and the commanded chopper at the start of a control period."""
        point, voltage = self.point, self.state[VOLTAGE]
        self.source = point.source_in(index)
        carries = point.source == BATTERY or voltage <= self.source or self.state[CURRENT] > 0.0
        self.conducts = self.source > 0.0 and carries
        if not self.conducts:
            self.state[CURRENT] = 0.0
        self.lost = point.lost / max(voltage, 0.2 * self.drive.link_voltage) ** 2
        if not math.isnan(point.brake):
            self.burns = point.brake > 0.0
            self.brake_end = (index + point.brake) * point.period

    def limits(self, leg: int) -> tuple[float, float]:
        switch, diode = self.point.drops
        upper_on, lower_on = self.gates[leg] == 1, self.gates[leg] == -1
        positive = self.volt - switch if upper_on else -diode
        negative = switch if lower_on else self.volt + diode
        return positive, negative

    def voltages(self, law: Law, time: float, state: np.ndarray) -> np.ndarray:
        self.volt = state[VOLTAGE]
        followed = Law(law.signs, tuple(self.limits(k)[0 if law.signs[k] >= 0 else 1] for k in range(3)))
        return super().voltages(followed, time, state)

    def law(self, stop: float) -> Law:
        self.volt = self.state[VOLTAGE]
        return super().law(stop)

    def current_of_source(self, state: np.ndarray) -> float:
        if self.point.inductance > 0.0:
            return float(state[CURRENT])
        return float((self.source - state[VOLTAGE]) / self.point.resistance) if self.conducts else 0.0

    def rate(self, law: Law, time: float, state: np.ndarray) -> np.ndarray:
        machine = super().rate(law, time, state)
        voltage, bridge = state[VOLTAGE], machine[5]
        current = self.current_of_source(state)
        chopper = self.point.chopper if self.burns else 0.0
        rise = (current - bridge - (self.lost + chopper) * voltage) / self.point.capacitance
        link = [0.0 if self.is_empty else rise, current, voltage * bridge, chopper * voltage * voltage]
        driving = self.source - voltage - self.point.resistance * current
        is_inductive = self.conducts and self.point.inductance > 0.0
        return np.concatenate([machine, link, [driving / self.point.inductance if is_inductive else 0.0]])

    def changes(self, law: Law) -> dict[str, Callable[[float, np.ndarray], float]]:
        """Return what is positive until each event of the link."""
        if self.is_empty:
            return {"charged": lambda t, y: float(self.rate(law, t, y)[5] - self.current_of_source(y))}
        found: dict[str, Callable[[float, np.ndarray], float]] = {"emptied": lambda t, y: float(y[VOLTAGE])}
        if self.point.source == RECTIFIER and self.source > 0.0:
            side = 1.0 if self.conducts else -1.0
            found["source"] = lambda t, y: float(side * (self.source - y[VOLTAGE]))
            if self.conducts and self.point.inductance > 0.0:
                found["source"] = lambda t, y: float(y[CURRENT])
        if self.point.chopper > 0.0 and math.isnan(self.point.brake):
            level, way = (OFF, -1.0) if self.burns else (ON, 1.0)
            found["chopper"] = lambda t, y: float(way * (level - y[VOLTAGE]))
        elif self.burns:
            found["chopper"] = lambda t, y: self.brake_end - t
        return found

    def change(self, name: str) -> None:
        if name == "source":
            self.conducts = not self.conducts
            self.state[CURRENT] = 0.0
        elif name == "chopper":
            self.burns = not self.burns
        elif name == "emptied":
            self.is_empty = True
            self.state[VOLTAGE] = 0.0
        else:
            self.is_empty = False

    def watched(self, law: Law, leg: int) -> list[Callable[[float, np.ndarray], float]]:
        if law.signs[leg] != 0:
            return super().watched(law, leg)
        return [
            lambda t, y: float(self.voltages(law, t, y)[leg] - self.limits(leg)[0]),
            lambda t, y: float(self.limits(leg)[1] - self.voltages(law, t, y)[leg]),
        ]

    def stretch(self, stop: float) -> None:
        law = self.law(stop)
        # The current grows from zero, and the voltage with its integral: a moment must not be too short to show that.
        step = 1e-3 * (stop - self.time)
        then = self.momentary(law, step)
        for name, function in self.changes(law).items():
            # A step of the source's voltage, or a start beyond a threshold or on its way there, is an event at once.
            now, soon = function(self.time, self.state), function(self.time + step, then)
            tie = 1e-11 * self.drive.link_voltage
            if now < -tie or (soon < 0.0 and soon < now < tie):
                self.change(name)
        law = self.law(stop)
        start, scale = self.time, max(self.drive.current_limit, 1.0)
        least = np.full(len(self.state), 1e-17 * scale * self.drive.direct_inductance)
        least[VOLTAGE] = 1e-14 * self.drive.link_voltage
        least[CURRENT] = 1e-14 * scale
        found = solve_ivp(
            lambda time, state: self.rate(law, time, state),
            (start, stop),
            self.state,
            method="DOP853",
            rtol=1e-13,
            atol=least,
            dense_output=True,
            max_step=(stop - start) / 2,
        )
        best, landing, changed = stop, None, None
        grid = np.unique(np.concatenate([np.linspace(start, stop, 17), found.t]))
        states = found.sol(grid).T
        watched = [(leg, None, f) for leg in range(3) for f in self.watched(law, leg)]
        watched += [(None, name, f) for name, f in self.changes(law).items()]
        for leg, name, function in watched:
            values = list(map(function, grid, states))
            for low, high, first, second in zip(grid, grid[1:], values, values[1:], strict=False):
                if first > 0.0 >= second:
                    time = brentq(lambda t, f=function: f(t, found.sol(t)), low, high, xtol=1e-20)
                    if time < best:
                        best, landing, changed = time, leg, name
                    break
        self.state = np.array(found.sol(best)) if best < stop else found.y[:, -1]
        self.time = best
        if changed is not None:
            self.change(changed)
        if landing is not None and law.signs[landing] != 0:
            current = self.currents(best, self.state)
            current[landing] = 0.0
            rest = 0.5 * (current[(landing + 1) % 3] - current[(landing + 2) % 3])
            current[(landing + 1) % 3], current[(landing + 2) % 3] = rest, -rest
            if 0 in law.signs:
                current[:] = 0.0
            self.set_current(complex(2.0 / 3.0 * np.sum(current * AXES)))


POINTS = [
    LinkedPoint(750),
    LinkedPoint(750, source=RECTIFIER),
    LinkedPoint(750, currents=(-3.0, 5.0), lost=60.0),
    LinkedPoint(750, lead_deg=-90, ratio=0.6, currents=(0.0, -6.0), periods=12),
    LinkedPoint(750, lead_deg=-90, ratio=0.3, currents=(0.0, -6.0), source=RECTIFIER, periods=16),
    LinkedPoint(1500, ratio=0.4, currents=(0.0, -6.0), source=RECTIFIER, chopper=BURNING, periods=40),
    LinkedPoint(
        1500, ratio=0.4, currents=(0.0, -6.0), source=RECTIFIER, chopper=0.5, periods=30, begin=139.0
    ),
    LinkedPoint(1500, ratio=0.4, currents=(0.0, -6.0), source=RECTIFIER, chopper=BURNING, brake=0.35),
    LinkedPoint(750, chopper=BURNING, brake=1.0),
    LinkedPoint(750, chopper=BURNING, brake=0.0, begin=150.0, source=RECTIFIER),
    LinkedPoint(0, currents=(2.0, -1.0), dead_time=3e-6),
    LinkedPoint(0, modes=(BLOCKED,), currents=(4.0, 3.0), periods=20),
    LinkedPoint(0, modes=(BLOCKED,), currents=(4.0, 3.0), source=RECTIFIER, capacitance=2e-5, periods=12),
    LinkedPoint(1000, modes=(BLOCKED,), currents=(-4.0, 5.0), source=RECTIFIER, periods=20),
    LinkedPoint(9000, modes=(BLOCKED,), periods=20),
    LinkedPoint(9000, modes=(BLOCKED,), source=RECTIFIER, periods=30),
    LinkedPoint(9000, modes=(BLOCKED,), source=RECTIFIER, chopper=BURNING, periods=30),
    LinkedPoint(-9000, modes=(BLOCKED,), source=RECTIFIER, drops=(1.2, 0.8), periods=20),
    LinkedPoint(6000, modes=(MODULATED, BLOCKED), currents=(-5.0, 2.0), dead_time=2e-6, periods=12),
    LinkedPoint(750, sources=(120.0, 120.0, 0.0, 0.0, 0.0, 0.0, 120.0, 120.0), periods=8),
    LinkedPoint(300, ratio=0.9, sources=(0.0,), currents=(0.0, 8.0), capacitance=1e-5, periods=6),
    LinkedPoint(300, ratio=0.9, sources=(0.0,) * 4 + (120.0,) * 4, currents=(0.0, 8.0), capacitance=1e-5),
    LinkedPoint(750, sources=(120.0, 150.0, 90.0, 0.0, 120.0), source=RECTIFIER, periods=10),
    LinkedPoint(1500, modes=((1, 1, 0),), periods=12, currents=(0.0, 3.0), source=RECTIFIER),
    LinkedPoint(1500, modes=((1, 0, 0),), periods=12),
    LinkedPoint(750, alignment=RISING, dead_time=2e-6, capacitance=2e-5),
    LinkedPoint(750, alignment=FALLING, dead_time=2e-6, source=RECTIFIER),
    LinkedPoint(750, drops=(1.2, 0.8), dead_time=2e-6, source=RECTIFIER),
    LinkedPoint(750, changes={"quadrature_inductance": 34.88e-3}, dead_time=2e-6, ratio=0.3),
    LinkedPoint(
        9000, modes=(BLOCKED,), changes={"quadrature_inductance": 34.88e-3}, source=RECTIFIER, periods=16
    ),
    LinkedPoint(9000, modes=(BLOCKED,), changes={"quadrature_inductance": 2.18e-3}, periods=16),
    LinkedPoint(750, changes={"resistance": 0.0}, ratio=0.2, dead_time=2e-6, capacitance=2e-5),
    LinkedPoint(750, inductance=2e-6),
    LinkedPoint(750, inductance=1e-4, source=RECTIFIER, dead_time=2e-6),
    LinkedPoint(750, inductance=1e-5, capacitance=2e-5, begin=60.0, periods=8),
    LinkedPoint(
        0, inductance=2e-5, capacitance=5e-5, begin=60.0, source=RECTIFIER, modes=(BLOCKED,), periods=8
    ),
    LinkedPoint(
        750, lead_deg=-90, ratio=0.6, currents=(0.0, -6.0), inductance=1e-4, source=RECTIFIER, periods=12
    ),
    LinkedPoint(750, inductance=1e-4, source=RECTIFIER, sources=(120.0, 150.0, 90.0, 0.0, 120.0), periods=10),
    LinkedPoint(
        300,
        ratio=0.9,
        sources=(0.0,) * 4 + (120.0,) * 4,
        currents=(0.0, 8.0),
        capacitance=1e-5,
        inductance=2e-5,
    ),
    LinkedPoint(9000, modes=(BLOCKED,), inductance=1e-5, source=RECTIFIER, chopper=BURNING, periods=20),
    LinkedPoint(
        750,
        inductance=5e-5,
        begin=139.0,
        chopper=BURNING,
        changes={"quadrature_inductance": 34.88e-3},
        lost=40.0,
    ),
]


def _drawn(seed: int) -> LinkedPoint:
    """Return a point anywhere in the range of sense."""
    draw = np.random.default_rng(seed)
    modes = [(MODULATED,), (MODULATED,), (BLOCKED,), (MODULATED, BLOCKED), ((1, 0, 1), MODULATED)]
    size = float(draw.choice([0.0, 0.1, 1.0]))
    courses = [(), (), (120.0, 120.0, 0.0, 0.0, 120.0), (120.0, 80.0, 140.0), (0.0,)]
    return LinkedPoint(
        rpm=float(draw.choice([0.0, 100.0, 700.0, 2000.0, 8000.0]) * draw.uniform(-1.0, 1.0)),
        ratio=float(draw.uniform(0.0, 1.4)),
        lead_deg=float(draw.uniform(-180, 180)),
        currents=(float(draw.uniform(-6, 6) * size), float(draw.uniform(-6, 6) * size)),
        modes=modes[draw.integers(len(modes))],
        dead_time=float(draw.choice([0.0, 2e-6, 8e-6])),
        drops=(float(draw.choice([0.0, 1.2])), float(draw.choice([0.0, 0.8]))),
        angle=float(draw.uniform(0, 6.2)),
        periods=8,
        changes={
            "resistance": float(draw.choice([0.0, 0.57, 5.0])),
            "quadrature_inductance": 8.72e-3 * float(draw.choice([1.0, 2.6, 4.0])),
        },
        source=int(draw.choice([BATTERY, RECTIFIER])),
        capacitance=float(10.0 ** draw.uniform(-5.0, -2.5)),
        resistance=float(10.0 ** draw.uniform(-0.5, 1.0)),
        begin=float(draw.choice([120.0, 131.0, 139.0, 60.0])),
        sources=courses[draw.integers(len(courses))],
        chopper=float(draw.choice([0.0, BURNING, 0.5])),
        brake=float(draw.choice([math.nan, math.nan, 0.4])),
        lost=float(draw.choice([0.0, 30.0])),
        inductance=float(draw.choice([0.0, 10.0 ** draw.uniform(-5.0, -3.0)])),
    )


def differences(interior: Callable[..., PmAcDrive], point: LinkedPoint) -> dict[str, float]:
    """Return how far both simulations are apart, relative to the scale of each quantity."""
    drive = interior(
        modulator=Modulator(dead_time=point.dead_time),
        switch_drop=point.drops[0],
        diode_drop=point.drops[1],
        **point.changes,
    )._replace(dc_link=point.constants)
    solver = LinkedSolver(drive, point)
    phases, totals = make_phases(), np.zeros(ledger.ENTRIES)
    phases.rotor_currents[:] = point.currents
    link = phases.dc_link
    charge_link(link, solver.volt)
    link.totals[dc_link.HIGHEST] = link.totals[dc_link.LOWEST] = solver.volt
    peak = max(float(np.hypot(*point.currents)), 1e-3)
    current_error = voltage_error = 0.0
    for k in range(point.periods):
        modes = point.modes[k % len(point.modes)]
        angle = solver.angle(k * point.period)
        ratios = point.ratios(angle)
        link.state[dc_link.PENDING] = point.lost
        status = advance_linked_period(
            drive,
            phases,
            angle,
            solver.speed,
            point.source_in(k),
            ratios,
            np.array(modes, np.int64),
            point.brake,
            point.alignment,
            point.period,
            totals,
        )
        assert status == COMPLETED
        solver.begin_period(k)
        solver.run_period(k, modes)
        expected = solver.currents((k + 1) * point.period, solver.state)
        peak = max(peak, float(totals[ledger.PEAK]))
        current_error = max(current_error, float(np.max(np.abs(phases.currents - expected))))
        voltage_error = max(
            voltage_error, abs(float(link.state[dc_link.VOLTAGE]) - float(solver.state[VOLTAGE]))
        )
    time = point.periods * point.period
    volt = drive.link_voltage
    magnitude, square, impulse, _, device, _, source, energy, burnt, supplied = solver.state[2:]
    torque = (drive.magnet_flux + drive.quadrature_inductance * peak) * 3.0 * peak
    short = volt / point.resistance
    inflow = float(link.state[dc_link.CURRENT]) - float(supplied) if point.inductance > 0.0 else 0.0
    return {
        "currents": current_error / peak,
        "supplied": abs(inflow) / short,
        "voltage": voltage_error / volt,
        "magnitude": abs(totals[ledger.MAGNITUDE] - magnitude) / (peak * time),
        "square": abs(totals[ledger.SQUARE] - square) / (peak * peak * time),
        "impulse": abs(totals[ledger.IMPULSE] - impulse) / (torque * time),
        "device": abs(totals[ledger.DEVICE] - device) / (peak * time),
        "source": abs(link.totals[dc_link.SOURCE_CHARGE] - source) / (short * time),
        "bridge": abs(link.totals[dc_link.BRIDGE] - energy) / (volt * peak * time),
        "chopper": abs(link.totals[dc_link.BURNT] - burnt) / (volt * short * time),
    }


@pytest.mark.one_in(16)
@pytest.mark.parametrize(
    "point",
    [
        *(pytest.param(point, marks=pytest.mark.kernel) for point in POINTS),
        *map(_drawn, range(48)),
    ],
    ids=str,
)
def test_currents_and_link_agree_with_a_numerical_solver(
    interior: Callable[..., PmAcDrive], point: LinkedPoint
) -> None:
    apart = differences(interior, point)
    worst = max(apart, key=apart.__getitem__)
    assert apart[worst] <= AGREEMENT, f"{worst} apart by {apart[worst]:.1e} of its scale: {apart}"
