"""Ideal modulation: on ideal switches by hand, with dead time, drops and counter compensated, and where it ends."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from math import inf, pi, sqrt

import numpy as np
import pytest

from drivegate_models.contract.duty.signals import LEG_PWM
from drivegate_models.pm_ac.fundamental import steady_voltages
from drivegate_models.pm_ac.ideal_ripple import CORRECTED, ideal_swing, spread_samples
from drivegate_models.pm_ac.modulation_kind import (
    CONTINUOUS,
    DPWM_1,
    DPWM_MAX,
    DPWM_MIN,
    MODULATION_NUMBERS,
)
from drivegate_models.pm_ac.plant.drive import Modulator, PmAcDrive
from drivegate_models.pm_ac.ripple import commanded_swing
from drivegate_models.pm_ac.zero_sequence import NO_RAIL, write_ratios

PERIOD = 1e-4
LINK = 96.0
SPEED = 20.0
FAST = 100.0
CURRENTS = (0.0, 12.0)
Factory = Callable[..., PmAcDrive]


def torque_of(drive: PmAcDrive, quadrature: float) -> float:
    """Return the torque of a current across the magnet's axis."""
    return 1.5 * drive.pole_pairs * drive.magnet_flux * quadrature


@pytest.mark.kernel
@pytest.mark.parametrize("current", [5.0, -5.0])
def test_ideal_modulation_at_standstill_swings_by_what_falls_off_in_one_zero_vector(
    current: float, surface: Factory
) -> None:
    drive = surface()
    swing = ideal_swing(drive, 0.0, LINK, (0.0, current), ignored=2, watched=2, period=PERIOD)
    needed = drive.resistance * abs(current)
    # Both zero vectors last equally long, as they do under even ones, and the current falls off in each.
    zero = (0.5 - 0.5 * sqrt(3.0) * needed / LINK) * PERIOD
    expected = torque_of(drive, needed / drive.quadrature_inductance * zero)
    # What falls off is less at the end of a zero vector than at its start, by R t / L of itself.
    assert swing == pytest.approx(expected, rel=drive.resistance * PERIOD / drive.quadrature_inductance)


@pytest.mark.kernel
def test_ideal_modulation_has_even_zero_vectors(surface: Factory) -> None:
    # Two legs have the same voltage there, so that they are left out of the middle without a zero sequence.
    drive = surface(resistance=1.0)
    voltage = drive.resistance * 20.0
    quadrature = 20.0 * 0.5 * sqrt(3.0)
    swing = ideal_swing(drive, 0.0, LINK, (10.0, quadrature), ignored=2, watched=2, period=PERIOD)
    zero = 0.5 * (1.0 - 1.5 * voltage / LINK) * PERIOD
    expected = torque_of(drive, drive.resistance * quadrature / drive.quadrature_inductance * zero)
    assert swing == pytest.approx(expected, rel=drive.resistance * PERIOD / drive.quadrature_inductance)


@pytest.mark.kernel
@pytest.mark.parametrize("kind", [DPWM_MIN, DPWM_MAX])
def test_a_clamped_leg_leaves_one_zero_vector_of_twice_the_length(kind: int, surface: Factory) -> None:
    drive = surface()
    swing = ideal_swing(drive, 0.0, LINK, (0.0, 5.0), ignored=2, watched=2, period=PERIOD, kind=kind)
    needed = drive.resistance * 5.0
    zero = (1.0 - sqrt(3.0) * needed / LINK) * PERIOD
    expected = torque_of(drive, needed / drive.quadrature_inductance * zero)
    assert swing == pytest.approx(expected, rel=drive.resistance * PERIOD / drive.quadrature_inductance)


def turning_swing(drive: PmAcDrive, kind: int = CONTINUOUS, speed: float = SPEED) -> float:
    """Return the ideal's swing over a sixth of a cycle, at a current that is far from zero on average."""
    watched = round(pi / 3.0 / (drive.pole_pairs * speed * PERIOD))
    return ideal_swing(drive, speed, LINK, CURRENTS, ignored=600, watched=watched, period=PERIOD, kind=kind)


