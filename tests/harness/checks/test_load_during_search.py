"""The reference finds the optimum although the load changes while its search moves."""

import pytest

from drivegate.candidates.builtin.candidates import BUILTIN_CANDIDATES
from drivegate.candidates.builtin.loading import BuiltinController
from drivegate.checks.convergence import converges_again, reaches_optimum
from drivegate.drives.running import run_scenario
from drivegate.runs.record import RunRecord
from drivegate.scenarios.building import steady_scenario
from drivegate.scenarios.changes import with_load_factor
from drivegate_cases.motor.motor import load_motor
from drivegate_models.half_bridge.controllers.builtin import SEARCHES


@pytest.mark.parametrize("factor", [((0.0, 0.0), (5.5, 0.0), (5.5, 0.9), (6.0, 0.9), (6.0, 1.0))])
def test_a_step_of_the_load_is_not_taken_for_the_effect_of_a_step_of_the_angle(
    factor: tuple[tuple[float, float], ...],
) -> None:
    plain = steady_scenario(load_motor("paper-5-phase"), 1500.0, power_share=1.0, constant_power=False)
    torque = plain.replaced(load=plain.load.model_copy(update={"torque_nm": 10.0}))
    scenario = with_load_factor(torque, factor)
    run = run_scenario(scenario, BuiltinController(SEARCHES["reference"]))
    record = RunRecord(scenario, run, BUILTIN_CANDIDATES["reference"])
    for margin in (reaches_optimum(record), converges_again(record)):
        assert margin is not None
        assert margin.met, f"{margin.check}: {margin.measured}"
