"""What a controller of duty ratios senses of the terminals' mean voltages, and the filter that they may pass."""

from __future__ import annotations

from collections.abc import Callable
from math import exp
from typing import Any, Final

import numpy as np
import pytest
from scipy.signal import lfilter
from tests.models.duty_runs import PERIOD
from tests.models.pm_ac.recorded_senses import Recorded, motoring, recorded

from drivegate_models.pm_ac.mean_voltages import sensed_mean_voltages
from drivegate_models.pm_ac.plant.drive import Modulator, PmAcDrive
from drivegate_models.pm_ac.sensing import ideal_duty_sensors
from drivegate_models.pm_ac.turning import Turning

Factory = Callable[..., PmAcDrive]
MEANS: Final = {"mean_voltages": sensed_mean_voltages(PERIOD)}
DUTIES: Final = ("first_duty", "second_duty", "third_duty")


def commanded(shown: Recorded) -> np.ndarray:
    """Return the mean voltages that ideal legs make of the commands of each step, shape (n, 3) (V)."""
    commands = shown.run.commands
    return np.column_stack([commands[name] for name in DUTIES]) * shown.drive.link_voltage


@pytest.mark.parametrize("every", [1, 3])
def test_ideal_legs_show_their_duty_ratios(interior: Factory, every: int) -> None:
    drive = interior(modulator=Modulator(control_every=every))
    shown = recorded(drive, 150.0, 40, motoring(drive), **MEANS)
    seen = shown.senses["mean_voltages"]
    # An answer acts after one period, and the period after that shows it.
    assert seen[2:] == pytest.approx(commanded(shown)[:-2], abs=1e-9)
    assert (seen[0] == shown.senses["phase_voltages"][0]).all(), "no period has ended in the first step"


def test_dead_time_and_drops_show_by_the_sign_of_the_current(interior: Factory) -> None:
    dead, drop = 2e-6, 0.9
    drive = interior(modulator=Modulator(dead_time=dead), switch_drop=drop, diode_drop=drop)
    shown = recorded(drive, 150.0, 400, motoring(drive, 1.5), **MEANS)
    seen, currents = shown.senses["mean_voltages"], shown.currents
    is_sure = (np.abs(currents[1:-1]) > 2.0) & (np.abs(currents[2:]) > 2.0)
    lost = np.sign(currents[2:]) * (dead / PERIOD * (drive.link_voltage + 2.0 * drop) + drop)
    # While the diode conducts in a dead time, its drop and that of the switch are on the same side.
    expected = commanded(shown)[:-2] - lost + np.sign(currents[2:]) * 2.0 * drop * dead / PERIOD
    assert is_sure.sum() > 100
    assert seen[2:][is_sure] == pytest.approx(expected[is_sure], abs=1e-9)


def test_the_filter_follows_the_means_of_the_periods(interior: Factory) -> None:
    lag, drive = 4.0 * PERIOD, interior()
    plain = recorded(drive, 150.0, 60, motoring(drive), **MEANS).senses["mean_voltages"]
    filtered = recorded(drive, 150.0, 60, motoring(drive), mean_voltages=sensed_mean_voltages(PERIOD, lag))
    share = 1.0 - exp(-PERIOD / lag)
    begin = (1.0 - share) * plain[:1]
    expected, _ = lfilter([share], [1.0, share - 1.0], plain[1:], axis=0, zi=begin)
    assert filtered.senses["mean_voltages"][1:] == pytest.approx(expected, abs=1e-9)


def test_the_run_is_the_same_bit_for_bit_whether_they_are_sensed_or_not(interior: Factory) -> None:
    drive = interior(modulator=Modulator(dead_time=2e-6), switch_drop=0.9, diode_drop=0.7)
    without = recorded(drive, 150.0, 60, motoring(drive))
    shown = recorded(drive, 150.0, 60, motoring(drive), **MEANS)
    assert shown.run.trace.tobytes() == without.run.trace.tobytes()
    assert np.isnan(without.senses["mean_voltages"]).all()
    again = recorded(drive, 150.0, 60, motoring(drive), **MEANS)
    assert again.senses["mean_voltages"].tobytes() == shown.senses["mean_voltages"].tobytes()


def test_a_bridge_that_is_off_shows_the_mean_of_the_emf(interior: Factory) -> None:
    drive = interior(diode_drop=0.7)
    shown = recorded(drive, 150.0, 5, motoring(drive), resting=4, waiting=30, **MEANS)
    seen = shown.senses["mean_voltages"]
    assert (seen[:5] == -drive.diode_drop).all()
    # Over a small angle the mean is that of both ends, except where another terminal becomes the lowest.
    ends = shown.senses["phase_voltages"]
    lowest = ends.argmin(axis=1)
    stays = lowest[5:34] == lowest[4:33]
    middle = 0.5 * (ends[4:33] + ends[5:34])
    assert stays.sum() > 20
    assert seen[5:34][stays] == pytest.approx(middle[stays], abs=0.02)


def test_turns_before_a_run_show_the_mean_of_what_acts(interior: Factory) -> None:
    drive, turns = interior(), 50
    answer, acting = motoring(drive), []

    def noting(sense: Any, command: Any) -> None:
        answer(sense, command)
        acting.append([command[name] * drive.link_voltage for name in DUTIES])

    turning = Turning(turns, 150.0, ideal_duty_sensors())
    shown = recorded(drive, 150.0, 5, noting, turning=turning, **MEANS)
    seen, expected = shown.senses["mean_voltages"][2:turns], np.array(acting)[: turns - 2]
    # The neutral's place is not that of the commands.
    assert np.diff(seen, axis=1) == pytest.approx(np.diff(expected, axis=1), abs=1e-9)
