"""The periodic state of the star: it is where every transient ends, and it repeats."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from drivegate_models.machine import ledger
from drivegate_models.machine.period import PERIODIC
from drivegate_models.star.periodic import periodic_start, torque_period
from drivegate_models.star.plant.drive import ON_PWM, PWM_ON, UPPER_ONLY, StarDrive
from drivegate_models.star.plant.phases import advance_phases, make_phases
from drivegate_models.steady.steady_state import KEPT_TIME, advance_with_extremes, steady_state
from drivegate_models.steady.waveform import periodic_waveforms

POINTS: list[tuple[dict[str, Any], float, float, float]] = [
    ({}, 500.0, 0.0, 20.0),
    ({}, 1500.0, 70.9, 40.0),
    ({}, 3500.0, 10.0, 0.0),
    ({"regulation": UPPER_ONLY}, 500.0, 10.0, 20.0),
    ({"regulation": PWM_ON}, 600.0, 10.0, 20.0),
    ({"regulation": ON_PWM}, 600.0, 10.0, 20.0),
    ({"phases": 5, "window_deg": 144.0, "flat_deg": 98.0}, 1200.0, 50.0, 20.0),
    ({"phases": 7}, 700.0, 20.0, 20.0),
    ({"window_deg": 150.0, "flat_deg": 150.0, "switch_drop": 0.9, "diode_drop": 0.7}, 1500.0, 46.0, 35.0),
]
# The others take no branch that these do not take, which is what is tested without compilation.
BRANCHES = [*POINTS[:6], POINTS[7]]


@pytest.mark.parametrize(
    ("constants", "rpm", "advance_deg", "reference"),
    [pytest.param(*point, marks=pytest.mark.kernel if point in BRANCHES else ()) for point in POINTS],
)
def test_every_transient_ends_in_the_periodic_state(
    star: Callable[..., StarDrive],
    constants: dict[str, Any],
    rpm: float,
    advance_deg: float,
    reference: float,
) -> None:
    # So much resistance that the start is forgotten soon.
    drive = star(core_loss_conductance=3e-3, resistance=0.5, **constants)
    speed, advance = rpm * math.pi / 30.0, math.radians(advance_deg)
    state = steady_state(drive, speed, reference, advance)
    assert state.certified == PERIODIC
    phases = make_phases(drive, KEPT_TIME)
    cycle = 2.0 * math.pi / (drive.pole_pairs * speed)
    settling = math.ceil(30.0 * drive.inductance / drive.resistance / cycle) + 3
    for _ in range(settling):
        advance_phases(
            drive, phases, 0.0, speed, 48.0, 48.0, reference, advance, cycle, np.zeros(ledger.ENTRIES)
        )
    totals = np.zeros(ledger.ENTRIES)
    _, lowest, highest = advance_with_extremes(
        drive, phases, 0.0, speed, 48.0, reference, advance, cycle, totals
    )
    means = totals / cycle
    current = max(state.current_peak, 1.0)
    for name, value, scale in [
        ("torque", means[ledger.IMPULSE], drive.emf_constant * current),
        ("torque_lowest", lowest, drive.emf_constant * current),
        ("torque_highest", highest, drive.emf_constant * current),
        ("current_sum", means[ledger.MAGNITUDE], current),
        ("exchanged_power", means[ledger.EXCHANGED], 48.0 * current),
        ("source_power", means[ledger.UPPER] + means[ledger.LOWER], 48.0 * current),
        ("core_source_power", means[ledger.CORE_SOURCE], 3e-3 * 96.0**2),
        ("current_peak", totals[ledger.PEAK], current),
    ]:
        difference = abs(getattr(state, name) - value) / scale
        assert difference <= 1e-9, (
            f"{name}: {getattr(state, name)!r} by shooting, {value!r} in the transient, apart by {difference:.1e}"
        )


def test_most_states_with_a_band_are_certified_and_the_others_marked(star: Callable[..., StarDrive]) -> None:
    drive = star(hysteresis_band=0.25)
    draw = np.random.default_rng(0)
    certified = []
    for _ in range(60):
        speed, reference, advance = draw.uniform(50, 300), draw.uniform(2, 43), draw.uniform(0, 1.5)
        state = steady_state(drive, float(speed), float(reference), float(advance))
        certified.append(state.certified)
        assert math.isfinite(state.torque)
    assert 0.5 <= np.mean(certified) < 1.0, f"{np.mean(certified):.0%} are periodic"


def test_states_with_a_band_repeat_after_several_torque_periods(star: Callable[..., StarDrive]) -> None:
    drive = star(hysteresis_band=0.25)
    draw = np.random.default_rng(1)
    found = set()
    for _ in range(40):
        speed, reference, advance = draw.uniform(80, 160), draw.uniform(8, 30), draw.uniform(0.2, 1.2)
        work, slices = make_phases(drive), make_phases(drive)
        periods = periodic_start(drive, work, slices, speed, 48.0, reference, advance)
        if periods <= PERIODIC:
            continue
        found.add(periods)
        state = steady_state(drive, speed, reference, advance)
        assert state.certified == PERIODIC
        # Two whole rounds of the state after another: twice the same, whatever shift and cycle are to each other.
        electrical = drive.pole_pairs * speed
        length = periods * torque_period(drive, electrical)
        angle = 0.5 * (math.pi - drive.window) - advance
        for turn in range(2 * drive.phases):
            totals = np.zeros(ledger.ENTRIES)
            start = angle + turn * electrical * length
            advance_phases(drive, work, start, speed, 48.0, 48.0, reference, advance, length, totals)
            for name, entry in [("torque", ledger.IMPULSE), ("current_sum", ledger.MAGNITUDE)]:
                difference = totals[entry] / length / getattr(state, name) - 1.0
                assert abs(difference) <= 1e-8, (
                    f"{name} differs by {difference:.1e} in round {turn} of {periods} torque periods "
                    f"at {speed!r} rad/s, {reference!r} A, {advance!r} rad"
                )
    assert len(found) >= 3, f"states repeat after {sorted(found)} torque periods alone"


def test_waveforms_are_certified_where_one_cycle_is_whole_periods(star: Callable[..., StarDrive]) -> None:
    drive = star(hysteresis_band=0.25)
    draw = np.random.default_rng(1)
    seen = set()
    for _ in range(120):
        point = draw.uniform(80, 160), draw.uniform(8, 30), draw.uniform(0.2, 1.2)
        speed, reference, advance = (float(value) for value in point)
        work, slices = make_phases(drive), make_phases(drive)
        periods = periodic_start(drive, work, slices, speed, 48.0, reference, advance)
        if periods not in (2, 3, 4, 5) or periods in seen:
            continue
        seen.add(periods)
        waves = periodic_waveforms(drive, speed, reference, advance)
        assert waves.certified == (periods in (2, 3)), f"of a cycle's six torque periods, {periods} repeat"
        ends = np.max(np.abs(waves.currents[:, -1] - waves.currents[:, 0]))
        assert (ends <= 1e-6) == waves.certified, (
            f"after {periods} periods the currents are {ends:.1e} A apart"
        )
    assert len(seen) >= 3, f"there are only {seen} periods to test"


@pytest.mark.kernel
def test_phases_repeat_each_other_in_the_waveforms(star: Callable[..., StarDrive]) -> None:
    waves = periodic_waveforms(star(), 157.0, 40.0, 1.2)
    assert waves.certified
    assert np.max(np.abs(waves.currents.sum(axis=0))) <= 1e-12 * np.max(waves.currents)
    third = waves.cycle / 3.0
    grid = np.linspace(0.0, 2.0 * third, 200)
    first = np.interp(grid, waves.times, waves.currents[0])
    second = np.interp(grid + third, waves.times, waves.currents[1])
    np.testing.assert_allclose(second, first, atol=0.02)