@pytest.fixture(scope="module")
def plain_swing(surface: Factory) -> Callable[..., float]:
    """Return the ideal's swing without errors, which many of these tests compare with, computed once."""
    return cache(lambda updates=1: turning_swing(real(surface, updates)))


def uncompensated_swing(drive: PmAcDrive, speed: float = SPEED) -> float:
    """Return the swing under the duty ratios that suit ideal switches."""
    watched = round(pi / 3.0 / (drive.pole_pairs * speed * PERIOD))
    turning = drive.pole_pairs * speed * PERIOD
    direct, quadrature = steady_voltages(drive, drive.pole_pairs * speed, *CURRENTS)
    ratios = np.zeros((600 + watched, 3))
    for number in range(len(ratios)):
        angle = (number + 0.5) * turning
        along = np.cos(angle) * direct - np.sin(angle) * quadrature
        across = np.sin(angle) * direct + np.cos(angle) * quadrature
        write_ratios(ratios[number], along, across, LINK, NO_RAIL)
    legs = np.full(ratios.shape, LEG_PWM, np.int64)
    return commanded_swing(
        drive,
        CURRENTS,
        0.0,
        speed,
        np.full(len(ratios), LINK),
        ratios,
        legs,
        first=0,
        ignored=600,
        period=PERIOD,
    )


def real(surface: Factory, updates: int = 1, **errors: float) -> PmAcDrive:
    """Make a drive whose bridge or modulator has errors."""
    drops = {name: errors.pop(name) for name in ("switch_drop", "diode_drop") if name in errors}
    return surface(modulator=Modulator(updates=updates, **errors), **drops)


@pytest.mark.parametrize(
    "errors",
    [
        pytest.param({"dead_time": 5e-6}, id="dead time"),
        pytest.param({"switch_drop": 4.0, "diode_drop": 4.0}, id="drops"),
        # It takes every branch that one of them takes, which is what is tested without compilation.
        pytest.param({"dead_time": 3e-6, "switch_drop": 3.0}, id="both", marks=pytest.mark.kernel),
    ],
)
@pytest.mark.parametrize("updates", [0, 1, 2], ids=["sawtooth", "single", "double"])
def test_the_ideal_compensates_what_a_controller_can_know(
    updates: int, errors: dict[str, float], surface: Factory, plain_swing: Callable[..., float]
) -> None:
    plain, rough = plain_swing(updates), real(surface, updates, **errors)
    compensated = turning_swing(rough)
    # Zero vectors are none where each leg has a drop by the sign of its current, and no duty ratio changes that.
    assert 0.9 * plain < compensated < 1.5 * plain
    assert compensated < 0.6 * uncompensated_swing(rough)


@pytest.mark.kernel
@pytest.mark.parametrize("levels", [50.0, 200.0])
def test_what_a_counter_rounds_remains(
    levels: float, surface: Factory, plain_swing: Callable[..., float]
) -> None:
    plain, coarse = plain_swing(), turning_swing(real(surface, counter_levels=levels))
    drive = surface()
    # In a period each leg rounds by half a step at most, and a fifth of the flux that has gathered is taken back.
    step = torque_of(drive, LINK * PERIOD / levels / drive.quadrature_inductance)
    assert plain + 0.5 * step < coarse < plain + 2.0 * step / CORRECTED


