"""What the plant must do by symmetry, by scale and by the definitions of its parts."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest

from drivegate_models.contract.duty.signals import LEG_HIGH, LEG_LOW, LEG_OFF, LEG_PWM
from drivegate_models.machine import ledger
from drivegate_models.machine.advance_status import COMPLETED
from drivegate_models.pm_ac.plant.advance import PmAcPhases, advance_period, make_phases
from drivegate_models.pm_ac.plant.drive import CENTRED, Modulator, PmAcDrive, drifted, electrical_torque

PERIOD = 1e-4
THIRD = 2.0 * math.pi / 3.0
RATIOS = np.array([0.7, 0.42, 0.18])
CLOSE = 1e-12
ALIGNED = (LEG_HIGH, LEG_LOW, LEG_LOW)
ONE_OPEN = (LEG_HIGH, LEG_OFF, LEG_LOW)
BLOCKED = (LEG_OFF, LEG_OFF, LEG_OFF)
Factory = Callable[..., PmAcDrive]


@dataclass
class Result:
    """A machine after some periods."""

    phases: PmAcPhases
    totals: np.ndarray


def run(
    drive: PmAcDrive,
    *,
    angle: float = 0.4,
    speed: float = 120.0,
    link: float = 120.0,
    ratios: np.ndarray = RATIOS,
    modes: tuple[int, int, int] = (LEG_PWM, LEG_PWM, LEG_PWM),
    currents: tuple[float, float] = (-2.0, 3.0),
    period: float = PERIOD,
    periods: int = 3,
) -> Result:
    phases = make_phases(follows_torque=True)
    phases.rotor_currents[:] = currents
    totals = np.zeros(ledger.ENTRIES)
    for k in range(periods):
        status = advance_period(
            drive,
            phases,
            angle + k * drive.pole_pairs * speed * period,
            speed,
            link,
            ratios,
            np.array(modes, np.int64),
            CENTRED,
            period,
            totals,
        )
        assert status == COMPLETED
    return Result(phases, totals)


MODULATORS = [Modulator(), Modulator(dead_time=3e-6)]


@pytest.mark.kernel
@pytest.mark.parametrize("modulator", MODULATORS)
def test_exchanging_two_phases_turns_the_machine_round(interior: Factory, modulator: Modulator) -> None:
    drive = interior(modulator=modulator, diode_drop=0.8)
    forward = run(drive)
    backward = run(drive, angle=-0.4, speed=-120.0, ratios=RATIOS[[0, 2, 1]], currents=(-2.0, -3.0))
    np.testing.assert_allclose(backward.phases.currents[[0, 2, 1]], forward.phases.currents, rtol=1e-11)
    assert backward.totals[ledger.IMPULSE] == pytest.approx(-forward.totals[ledger.IMPULSE], rel=1e-11)
    assert backward.totals[ledger.UPPER] == pytest.approx(forward.totals[ledger.UPPER], rel=1e-11)


@pytest.mark.kernel
@pytest.mark.parametrize("modulator", MODULATORS)
def test_the_phases_are_alike(interior: Factory, modulator: Modulator) -> None:
    drive = interior(modulator=modulator, switch_drop=1.1)
    first = run(drive)
    turned = run(drive, angle=0.4 + THIRD, ratios=RATIOS[[2, 0, 1]])
    np.testing.assert_allclose(turned.phases.currents[[1, 2, 0]], first.phases.currents, rtol=1e-11)
    assert turned.totals[ledger.IMPULSE] == pytest.approx(first.totals[ledger.IMPULSE], rel=1e-11)


@pytest.mark.kernel
@pytest.mark.parametrize("modes", [ALIGNED, ONE_OPEN, BLOCKED])
def test_magnet_currents_and_rails_reversed_reverse_all_currents(
    interior: Factory, modes: tuple[int, int, int]
) -> None:
    drive = interior(switch_drop=1.1, diode_drop=0.8)
    first = run(drive, modes=modes, speed=400.0, periods=10)
    mirrored = tuple({LEG_HIGH: LEG_LOW, LEG_LOW: LEG_HIGH, LEG_OFF: LEG_OFF}[mode] for mode in modes)
    other = run(drifted(drive, 1.0, -1.0), modes=mirrored, speed=400.0, currents=(2.0, -3.0), periods=10)
    np.testing.assert_allclose(other.phases.currents, -first.phases.currents, rtol=1e-11, atol=1e-13)
    assert other.totals[ledger.IMPULSE] == pytest.approx(first.totals[ledger.IMPULSE], rel=1e-11)
    assert other.totals[ledger.UPPER] == pytest.approx(first.totals[ledger.UPPER], rel=1e-11)


@pytest.mark.kernel
def test_time_voltage_and_current_scale(interior: Factory) -> None:
    drive = interior(modulator=Modulator(dead_time=3e-6), switch_drop=1.0, diode_drop=0.8)
    first = run(drive)
    slower = drive._replace(
        direct_inductance=drive.direct_inductance * 2.0,
        quadrature_inductance=drive.quadrature_inductance * 2.0,
        magnet_flux=drive.magnet_flux * 2.0,
        modulator=drive.modulator._replace(dead_time=6e-6),
    )
    stretched = run(slower, speed=60.0, period=2.0 * PERIOD)
    np.testing.assert_allclose(stretched.phases.currents, first.phases.currents, rtol=CLOSE)
    greater = drive._replace(magnet_flux=drive.magnet_flux * 3.0, switch_drop=3.0, diode_drop=0.8 * 3.0)
    raised = run(greater, link=360.0, currents=(-6.0, 9.0))
    np.testing.assert_allclose(raised.phases.currents, 3.0 * first.phases.currents, rtol=1e-11)


@pytest.mark.kernel
@pytest.mark.parametrize("modes", [ALIGNED, BLOCKED, ONE_OPEN])
def test_an_advance_cut_in_parts_is_the_same(interior: Factory, modes: tuple[int, int, int]) -> None:
    drive = interior(diode_drop=0.8)
    whole = run(drive, modes=modes, periods=1, period=10.0 * PERIOD)
    parts = run(drive, modes=modes, periods=10)
    np.testing.assert_allclose(parts.phases.currents, whole.phases.currents, rtol=1e-11, atol=1e-12)
    for entry in (ledger.SQUARE, ledger.IMPULSE, ledger.UPPER, ledger.MAGNITUDE, ledger.PEAK):
        assert parts.totals[entry] == pytest.approx(whole.totals[entry], rel=1e-10, abs=1e-15)


@pytest.mark.kernel
def test_without_resistance_a_shorted_machine_at_standstill_keeps_its_currents(interior: Factory) -> None:
    result = run(interior(resistance=0.0), speed=0.0, modes=(LEG_LOW, LEG_LOW, LEG_LOW), periods=20)
    np.testing.assert_allclose(result.phases.rotor_currents, (-2.0, 3.0), rtol=1e-14)


@pytest.mark.kernel
def test_a_shorted_machine_at_standstill_decays_exponentially(interior: Factory) -> None:
    drive = interior()
    result = run(drive, speed=0.0, modes=(LEG_HIGH, LEG_HIGH, LEG_HIGH), periods=20)
    time = 20 * PERIOD
    expected = (
        -2.0 * math.exp(-drive.resistance / drive.direct_inductance * time),
        3.0 * math.exp(-drive.resistance / drive.quadrature_inductance * time),
    )
    np.testing.assert_allclose(result.phases.rotor_currents, expected, rtol=1e-13)
    assert result.totals[ledger.UPPER] == 0.0, "three legs on one rail take nothing from the link"


@pytest.mark.kernel
def test_blocked_gates_below_base_speed_carry_no_current_and_drag_the_shaft(interior: Factory) -> None:
    drive = interior(core_loss_conductance=2e-3)
    line_peak = math.sqrt(3.0) * drive.magnet_flux * drive.pole_pairs
    speed = 0.999 * 120.0 / line_peak
    result = run(drive, speed=speed, modes=BLOCKED, currents=(0.0, 0.0), periods=200)
    assert not np.any(result.phases.currents), "no line voltage exceeds that of the link"
    assert result.totals[ledger.PEAK] == 0.0
    power = speed * result.totals[ledger.CORE_DRAG_IMPULSE] / (200 * PERIOD)
    induced = drive.pole_pairs * speed * drive.magnet_flux
    assert power == pytest.approx(1.5 * 2e-3 * induced**2, rel=1e-12), "the shaft supplies the core loss"
    faster = run(drive, speed=1.01 * speed, modes=BLOCKED, currents=(0.0, 0.0), periods=200)
    assert faster.totals[ledger.UPPER] < 0.0, "beyond that it charges the link"


@pytest.mark.kernel
def test_core_loss_is_that_of_the_mean_flux_voltage(interior: Factory) -> None:
    drive = interior(core_loss_conductance=2e-3)
    start, angle, speed = (-2.0, 3.0), 0.4, 120.0
    result = run(drive, currents=start, angle=angle, speed=speed, periods=1)

    def flux(currents: np.ndarray, at: float) -> complex:
        direct = drive.direct_inductance * currents[0] + drive.magnet_flux
        return complex(direct, drive.quadrature_inductance * currents[1]) * complex(np.exp(1j * at))

    change = flux(result.phases.rotor_currents, angle + 2 * speed * PERIOD) - flux(np.array(start), angle)
    assert result.totals[ledger.CORE_SOURCE] == pytest.approx(
        1.5 * 2e-3 * abs(change) ** 2 / PERIOD, rel=1e-10
    )
    assert result.totals[ledger.CORE_DRAG_IMPULSE] == 0.0


@pytest.mark.kernel
@pytest.mark.parametrize("modes", [ALIGNED, BLOCKED])
@pytest.mark.parametrize("speed", [60.0, 900.0])
def test_torque_stays_within_its_extremes_and_reaches_them(
    interior: Factory, modes: tuple[int, int, int], speed: float
) -> None:
    drive = interior()
    whole = run(drive, modes=modes, speed=speed, periods=1, period=2e-3)
    lowest, highest = whole.phases.torque_bounds
    pieces = 200
    torques = [electrical_torque(drive, -2.0, 3.0)]
    phases, totals = make_phases(), np.zeros(ledger.ENTRIES)
    phases.rotor_currents[:] = (-2.0, 3.0)
    for k in range(pieces):
        advance_period(
            drive,
            phases,
            0.4 + k * 2 * speed * 2e-3 / pieces,
            speed,
            120.0,
            RATIOS,
            np.array(modes, np.int64),
            CENTRED,
            2e-3 / pieces,
            totals,
        )
        torques.append(electrical_torque(drive, *phases.rotor_currents))
    span = highest - lowest
    assert lowest - 1e-11 * span <= min(torques)
    assert max(torques) <= highest + 1e-11 * span
    assert min(torques) - lowest < 1e-3 * span, "dense samples come close to the least torque"
    assert highest - max(torques) < 1e-3 * span, "dense samples come close to the greatest torque"


def _mean_voltages(drive: PmAcDrive, ratios: np.ndarray, modes: tuple[int, int, int]) -> complex:
    """Return the mean voltage vector of a period, from what it makes of the flux at standstill."""
    result = run(drive, angle=0.0, speed=0.0, ratios=ratios, modes=modes, currents=(0.0, 0.0), periods=1)
    direct, quadrature = result.phases.rotor_currents
    flux = complex(drive.direct_inductance * direct, drive.quadrature_inductance * quadrature)
    return flux / PERIOD


@pytest.mark.kernel
def test_the_linear_limit_is_the_link_over_root_three(interior: Factory) -> None:
    drive = interior(resistance=0.0)
    limit = 120.0 / math.sqrt(3.0)
    for angle in np.linspace(0.0, 2.0 * math.pi, 37):
        phases = limit * np.cos(angle - THIRD * np.arange(3)) / 120.0
        ratios = 0.5 + phases - 0.5 * (phases.max() + phases.min())
        assert ratios.min() >= -1e-15, "the least ratio of the greatest linear voltage"
        assert ratios.max() <= 1.0 + 1e-15, "the greatest one"
        made = _mean_voltages(drive, ratios, (LEG_PWM, LEG_PWM, LEG_PWM))
        assert made == pytest.approx(complex(limit * np.exp(1j * angle)), abs=1e-9)


@pytest.mark.kernel
def test_the_fundamental_of_six_steps_is_two_links_over_pi(interior: Factory) -> None:
    drive = interior(resistance=0.0)
    order = [(1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1), (1, 0, 1)]
    fundamental = 0j
    for k, upper in enumerate(order):
        voltage = _mean_voltages(drive, RATIOS, tuple(LEG_HIGH if on else LEG_LOW for on in upper))
        begin, end = (k - 0.5) * math.pi / 3.0, (k + 0.5) * math.pi / 3.0
        fundamental += voltage * (np.exp(-1j * end) - np.exp(-1j * begin)) / (-1j) / (2.0 * math.pi)
    assert abs(fundamental) == pytest.approx(2.0 * 120.0 / math.pi, rel=1e-12)


@pytest.mark.kernel
@pytest.mark.parametrize("modulator", MODULATORS)
@pytest.mark.parametrize("follows_torque", [False, True])
def test_a_leg_that_carries_a_current_turns_a_switch_on_and_off_in_a_period(
    interior: Factory, modulator: Modulator, follows_torque: bool
) -> None:
    drive = interior(modulator=modulator, turn_on_energy=1e-3, turn_off_energy=1e-5, diode_drop=0.7)
    phases = make_phases(follows_torque=follows_torque)
    lost = []
    # The last leg stands, the others chop; then all are blocked.
    for modes in ((LEG_PWM, LEG_PWM, LEG_LOW), (LEG_PWM, LEG_PWM, LEG_LOW), (LEG_OFF, LEG_OFF, LEG_OFF)):
        if not lost:
            phases.rotor_currents[:] = (-2.0, 3.0)
        totals = np.zeros(ledger.ENTRIES)
        status = advance_period(
            drive,
            phases,
            0.4,
            0.0,
            120.0,
            np.array([0.55, 0.5, 0.5]),
            np.array(modes, np.int64),
            CENTRED,
            PERIOD,
            totals,
        )
        assert status == COMPLETED
        lost.append(float(totals[ledger.SWITCHING]))
        assert ledger.source_energy(totals) == pytest.approx(
            totals[ledger.UPPER] + totals[ledger.LOWER] + lost[-1]
        )
    assert all(abs(current) > 0.1 for current in phases.currents)
    assert lost[1] == pytest.approx(2.0 * (1e-3 + 1e-5)), "its diode takes over without a loss"
    # Carried by the lower switch: the legs whose current is negative.
    assert lost[2] == pytest.approx(np.count_nonzero(phases.currents < 0.0) * 1e-5)
