"""Few pulses of the hysteresis band beat with the means of Σ|i|, for which nobody is accused."""

import itertools
import math

import numpy as np
import pytest

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.checks.commanded import STEEPEST
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.drives.running import run_scenario
from drivegate.scenarios.changes import in_steps, with_imbalance
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.steady.angle_search import torque_demand
from drivegate_models.steady.current_search import mean_state
from drivegate_models.steady.oracle import point_at_torque
from drivegate_models.units import RADIANS_PER_RPM

PAPER = load_drive("paper-5-phase")


def test_a_current_sum_that_beats_under_a_constant_command_accuses_nobody() -> None:
    steady = steady_scenario(PAPER, 1390.0, power_share=0.3, constant_power=True)
    scenario = with_imbalance(steady, in_steps((0.0, -0.04), (2.0,)))
    candidate = resolve_candidate("reference")
    run = run_scenario(scenario, load_controller(candidate))
    window = run.windows[-1]
    spread = window.current_sum_range / window.current_sum
    assert spread > 0.005, f"Σ|i| varies by {spread} only, so that nothing is tested"
    margins = judged(CurrentRecord(scenario, run, candidate.declaration), CHECKS).margins
    (margin,) = [margin for margin in margins if margin.check == "ROB-3"]
    assert margin.value > 0.5, f"Σ|i| varies by {spread}: {margin}"


@pytest.mark.parametrize("name", ["paper-5-phase", "star-3-phase"])
def test_few_steady_states_of_an_ideal_regulator_are_steeper_than_what_counts(name: str) -> None:
    document = load_drive(name)
    drive, rating = document.plant()._replace(hysteresis_band=0.0), document.rating
    _, work, slices, _, supply, _ = torque_demand(drive, 1.0)
    speeds = np.linspace(1.02 * rating.base_speed_rpm, rating.highest_speed_rpm, 4) * RADIANS_PER_RPM
    # Half of the step of the reference, as a share, and of the angle, in degrees.
    half = np.array((0.0025, 0.5))
    slopes: list[tuple[float, float]] = []
    for speed, share, angle in itertools.product(
        speeds, (0.2, 0.5, 1.0), np.radians(np.arange(5.0, 90.0, 8.0))
    ):
        point = point_at_torque(drive, speed, angle, share * rating.rated_power_w / speed)
        if not point.static or point.share > 0.0:
            continue
        steps = [
            [
                mean_state(
                    drive,
                    work,
                    slices,
                    speed,
                    supply,
                    point.reference * (1.0 + reference),
                    angle + math.radians(degrees),
                ).current_sum
                for reference, degrees in np.diag(side * half)
            ]
            for side in (-1.0, 1.0)
        ]
        slopes.append(tuple((np.array(steps[1]) - steps[0]) / (2.0 * half * point.current_sum)))
    steeper = (np.array(slopes) > np.array(STEEPEST) * 1.02).mean(axis=0)
    assert (steeper < 0.1).all(), f"{100.0 * steeper} % of {len(slopes)} states are steeper"
    flatter = (np.array(slopes) < [0.0, -STEEPEST[1]]).mean(axis=0)
    assert (flatter < 0.05).all(), f"{100.0 * flatter} % of {len(slopes)} states fall with the command"
