"""The controllers of examples/, which are one algorithm in several languages, in closed loop at 1500 rpm."""

from __future__ import annotations

import subprocess
import time
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Final

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.running import run_scenario
from drivegate_lab.bench.measurements import run_correctness
from drivegate_lab.bench.workbench import (
    Correctness,
    NotMeasured,
    Value,
    Workbench,
    interleaved,
    operating_scenario,
    rate,
    ratio,
    timed,
)
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.controller import Controller

SIMULATED: Final = 4.0
"""Simulated time of each run (s)."""
FOLDER: Final = Path(__file__).resolve().parents[1] / "examples"
"""Where they are."""

_SPECIFICATIONS: Final = {
    "c": "c/controller.c",
    "numba": "numba/controller.py:controller",
    "python": "python/controller.py:Controller",
}


def example_ratio(bench: Workbench, language: str) -> Value:
    """Measure the loop with a compiled example against that with the built-in reference, in turns."""
    scenario = operating_scenario(1500, "ideal", bench.simulated(SIMULATED))
    example, reference = _loaded(bench, language), bench.controller("reference")
    correctness = run_correctness(scenario, run_scenario(scenario, example))
    ours, theirs = interleaved(
        (lambda: run_scenario(scenario, example), lambda: run_scenario(scenario, reference)),
        time.process_time,
        bench.rounds,
    )
    speeds = [scenario.duration_s / median(times) for times in (ours, theirs)]
    measured = f"{speeds[0]:.0f} against {speeds[1]:.0f} × real time, {correctness.measured}"
    return ratio(ours, theirs, Correctness(correctness.valid, measured))


def python_example_rate(bench: Workbench) -> Value:
    """Measure the closed loop with the example in Python."""
    scenario = operating_scenario(1500, "ideal", bench.simulated(SIMULATED))
    example = _loaded(bench, "python")
    correctness = run_correctness(scenario, run_scenario(scenario, example))
    times = timed(lambda: run_scenario(scenario, example), time.process_time, bench.rounds)
    return rate(scenario.duration_s, times, correctness)


def _loaded(bench: Workbench, language: str) -> Controller:
    if language == "rust":
        library = bench.scratch / "example.so"
        build = [FOLDER / "rust" / "build.sh", library]
        built = subprocess.run(build, capture_output=True, encoding="utf-8", check=False)
        if built.returncode != 0:
            raise NotMeasured(built.stderr.strip() or "examples/rust/build.sh failed")
        return load_controller(resolve_candidate(str(library)))
    try:
        return load_controller(resolve_candidate(str(FOLDER / _SPECIFICATIONS[language])))
    except InputError as error:
        raise NotMeasured(str(error)) from error