@pytest.mark.kernel
@pytest.mark.parametrize(
    ("kind", "shortest", "is_ideal"),
    [
        # At 93 % of the voltage the shortest pulse takes 3.5 % of the period, and next to a clamped leg 7 %.
        pytest.param(CONTINUOUS, 1.2e-6, True, id="longer pulses"),
        pytest.param(CONTINUOUS, 1.8e-6, False, id="pulses that are hardly longer"),
        pytest.param(CONTINUOUS, 2e-5, False, id="shorter pulses"),
        pytest.param(DPWM_1, 4.5e-6, True, id="longer gaps"),
        pytest.param(DPWM_1, 5.5e-6, False, id="gaps that are hardly longer"),
        pytest.param(DPWM_MIN, 1e-6, False, id="a pulse that vanishes where another leg is clamped"),
    ],
)
def test_no_modulation_is_ideal_where_the_modulator_omits_pulses(
    kind: int, shortest: float, is_ideal: bool, surface: Factory
) -> None:
    plain, omitting = (
        turning_swing(real(surface, minimum_pulse=pulse), kind, speed=FAST) for pulse in (0.0, shortest)
    )
    assert omitting == (plain if is_ideal else inf)


@pytest.mark.kernel
def test_what_compensates_dead_time_shortens_pulses(surface: Factory) -> None:
    dead, brief = {"dead_time": 1e-6}, {"minimum_pulse": 1.2e-6}
    swings = [turning_swing(real(surface, **errors), speed=FAST) for errors in (dead, brief, dead | brief)]
    assert np.isfinite(swings).tolist() == [True, True, False]


@pytest.mark.kernel
@pytest.mark.parametrize("kind", MODULATION_NUMBERS.values(), ids=MODULATION_NUMBERS)
def test_no_kind_of_modulation_has_less_ripple_than_space_vectors(
    kind: int, surface: Factory, plain_swing: Callable[..., float]
) -> None:
    assert turning_swing(surface(), kind) >= plain_swing() * (1.0 - 1e-9)


@pytest.mark.parametrize("every", [1, 3])
def test_the_errors_of_nothing_change_nothing(every: int, surface: Factory) -> None:
    plain = surface(modulator=Modulator(control_every=every))
    # A counter of so many steps rounds next to nothing.
    fine = surface(modulator=Modulator(control_every=every, counter_levels=1e9))
    assert turning_swing(fine) == pytest.approx(turning_swing(plain), rel=1e-5)


@pytest.mark.parametrize(
    ("samples", "watched"), [(80.0, 240), (80.0, 80), (20.0, 240), (3.5, 240), (3.3301, 240)]
)
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_spread_samples_lie_at_a_place_of_their_own_in_each_part_of_a_cycle(
    samples: float, watched: int, sense: float
) -> None:
    part = pi / 3.0 / PERIOD
    speed, periods = spread_samples(sense * part / samples, part, watched)
    assert speed == pytest.approx(sense * part / samples, rel=0.005)
    places = np.sort(np.arange(periods) * abs(speed) % part)
    assert places[0] == 0.0
    assert np.diff(places, append=part) == pytest.approx(np.full(periods, part / periods), rel=1e-6)
    assert part / periods <= abs(speed) / 7.9


def test_a_slow_speed_needs_no_spread_samples() -> None:
    assert spread_samples(1.0, 500.0, 500) == (1.0, 500)


def test_what_dead_time_leaves_depends_on_where_samples_lie(surface: Factory) -> None:
    drive = surface(
        modulator=Modulator(dead_time=3e-6),
        pole_pairs=4,
        resistance=0.01,
        direct_inductance=0.147e-3,
        quadrature_inductance=0.344e-3,
        magnet_flux=0.0717,
        link_voltage=350.0,
    )
    part, speed = pi / 3.0 / 4.0 * 8000.0, pi / 3.0 / 4.0 * 100.0

    def swing(speed: float, watched: int) -> float:
        currents = (-67.6, 170.8)
        return ideal_swing(drive, speed, 350.0, currents, ignored=400, watched=watched, period=1.25e-4)

    assert swing(speed, 480) == pytest.approx(swing(speed, 240), rel=1e-6)
    assert swing(*spread_samples(speed, part, 240)) > 1.07 * swing(speed, 240)
