"""Closed loop: simulated seconds a second on one core."""

import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from drivegate.candidates.controller import Controller
from drivegate.runs.scenario import run_scenario
from drivegate_cases.scenario.scenario import Scenario

# One core's own time, whatever else the machine does.
pytestmark = pytest.mark.benchmark(timer=time.process_time)

EXAMPLES = Path(__file__).parent.parent / "examples"
NATIVE_BAR = 300.0
PYTHON_BAR = 50.0
SHARE_BAR = 1.3
"""Time of a run with a compiled candidate, over that with the built-in reference."""

_PYTHON = """
from drivegate import Command


class Proportional:
    def reset(self, nameplate):
        self.limit = nameplate.current_limit
        self.gain = 150.0 * nameplate.inertia / (0.8 * nameplate.phases * nameplate.emf_constant)
        self.integral = 0.0

    def step(self, sense):
        error = sense.speed_reference - sense.speed
        self.integral = min(max(self.integral + 0.015 * self.gain * error, 0.0), self.limit)
        reference = min(max(self.gain * error + self.integral, 0.0), self.limit)
        return Command(reference, 1.0, sense.half_supply_voltage * sense.current_magnitude_sum)
"""


def test_native_reference(
    published_point: Scenario,
    controller: Callable[[str], Controller],
    closed_loop_rate: Callable[[Scenario, Controller], float],
) -> None:
    rate = closed_loop_rate(published_point, controller("reference"))
    assert rate >= NATIVE_BAR, f"{rate:.0f} × real time, below {NATIVE_BAR:.0f} ×"


def test_python_controller(
    published_point: Scenario,
    controller: Callable[[str], Controller],
    closed_loop_rate: Callable[[Scenario, Controller], float],
    tmp_path: Path,
) -> None:
    (tmp_path / "proportional.py").write_text(_PYTHON)
    rate = closed_loop_rate(published_point, controller(f"{tmp_path / 'proportional.py'}:Proportional"))
    assert rate >= PYTHON_BAR, f"{rate:.0f} × real time, below {PYTHON_BAR:.0f} ×"


@pytest.mark.parametrize("example", ["c/controller.c", "numba/controller.py:controller", "rust"])
def test_native_example(
    published_point: Scenario,
    controller: Callable[[str], Controller],
    closed_loop_rate: Callable[[Scenario, Controller], float],
    example: str,
    tmp_path: Path,
) -> None:
    specification = str(EXAMPLES / example)
    if example == "rust":
        specification = str(tmp_path / "controller.so")
        subprocess.run([EXAMPLES / "rust" / "build.sh", specification], check=True)
    reference = _seconds(published_point, controller("reference"))
    rate = closed_loop_rate(published_point, controller(specification))
    share = published_point.duration_s / rate / reference
    assert share <= SHARE_BAR, f"{share:.2f} × the time of the built-in reference, above {SHARE_BAR} ×"


def test_python_example(
    published_point: Scenario,
    controller: Callable[[str], Controller],
    closed_loop_rate: Callable[[Scenario, Controller], float],
) -> None:
    rate = closed_loop_rate(
        published_point, controller(f"{EXAMPLES / 'python' / 'controller.py'}:Controller")
    )
    assert rate >= PYTHON_BAR, f"{rate:.0f} × real time, below {PYTHON_BAR:.0f} ×"


def _seconds(scenario: Scenario, subject: Controller) -> float:
    """Return the least processor time of several runs (s)."""
    times = []
    for _ in range(7):
        began = time.process_time()
        run_scenario(scenario, subject)
        times.append(time.process_time() - began)
    return min(times)
