"""The reference controller beyond the steady runs of the gate: it starts its search again after a change."""

from typing import Any

import numpy as np
import pytest

from drivegate.candidates.builtin.loading import BuiltinController
from drivegate.candidates.declaration import Declaration
from drivegate.contracts.current.checks.convergence import converges, converges_again, reaches_optimum
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.fixed import steady_scenario
from drivegate.drives.running import run_scenario
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.controllers.current.builtin import SEARCHES

DRIVE = load_drive("paper-5-phase")
CHANGE = 12.2


def changed(speed_rpm: float, share: float, **changes: Any) -> Scenario:
    scenario = steady_scenario(DRIVE, speed_rpm, power_share=share, constant_power=False)
    return scenario.model_copy(update={"duration_s": CHANGE + 10.5, **changes})


def load_step(speed_rpm: float, before: float, after: float) -> Scenario:
    scenario = changed(speed_rpm, 1.0)
    factor = ((0.0, 0.0), (0.2, before), (CHANGE, before), (CHANGE, after))
    return scenario.model_copy(update={"load": scenario.load.model_copy(update={"factor": factor})})


def supply_dip(speed_rpm: float) -> Scenario:
    back = CHANGE + 0.3
    return changed(
        speed_rpm, 0.8, supply_v=((0.0, 48.0), (CHANGE, 48.0), (CHANGE, 43.2), (back, 43.2), (back, 48.0))
    )


def record(scenario: Scenario, name: str = "reference") -> CurrentRecord:
    return CurrentRecord(scenario, run_scenario(scenario, BuiltinController(SEARCHES[name])), Declaration())


@pytest.mark.one_in(4)
@pytest.mark.parametrize("speed", [700.0, 1000.0, 1500.0])
@pytest.mark.parametrize("shares", [(0.5, 1.0), (1.0, 0.5), (0.8, 0.95)])
def test_it_finds_the_optimum_again_after_a_load_step(speed: float, shares: tuple[float, float]) -> None:
    run = record(load_step(speed, *shares))
    assert len(list(run.windows())) == 2, "the scenario has not got a window on either side of the step"
    for margin in (converges(run), converges_again(run), reaches_optimum(run)):
        assert margin is not None
        assert margin.met, f"{margin.check} at {speed} rpm from {shares}: {margin.measured}"


@pytest.mark.parametrize("speed", [1150.0, 1500.0])
def test_it_finds_the_optimum_again_after_a_dip_of_the_supply(speed: float) -> None:
    run = record(supply_dip(speed))
    for margin in (converges(run), converges_again(run), reaches_optimum(run)):
        assert margin is not None
        assert margin.met, f"{margin.check} at {speed} rpm: {margin.measured}"


def test_a_weaker_machine_gets_its_torque_back_beyond_the_initial_angle() -> None:
    """With 20 % more inductance the initial line itself lies below the feasible edge at 1500 rpm."""
    scenario = steady_scenario(DRIVE, 1500.0, power_share=1.0, constant_power=False)
    weaker = scenario.replaced(scales={"inductance": 1.2}, duration_s=14.2)
    held, lost = record(weaker), record(weaker, "initial")
    speeds = [run.run.observed.speed_final for run in (held, lost)]
    assert abs(speeds[0] - 157.08) < 0.53, f"the reference ends at {speeds[0]} rad/s"
    assert speeds[1] < 157.08 - 0.53, f"the initial angle alone holds the speed too: {speeds[1]} rad/s"


def test_the_angle_does_not_chatter_at_base_speed() -> None:
    scenario = changed(500.0, 0.2).model_copy(update={"duration_s": 4.0})
    trace = run_scenario(scenario, BuiltinController(SEARCHES["reference"]), trace_every=1).trace
    jumps = int((abs(np.diff(trace["advance_deg"])) > 5.0).sum())
    assert jumps <= 2, f"the angle jumps {jumps} times"
