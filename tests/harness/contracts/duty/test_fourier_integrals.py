"""Amplitudes by Fourier integrals, against signals whose amplitudes are known."""

from __future__ import annotations

import numpy as np
import pytest

from drivegate.contracts.duty.torque import Stretches, amplitudes


def test_a_square_wave_has_its_amplitudes_whatever_its_stretches() -> None:
    # Ten turns in 2 s, with jumps within uneven stretches' ends only.
    ends = np.unique(np.concatenate([np.linspace(0.0, 2.0, 21), np.linspace(0.0, 2.0, 38)]))
    starts, lengths = ends[:-1], np.diff(ends)
    means = 3.0 + np.where(np.floor((starts + 1e-9) * 10.0) % 2 == 0.0, 1.0, -1.0)
    found = amplitudes(Stretches(starts, lengths, means, np.zeros_like(means)), 80)
    for order in (1, 3, 5, 7):
        assert found[10 * order - 1] == pytest.approx(4.0 / (np.pi * order), rel=1e-12), order
    # The window leaves nothing beyond the neighbours of a line.
    assert np.max(found[[4, 14, 19, 39]]) < 1e-12


def test_straight_stretches_are_integrated_as_such() -> None:
    # A triangle between 0 and 1, four turns in 1 s, of two straight stretches a turn, and the same of eight.
    for pieces in (1, 4):
        ends = np.linspace(0.0, 1.0, 8 * pieces + 1)
        values = 1.0 - np.abs((8.0 * ends) % 2.0 - 1.0)
        signal = Stretches(ends[:-1], np.diff(ends), 0.5 * (values[1:] + values[:-1]), np.diff(values))
        found = amplitudes(signal, 24)
        assert found[3] == pytest.approx(4.0 / np.pi**2, rel=1e-12)
        assert found[11] == pytest.approx(4.0 / (9.0 * np.pi**2), rel=1e-12)


def test_the_mean_is_no_part_of_the_spectrum() -> None:
    ones = np.ones(7)
    assert np.max(amplitudes(Stretches(np.arange(7.0), ones, 5.0 * ones, 0.0 * ones), 6)) < 1e-12
