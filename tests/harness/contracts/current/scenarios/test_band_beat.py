"""Few pulses of the hysteresis band beat with the means of Σ|i|, for which nobody is accused."""

import itertools
import math

import numpy as np
import pytest

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.drives.running import run_scenario
from drivegate.scenarios.changes import in_steps, with_imbalance
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.steady.angle_search import torque_demand
from drivegate_models.steady.oracle import point_at_torque
from drivegate_models.steady.plant import make_phases
from drivegate_models.steady.steady_state import KEPT_TIME, solve_steady_state
from drivegate_models.units import RADIANS_PER_RPM

PAPER = load_drive("paper-5-phase")


def test_a_current_sum_that_beats_under_a_constant_command_accuses_nobody() -> None:
    steady = steady_scenario(PAPER, 1390.0, power_share=0.3, constant_power=True)
    scenario = with_imbalance(steady, in_steps((0.0, -0.04), (2.0,)))
    candidate = resolve_candidate("reference")
    run = run_scenario(scenario, load_controller(candidate))
    window = run.windows[-1]
    spread = (window.mean_highest - window.mean_lowest) / window.current_sum
    assert spread > 0.005, f"Σ|i| varies by {spread} only, so that nothing is tested"
    margins = judged(CurrentRecord(scenario, run, candidate.declaration), CHECKS).margins
    (margin,) = [margin for margin in margins if margin.check == "ROB-3"]
    assert margin.value > 0.5, f"Σ|i| varies by {spread}: {margin}"


@pytest.mark.parametrize("name", ["paper-5-phase", "star-3-phase"])
def test_a_command_moves_the_current_sum_of_nearly_all_steady_states_by_no_more_than_counts(
    name: str,
) -> None:
    document = load_drive(name)
    drive, rating = document.plant(), document.rating
    work = make_phases(drive, KEPT_TIME)
    speeds = np.linspace(1.02 * rating.base_speed_rpm, rating.highest_speed_rpm, 4) * RADIANS_PER_RPM
    half, share_of_half = math.radians(0.5), 0.0025
    steepest: list[float] = []
    for speed, share, angle in itertools.product(
        speeds, (0.2, 0.5, 1.0), np.radians(np.arange(5.0, 90.0, 8.0))
    ):
        torque = share * rating.rated_power_w / speed
        point = point_at_torque(drive, speed, angle, torque)
        # A mix of two references is a state in which the number of pulses changes.
        if not point.static or point.share > 0.0:
            continue
        _, _, slices, _, supply, _ = torque_demand(drive, speed, torque, None)
        commands = [(point.reference * (1.0 + side * share_of_half), angle) for side in (-1.0, 1.0)]
        commands += [(point.reference, angle + side * half) for side in (-1.0, 1.0)]
        sums = [
            solve_steady_state(drive, work, slices, speed, supply, *command).current_sum
            for command in commands
        ]
        by_reference, by_angle = abs(sums[1] - sums[0]), abs(sums[3] - sums[2])
        # Twice the share by which the reference moves, and a fifth per degree.
        steepest.append(max(by_reference / (4.0 * share_of_half), by_angle / 0.2) / point.current_sum)
    beyond = float(np.mean(np.array(steepest) > 1.0))
    assert beyond < 0.05, f"{100.0 * beyond:.0f} % of {len(steepest)} states are steeper"
