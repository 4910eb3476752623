"""TIM-1: the limit of a step's compute time, and what is timed."""

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from drivegate.candidates.fault import Fault
from drivegate.candidates.python.bridge import PythonController
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.containment.judge_process import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.gate.plan import time_steps, timing_margin, way_of_running
from drivegate_cases.scenario.scenario import load_scenario

LIMIT = 0.1 * 0.0005

SLOW = """
from time import perf_counter

from drivegate import Command


class Slow:
    def reset(self, nameplate):
        self.steps = 0

    def step(self, sense):
        self.steps += 1
        until = perf_counter() + 100e-6
        while perf_counter() < until:
            pass
        return Command(5.0, 0.0)


class Rarely(Slow):
    def step(self, sense):
        return super().step(sense) if self.steps % 1000 == 999 else self.quick()

    def quick(self):
        self.steps += 1
        return Command(5.0, 0.0)
"""

PROGRAM = """
import json
import sys

for line in sys.stdin:
    message = json.loads(line)
    if "sense" in message:
        answer = {"current_reference": 5.0, "advance_angle": 0.0}
    elif "reset" in message:
        answer = {"ready": True}
    else:
        answer = {"drivegate": 1}
    print(json.dumps(answer), flush=True)
"""


def loaded(specification: str) -> JudgedCandidate:
    return own_candidate(resolve_candidate(specification))


@pytest.fixture(scope="module")
def short_run():
    scenario = load_scenario("fig5-search")
    load = scenario.load.model_copy(update={"factor": ((0.0, 0.0),)})
    return scenario.replaced(duration_s=1.0, load=load)


def test_the_limit_is_a_tenth_of_the_control_period():
    assert timing_margin("native", float(np.nextafter(LIMIT, 0.0)), 0.0005).met
    assert not timing_margin("native", LIMIT, 0.0005).met
    assert timing_margin("native", 5e-6, 0.0005).measured == "5 µs a step (native), 1 % of the control period"


def test_how_a_step_runs_is_reported():
    native, python = (
        loaded("reference").controller(),
        PythonController(SimpleNamespace(reset=None, step=None)),
    )
    assert way_of_running("builtin", native) == "native"
    assert way_of_running("python", python) == "Python"
    assert way_of_running("python", native) == "native", "a NumbaController is compiled"
    assert way_of_running("exec", python) == "a process of its own"
    assert way_of_running("fmu", python) == "FMU"


def test_a_program_is_not_judged_by_the_time_of_the_pipes_to_it(tmp_path, short_run):
    program = tmp_path / "answers.py"
    program.write_text(PROGRAM)
    with Judge(resolve_candidate(f"exec:{sys.executable} {program}")) as judge:
        outcome = judge.once(Job(time_steps, short_run.replaced(duration_s=0.05)))
    assert not isinstance(outcome, Fault), outcome
    (run,) = outcome.runs
    assert not run.margins


@pytest.mark.parametrize("name", ["reference", "published", "initial"])
def test_the_built_in_controllers_take_little_time(name, short_run):
    candidate = loaded(name)
    outcome = time_steps(candidate, short_run)
    (run,) = outcome.runs
    (margin,) = run.margins
    assert run.scenario == short_run.to_mapping()
    assert margin.check == "TIM-1"
    assert 0.9 < margin.value < 1.0, margin.measured


def test_a_step_that_takes_a_fifth_of_the_period_fails(tmp_path, monkeypatch, short_run):
    (tmp_path / "slow.py").write_text(SLOW)
    monkeypatch.chdir(tmp_path)
    short = short_run.replaced(duration_s=0.2)
    (run,) = time_steps(loaded("slow.py:Slow"), short).runs
    assert not run.margins[0].met, run.margins[0].measured
    assert "(Python)" in run.margins[0].measured


def test_a_rare_slow_step_does_not_decide(tmp_path, monkeypatch, short_run):
    (tmp_path / "slow.py").write_text(SLOW)
    monkeypatch.chdir(tmp_path)
    (run,) = time_steps(loaded("slow.py:Rarely"), short_run).runs
    assert run.margins[0].met, run.margins[0].measured
