"""A run recorded for the checks: what the candidate declares of itself is what it is held to."""

from collections import deque
from dataclasses import replace

import pytest

from drivegate import Command, Nameplate, Sense
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.python.bridge import PythonController
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.messages import JudgedCandidate
from drivegate.contracts.current.checks.power import estimated_power
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive

STEPS = 40


class Averaging:
    """Estimates its input power as the mean over the last steps."""

    def reset(self, nameplate: Nameplate) -> None:
        self.products: deque[float] = deque(maxlen=STEPS)

    def step(self, sense: Sense) -> Command:
        self.products.append(sense.half_supply_voltage * sense.current_magnitude_sum)
        reference = 12.0 if sense.speed < sense.speed_reference else 0.0
        return Command(reference, 0.0, sum(self.products) / len(self.products))


@pytest.mark.parametrize(("steps", "met"), [(STEPS, True), (0, False), (2 * STEPS, False)])
def test_an_estimate_is_judged_over_the_time_that_its_candidate_declares(steps: int, met: bool) -> None:
    scenario = fixed_scenarios(load_drive("paper-5-phase"))[1].replaced(duration_s=1.0)
    declaration = Declaration(estimates_power=True, power_window_s=steps * scenario.control_period_s)
    candidate = replace(resolve_candidate("reference"), declaration=declaration)
    loaded = JudgedCandidate(candidate, lambda: PythonController(Averaging()))
    margin = estimated_power(recorded(loaded, scenario, loaded.controller()))
    assert margin is not None
    assert margin.met is met, margin.measured
