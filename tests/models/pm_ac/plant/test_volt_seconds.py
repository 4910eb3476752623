"""Means of the terminals' voltages against quadrature by a solver that shares no code with the plant."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from tests.models.pm_ac.plant.test_independent_solver import AXES, BLOCKED, MODULATED, Law, Point, Solver
from tests.models.pm_ac.plant.test_linked_solver import LinkedPoint, LinkedSolver

from drivegate_models.machine import ledger
from drivegate_models.pm_ac.plant.advance import advance_period, make_phases
from drivegate_models.pm_ac.plant.dc_link import RECTIFIER, charge_link
from drivegate_models.pm_ac.plant.drive import FALLING, Modulator, PmAcDrive
from drivegate_models.pm_ac.plant.linked_advance import advance_linked_period

AGREEMENT = 1e-9
"""Greatest difference of a mean from that of the solver, relative to the link's voltage."""


def on_terminals(solver: Solver, law: Law, time: float, state: np.ndarray) -> np.ndarray:
    """Return the voltages that dividers show; without any current they pull the terminals down to the lowest."""
    if law.signs != (0, 0, 0):
        return solver.voltages(law, time, state)
    turn = np.exp(1j * solver.angle(time))
    emf = (1j * solver.electrical * solver.drive.magnet_flux * turn * AXES.conj()).real
    return np.asarray(emf + max(solver.limits(leg)[0] - emf[leg] for leg in range(3)))


class Quadrature(Solver):
    """The state has three more entries: the integrals of the terminals' voltages."""

    def __init__(self, drive: PmAcDrive, point: Point) -> None:
        super().__init__(drive, point)
        self.state = np.concatenate([self.state, np.zeros(3)])

    def rate(self, law: Law, time: float, state: np.ndarray) -> np.ndarray:
        return np.concatenate([super().rate(law, time, state), on_terminals(self, law, time, state)])


class LinkedQuadrature(LinkedSolver):
    """The same on a link with a capacitor."""

    def __init__(self, drive: PmAcDrive, point: LinkedPoint) -> None:
        super().__init__(drive, point)
        self.state = np.concatenate([self.state, np.zeros(3)])

    def rate(self, law: Law, time: float, state: np.ndarray) -> np.ndarray:
        machine = super().rate(law, time, state)
        return np.concatenate([machine, on_terminals(self, law, time, state)])


DROPS = (1.2, 0.8)
POINTS = [
    Point(750, currents=(-3.0, 5.0)),
    Point(750, dead_time=2e-6, drops=DROPS, currents=(0.0, 0.3), ratio=0.1),
    Point(1000, modes=(BLOCKED,), currents=(-4.0, 5.0), periods=12),
    Point(2000, modes=(BLOCKED,), drops=DROPS, periods=6),
    Point(-9000, modes=(BLOCKED,), drops=DROPS, periods=12),
    Point(1500, modes=((1, 0, 0),), periods=4),
]
MORE = [
    Point(0, currents=(2.0, -1.0), dead_time=3e-6),
    Point(750, alignment=FALLING, dead_time=2e-6),
    Point(6000, modes=(MODULATED, BLOCKED), currents=(-5.0, 2.0), dead_time=2e-6, periods=12),
    Point(1500, modes=((1, 1, 0),), periods=12, currents=(0.0, 3.0)),
    Point(9000, modes=(BLOCKED,), changes={"quadrature_inductance": 34.88e-3}, periods=30),
]
LINKED = [
    LinkedPoint(750, drops=DROPS, dead_time=2e-6, source=RECTIFIER, capacitance=2e-5),
    LinkedPoint(1000, modes=(BLOCKED,), currents=(-4.0, 5.0), source=RECTIFIER, periods=8),
    LinkedPoint(1500, modes=((1, 0, 0),), periods=4, capacitance=2e-5, lost=60.0),
]


def _driven(interior: Callable[..., PmAcDrive], point: Point) -> PmAcDrive:
    return interior(
        modulator=Modulator(dead_time=point.dead_time),
        switch_drop=point.drops[0],
        diode_drop=point.drops[1],
        **point.changes,
    )


def worst_difference(interior: Callable[..., PmAcDrive], point: Point) -> float:
    """Return how far means over a period are from those of the solver, over the link's voltage (1)."""
    drive = _driven(interior, point)
    is_linked = isinstance(point, LinkedPoint)
    solver: Solver = Quadrature(drive, point)
    phases, totals = make_phases(follows_voltages=True), np.zeros(ledger.ENTRIES)
    if is_linked:
        drive = drive._replace(dc_link=point.constants)
        solver = LinkedQuadrature(drive, point)
        charge_link(phases.dc_link, point.link)
    phases.rotor_currents[:] = point.currents
    worst = 0.0
    for k in range(point.periods):
        modes = point.modes[k % len(point.modes)]
        angle = solver.angle(k * point.period)
        acting = point.ratios(angle), np.array(modes, np.int64)
        begin = drive, phases, angle, solver.speed
        end = point.alignment, point.period, totals
        if is_linked:
            phases.dc_link.state[4] = point.lost
            advance_linked_period(*begin, point.source_in(k), *acting, math.nan, *end)
            solver.begin_period(k)
        else:
            advance_period(*begin, point.link, *acting, *end)
        solver.state[-3:] = 0.0
        solver.run_period(k, modes)
        difference = (phases.volt_seconds - solver.state[-3:]) / (point.period * drive.link_voltage)
        worst = max(worst, float(np.abs(difference).max()))
        phases.volt_seconds[:] = 0.0
    return worst


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    "point", [*POINTS, *(pytest.param(point, marks=pytest.mark.nightly) for point in MORE)], ids=str
)
def test_means_agree_with_quadrature(interior: Callable[..., PmAcDrive], point: Point) -> None:
    assert worst_difference(interior, point) < AGREEMENT


@pytest.mark.parametrize("point", LINKED, ids=str)
def test_means_on_a_capacitor_agree_with_quadrature(
    interior: Callable[..., PmAcDrive], point: LinkedPoint
) -> None:
    assert worst_difference(interior, point) < AGREEMENT
