"""When two commands differ, and the first of many that does."""

import math

import numpy as np
import pytest

from drivegate.studies.diff.diff import BITWISE, Rule, differing, first_difference
from drivegate_models.contract.current.records import COMMAND
from drivegate_models.contract.duty.records import DUTY_COMMAND


def test_the_first_answer_that_differs_in_one_bit_is_found():
    commands = np.random.default_rng(1).normal(size=(20, 4)).view(COMMAND)[:, 0]
    answers = commands.copy()
    answers["struct_size"] = 0
    assert first_difference(commands, answers, Rule()) is None
    answers["advance_angle"][7] = np.nextafter(answers["advance_angle"][7], np.inf)
    answers["current_reference"][11] = 0.0
    assert first_difference(commands, answers, Rule()) == 7
    assert first_difference(commands, answers[:7], Rule()) is None, (
        "fewer answers than commands do not differ"
    )
    assert first_difference(commands, answers, Rule(ignored=("advance_angle",))) == 11
    assert first_difference(commands, answers, Rule(1e-12)) == 11


def test_a_whole_number_differs_whatever_the_tolerance():
    commands = np.zeros(3, DUTY_COMMAND)
    answers = commands.copy()
    answers["fault"][1] = 1
    assert first_difference(commands, answers, Rule(10.0)) == 1
    assert first_difference(commands, answers, Rule(ignored=("fault",))) is None


@pytest.mark.parametrize(
    ("one", "other", "tolerance", "expected"),
    [
        (1.0, 1.0, BITWISE, False),
        (1.0, math.nextafter(1.0, 2.0), BITWISE, True),
        (0.0, -0.0, BITWISE, True),
        (0.0, -0.0, 0.0, False),
        (math.nan, -math.nan, BITWISE, False),
        (math.nan, 1.0, 1.0, True),
        (math.inf, math.inf, 1.0, False),
        (0.0, 1e-9, 1e-9, False),
        (0.0, 2e-9, 1e-9, True),
        (1000.0, 1000.0 + 0.9e-6, 1e-9, False),
        (1000.0, 1000.0 + 1.1e-6, 1e-9, True),
    ],
)
@pytest.mark.filterwarnings("error")
def test_bits_count_unless_there_is_a_tolerance(one, other, tolerance, expected):
    assert differing(np.array([one]), np.array([other]), tolerance).tolist() == [expected]
