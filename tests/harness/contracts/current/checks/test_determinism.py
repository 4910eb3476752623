"""What DET-1 states of a controller that does not repeat itself: from which step on, which number, and why."""

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate.gate.shard import FixedRuns, run_fixed
from drivegate_cases.scenario.scenario import load_scenario

SHORT = load_scenario("lock-up").replaced(duration_s=0.5)

CONTROLLERS = """
import itertools
from drivegate import Command
runs = itertools.count()

class Keeping:
    def __init__(self): self.resets = 0
    def reset(self, nameplate): self.resets, self.steps = self.resets + 1, 0
    def step(self, sense):
        self.steps += 1
        return Command(5.0, 0.58 + (0.03 if self.resets > 1 and self.steps > 12 else 0.0))

class Sharing:
    def reset(self, nameplate): self.run = next(runs)
    def step(self, sense): return Command(5.0 + 1e-9 * self.run, 0.0)
"""


@pytest.fixture
def measured(tmp_path):
    (tmp_path / "mine.py").write_text(CONTROLLERS, encoding="utf-8")

    def run(name):
        candidate = resolve_candidate(name if ":" not in name else f"{tmp_path / 'mine.py'}{name}")
        with Judge(candidate) as judge:
            outcome = judge.run(Job(run_fixed, FixedRuns((SHORT,), repeat=True)))
        (margin,) = [margin for margin in outcome.runs[0].margins if margin.check == "DET-1"]
        return margin.measured

    return run


def test_what_reset_keeps_is_reported_with_step_time_and_both_numbers(measured):
    assert measured(":Keeping") == (
        "the second run on the same instance differs from step 12 on, at 0.006 s: advance angle 0.61 against "
        "0.58 rad; reset kept something"
    )


def test_what_instances_share_is_reported_with_the_digits_that_distinguish_the_numbers(measured):
    words = measured(":Sharing")
    assert "current reference 5.000000001 against 5 A" in words, words
    assert words.endswith(
        "so does that on a new instance: something outside of the instance is kept, or the answer goes by chance or "
        "a clock; if the controller draws random numbers, seed them in reset"
    ), words


def test_a_controller_that_repeats_itself_says_so(measured):
    assert measured("reference") == "2 repetitions are the same"
