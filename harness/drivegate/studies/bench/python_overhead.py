"""What calling a Python candidate costs beyond what the candidate itself takes."""

from __future__ import annotations

import time
from statistics import median
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.python.bridge import PythonController
from drivegate.drives.running import run_scenario
from drivegate.studies.bench.loop_rates import run_correctness
from drivegate.studies.bench.measurement import Correctness, Value, interleaved
from drivegate.studies.bench.workbench import Workbench, operating_scenario

if TYPE_CHECKING:
    from drivegate_models.contract.current.signals import Command, Nameplate, Sense

SIMULATED: Final = 4.0
"""Simulated time of each run (s)."""
TWIN: Final = "numba"
"""Kind of candidate with the same algorithm whose own time is as good as nothing."""


class _Listening:
    """A candidate that keeps what another one is given, and answers as it does."""

    def __init__(self, candidate: Any) -> None:
        self._candidate = candidate
        self.senses: list[Sense] = []

    def reset(self, nameplate: Nameplate) -> None:
        self._candidate.reset(nameplate)
        self.nameplate = nameplate

    def step(self, sense: Sense) -> Command:
        self.senses.append(sense)
        answer: Command = self._candidate.step(sense)
        return answer


def python_overhead(bench: Workbench) -> Value:
    """Measure what a step of a Python candidate costs beyond its own time.

    Three pieces of work take turns: the loop with the candidate in Python, the loop with its twin in numba, and the
    candidate alone, called with what it saw in the loop.
    """
    python, twin = bench.controller("python"), bench.controller(TWIN)
    assert isinstance(python, PythonController)
    candidate = python.instance
    scenario = operating_scenario(1500, "ideal", bench.simulated(SIMULATED))
    listening = _Listening(candidate)
    heard = run_scenario(scenario, PythonController(listening))
    same = run_scenario(scenario, twin).digest == heard.digest

    def alone() -> None:
        candidate.reset(listening.nameplate)
        step = candidate.step
        for sense in listening.senses:
            step(sense)

    looped, plant, own = interleaved(
        (lambda: run_scenario(scenario, python), lambda: run_scenario(scenario, twin), alone),
        time.process_time,
        bench.rounds,
    )
    scale = 1e6 / len(listening.senses)
    overhead = scale * median(a - b - c for a, b, c in zip(looped, plant, own, strict=True))
    measured = (
        f"its own {scale * median(own):.1f} µs, commands {'' if same else 'not '}those of its twin in {TWIN}"
    )
    correctness = Correctness(same and run_correctness(scenario, heard).valid, measured)
    return Value(overhead, overhead, len(own), correctness)
