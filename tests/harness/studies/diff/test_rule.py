"""When two commands differ, and the first of many that does."""

import math

import numpy as np
import pytest

from drivegate.studies.diff.diff import BITWISE, Rule, differing, first_difference
from drivegate.studies.diff.display import is_rounding_of_a_target
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


@pytest.mark.parametrize(
    ("kinds", "second", "expected"),
    [
        pytest.param(("c", "elf"), 1.000003, True, id="an image in single precision"),
        pytest.param(("c", "elf"), 1.00003, False, id="too much for rounding"),
        pytest.param(("c", "rust"), 1.000003, False, id="no image"),
        pytest.param(("elf", "elf"), 1.000003, False, id="two images"),
    ],
)
def test_last_digits_of_an_image_are_explained_by_rounding(kinds, second, expected):
    fields = [
        {"first": 1.0, "second": second, "difference": second - 1.0, "ulps": 1, "differs": True},
        {"first": 1.0, "second": 2.0, "difference": 1.0, "ulps": 2, "differs": False},
    ]
    document = {"candidates": [{"kind": kind} for kind in kinds], "difference": {"commands": fields}}
    assert is_rounding_of_a_target(document) is expected
    fields[0] |= {"ulps": None}
    assert not is_rounding_of_a_target(document), "a fault code or a leg is no number that is rounded"
