"""Instants at which the gates change: ratios, counter, dead time, and what goes on behind blocked gates."""

from __future__ import annotations

import numpy as np
import pytest

from drivegate_models.contract.duty.signals import LEG_HIGH, LEG_LOW, LEG_OFF, LEG_PWM
from drivegate_models.pm_ac.plant.drive import CENTRED, FALLING, RISING, Modulator
from drivegate_models.pm_ac.plant.modulator import (
    BLANKED,
    LOWER,
    UPPER,
    Gates,
    make_gates,
    schedule_gates,
    settled_ratio,
)

PERIOD = 1e-4


def schedule(
    gates: Gates,
    ratio: float,
    *,
    mode: int = LEG_PWM,
    alignment: int = CENTRED,
    dead_time: float = 0.0,
    counter_levels: float = 0.0,
) -> list[tuple[float, int]]:
    """Return the changes of the first leg's gate in a period (shares of it)."""
    modulator = Modulator(1, 1, counter_levels, dead_time, 0.0)
    schedule_gates(modulator, gates, np.full(3, ratio), np.full(3, mode, np.int64), alignment, PERIOD)
    count = int(gates.counts[0])
    return [(float(gates.times[0, k] / PERIOD), int(gates.gates[0, k])) for k in range(count)]


@pytest.mark.kernel
@pytest.mark.parametrize(
    ("alignment", "expected"),
    [
        (CENTRED, [(0.0, LOWER), (0.35, UPPER), (0.65, LOWER)]),
        (RISING, [(0.0, LOWER), (0.7, UPPER)]),
        (FALLING, [(0.0, UPPER), (0.3, LOWER)]),
    ],
)
def test_the_upper_switch_is_on_for_its_ratio(alignment: int, expected: list[tuple[float, int]]) -> None:
    found = schedule(make_gates(), 0.3, alignment=alignment)
    assert [gate for _, gate in found] == [gate for _, gate in expected], found
    assert [time for time, _ in found] == pytest.approx([time for time, _ in expected], abs=1e-15)


@pytest.mark.kernel
def test_two_halves_of_a_symmetric_carrier_make_a_whole_one() -> None:
    gates = make_gates()
    rising = schedule(gates, 0.4, alignment=RISING)
    falling = schedule(gates, 0.4, alignment=FALLING)
    assert rising[-1] == (pytest.approx(0.6), UPPER)
    assert falling == [(0.0, UPPER), (pytest.approx(0.4), LOWER)], "the switch stays on from half to half"


@pytest.mark.kernel
@pytest.mark.parametrize("ratio", [0.0, 1.0])
def test_limits_never_switch(ratio: float) -> None:
    gates = make_gates()
    schedule(gates, ratio)
    assert schedule(gates, ratio) == [(0.0, UPPER if ratio else LOWER)]


@pytest.mark.kernel
def test_dead_time_delays_every_turn_on() -> None:
    found = schedule(make_gates(), 0.5, dead_time=0.02 * PERIOD)
    assert [gate for _, gate in found] == [LOWER, BLANKED, UPPER, BLANKED, LOWER]
    assert [time for time, _ in found] == pytest.approx([0.0, 0.25, 0.27, 0.75, 0.77])


@pytest.mark.kernel
def test_a_pulse_shorter_than_the_dead_time_blanks_the_leg_and_no_more() -> None:
    found = schedule(make_gates(), 0.01, dead_time=0.03 * PERIOD)
    assert [gate for _, gate in found] == [LOWER, BLANKED, BLANKED, LOWER]
    assert found[-1][0] == pytest.approx(0.505 + 0.03), "the lower switch waits from its own command on"


@pytest.mark.kernel
def test_dead_time_goes_on_into_the_next_period() -> None:
    gates = make_gates()
    schedule(gates, 0.98, dead_time=0.05 * PERIOD)
    found = schedule(gates, 0.0, dead_time=0.05 * PERIOD)
    assert found[0] == (0.0, BLANKED), "the lower switch was commanded on shortly before the period's end"
    assert found[1] == (pytest.approx(0.04), LOWER)


@pytest.mark.kernel
def test_the_modulator_goes_on_behind_blocked_gates() -> None:
    gates, free = make_gates(), make_gates()
    assert schedule(gates, 0.98, mode=LEG_OFF, dead_time=0.05 * PERIOD) == [(0.0, BLANKED)]
    schedule(free, 0.98, dead_time=0.05 * PERIOD)
    released = schedule(gates, 0.5, dead_time=0.05 * PERIOD)
    assert released == schedule(free, 0.5, dead_time=0.05 * PERIOD)


@pytest.mark.kernel
def test_a_leg_is_held_high_or_low_whatever_its_ratio() -> None:
    gates = make_gates()
    assert schedule(gates, 0.3, mode=LEG_HIGH) == [(0.0, UPPER)]
    assert schedule(gates, 0.3, mode=LEG_LOW) == [(0.0, LOWER)]


@pytest.mark.kernel
@pytest.mark.parametrize(
    ("ratio", "expected"),
    [(0.12, 0.125), (0.01, 0.0), (0.99, 1.0), (-3.0, 0.0), (7.0, 1.0), (0.5, 0.5)],
)
def test_counter_and_minimum_pulse_round_the_ratio(ratio: float, expected: float) -> None:
    modulator = Modulator(counter_levels=64.0, minimum_pulse=2e-6)
    assert settled_ratio(modulator, ratio, PERIOD) == expected


@pytest.mark.kernel
@pytest.mark.parametrize("alignment", [CENTRED, RISING, FALLING])
def test_edges_lie_on_the_counts_of_a_counter_whatever_the_carrier(alignment: int) -> None:
    """A symmetric counter counts up in half a carrier period, which is a period of two updates and half of one."""
    levels = 8.0
    count = (0.5 if alignment == CENTRED else 1.0) / levels
    times = {0.0}
    for share in np.linspace(0.0, 1.0, 33):
        changes = schedule(make_gates(), float(share), alignment=alignment, counter_levels=levels)
        times |= {time for time, _ in changes}
    assert len(times) >= levels
    assert all(time / count == pytest.approx(round(time / count), abs=1e-9) for time in times)
