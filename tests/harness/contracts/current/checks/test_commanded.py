"""What of the range of the means counts for k2: what the command moves, but not a beat of the hysteresis band."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import lsq_linear
from tests.harness.contracts.current.checks.test_convergence import CONVERGENCE

from drivegate.contracts.current.checks.commanded import STEEPEST, commanded_spread
from drivegate_models.loop.observation import WindowObservation

DEGREE = math.radians(1.0)
BEAT = 40.0 + 2.0 * np.sin(np.arange(40.0))
"""Means of a current sum that beats by 10 % (A)."""


def commanded(sums, reference_share=0.0, degrees=0.0, place=20):
    """A window in which reference and angle move once, at a mean, with the means of the current sum."""
    moved = np.arange(len(sums)) >= place
    means = np.column_stack((sums, 10.0 * (1.0 + reference_share * moved), 0.9 + degrees * DEGREE * moved))
    return {"REFERENCE": 10.0, "CURRENT_SUM": 40.0, "MEANS": means}


@pytest.mark.parametrize("check", ["CNV-1", "CNV-3", "ROB-1", "ROB-3"])
@pytest.mark.parametrize(
    "command",
    # One step of the search, its inner loop's answer to the beat, and both.
    [{"degrees": 0.24}, {"reference_share": 0.02}, {"reference_share": 0.02, "degrees": 0.24}],
)
def test_a_beat_is_not_the_commands_because_that_moves_meanwhile(record, scenario, checks, check, command):
    run = scenario(**CONVERGENCE[check])
    margin = checks[check].evaluate(record(run, window=commanded(BEAT, **command)))
    assert margin.value > 0.5, f"{command}: {margin.measured}"
    # The same command that does move the sum, beneath the same beat.
    sums = BEAT + 40.0 * 0.02 * (np.arange(40) >= 20)
    margin = checks[check].evaluate(
        record(run, window=commanded(sums, **{"reference_share": 0.02, **command}))
    )
    assert not margin.met, f"{command}: {margin.measured}"


@pytest.mark.parametrize("check", ["CNV-1", "CNV-3", "ROB-1", "ROB-3"])
@pytest.mark.parametrize(
    ("quantity", "explained"),
    # The share by which the reference differs, and a twentieth per degree, are k2.
    [("reference_share", 0.005), ("degrees", 0.1)],
)
def test_a_command_explains_no_more_than_the_steepest_of_an_ideal_regulator(
    record, scenario, assert_limit, check, quantity, explained
):
    run = scenario(**CONVERGENCE[check])
    # All of it goes with the command, which cannot be all of its work.
    sums = np.where(np.arange(40) >= 20, 42.0, 38.0)

    def moved_by(part):
        return record(run, window=commanded(sums, **{quantity: part * explained}))

    assert_limit(check, moved_by(0.999), moved_by(1.001))


def test_a_command_that_moves_does_not_add_to_what_the_current_sum_shows(record, scenario, checks):
    sums = np.where(np.arange(40) >= 20, 40.1, 40.0)
    margin = checks["CNV-1"].evaluate(record(scenario(), window=commanded(sums, reference_share=0.1)))
    assert margin.value == pytest.approx(0.5)
    assert margin.measured.startswith("Σ|i| varies by 0.25 % at"), margin.measured


def test_a_failure_states_how_much_the_command_explains(record, scenario, checks):
    sums = np.where(np.arange(40) >= 20, 42.0, 38.0)
    margin = checks["CNV-1"].evaluate(record(scenario(), window=commanded(sums, reference_share=0.02)))
    assert margin.value == pytest.approx(1.0 - 0.02 / 0.005)
    assert margin.measured.startswith("Σ|i| varies by 10 %, at most 2 % of it by the command at"), (
        margin.measured
    )


numbers = st.floats(-1.0, 1.0)


@given(st.lists(st.tuples(numbers, numbers, numbers), min_size=2, max_size=30), st.floats(0.0, 0.1))
def test_the_line_is_that_of_an_independent_solver(rows, size):
    means = np.array([(40.0, 10.0, 0.9)]) + np.array(rows) * (4.0, 20.0 * size, 40.0 * size * DEGREE)
    values = WindowObservation(**dict.fromkeys(WindowObservation._fields, 0.0))
    values = values._replace(current_sum=40.0, reference=10.0, means=means)
    moved = (means - means.mean(axis=0))[:, 1:] * (4.0, 40.0 / DEGREE)
    sums = means[:, 0] - means[:, 0].mean()
    slopes = lsq_linear(moved, sums, ((0.0, -STEEPEST[1]), STEEPEST), method="bvls").x
    expected = min(np.ptp(moved @ slopes), np.ptp(means[:, 0]))
    # Where the command hardly moves, or reference and angle move in step, several lines have the same error.
    has_several = np.linalg.matrix_rank(moved, tol=1e-6) < 2
    assert has_several or commanded_spread(values) == pytest.approx(expected, abs=1e-6), f"{slopes}"
