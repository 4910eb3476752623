"""Few pulses of the hysteresis band beat with the means of Σ|i|, for which nobody is accused."""

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.drives.running import run_scenario
from drivegate.scenarios.changes import in_steps, with_imbalance
from drivegate_cases.drive.drive_document import load_drive

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
