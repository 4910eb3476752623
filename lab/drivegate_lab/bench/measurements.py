"""How fast the closed loop, steady states and the oracle are, and how long drivegate takes from its start."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import degrees, radians
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.python.bridge import PythonController
from drivegate.contracts.catalogue import contract_named
from drivegate.drives.kinds import DEFAULT_DRIVE, DriveKind
from drivegate.drives.running import run_scenario
from drivegate_lab.bench.workbench import (
    Correctness,
    NotMeasured,
    Value,
    Workbench,
    duration,
    interleaved,
    operating_scenario,
    rate,
    timed,
)
from drivegate_models.units import RADIANS_PER_RPM

if TYPE_CHECKING:
    from drivegate_cases.scenario.scenario import Scenario
    from drivegate_models.contract.current.signals import Command, Nameplate, Sense
    from drivegate_models.loop.closed_loop import ClosedLoopRun

CANDIDATES: Final = ("reference", "numba", "c", "python", "exec")
SPEEDS_RPM: Final = (500, 1000, 1500, 2000)
SENSORS: Final = ("ideal", "mcs96")
SIMULATED: Final = {"reference": 4.0, "initial": 4.0, "numba": 4.0, "c": 4.0, "python": 2.0, "exec": 1.0}
"""Simulated time of each run (s)."""

TOLERANCE_RPM: Final = {"ideal": 5.0, "mcs96": 10.0}
"""How far the true speed may end from the speed reference (rpm)."""
ENERGY_TOLERANCE: Final = 1e-9
"""Residual of the energy in a control period, over its throughput, up to which a run is right."""
OVERHEAD_SIMULATED: Final = 4.0
"""Simulated time of each run (s)."""
TWIN: Final = "numba"
"""Kind of candidate with the same algorithm whose own time is as good as nothing."""
POINTS: Final = 20_000
"""Number of steady states, of which each has its own speed, angle and current reference."""
LEAST_CERTIFIED: Final = 0.98
"""Share of them that has to be certified periodic."""
CLOSING: Final = 1e-9
"""Residual of the power of a point, over its input power, up to which it is right."""

# How closely the edge is located.
_EDGE = radians(2e-4)
LONGEST: Final = 1800.0
"""Time after which a process is given up (s)."""
CACHE_VARIABLES: Final = ("DRIVEGATE_CACHE", "NUMBA_CACHE_DIR")
"""Environment variables that name folders of compiled code."""

_COMMAND_LINE = "from drivegate.commands.command_line import main; main()"


def run_correctness(scenario: Scenario, run: ClosedLoopRun) -> Correctness:
    """Compare a run with its expected result."""
    speed = run.observed.speed_final / RADIANS_PER_RPM
    speed_reference = float(scenario.speed_rpm[-1][1])
    residual = run.observed.exchange_error
    right = (
        abs(speed - speed_reference) <= TOLERANCE_RPM[scenario.sensors.kind] and residual <= ENERGY_TOLERANCE
    )
    return Correctness(right, f"ends at {speed:.1f} rpm, energy within {residual:.0e}")


def loop_rate(
    bench: Workbench, candidate: str, speed_rpm: int, sensors: str, drive: str = DEFAULT_DRIVE
) -> Value:
    """Measure the closed loop of a drive with one candidate at one speed."""
    seconds = bench.simulated(SIMULATED[candidate])
    scenario = operating_scenario(speed_rpm, sensors, seconds, drive)
    clock = time.perf_counter if candidate == "exec" else time.process_time
    with _one_processor():
        controller = bench.controller(candidate)
        correctness = run_correctness(scenario, run_scenario(scenario, controller))
        times = timed(lambda: run_scenario(scenario, controller), clock, bench.rounds)
    return rate(seconds, times, correctness)


@contextmanager
def _one_processor() -> Iterator[None]:
    """Keep this process and those that it starts on one processor, where the system can do so.

    Two processes that take turns are woken from the sleep of an idle processor otherwise, as they are not in a gate,
    whose workers keep all processors busy.
    """
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    allowed = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(allowed)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, allowed)


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
    scenario = operating_scenario(1500, "ideal", bench.simulated(OVERHEAD_SIMULATED))
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


def steady_rate(bench: Workbench, band: float, drive_name: str = DEFAULT_DRIVE) -> Value:
    """Measure the solution of steady states of a drive."""
    import numpy as np

    from drivegate_cases.drive.drive_document import load_drive
    from drivegate_models.steady.grid import POINT_COLUMNS, solve_points
    from drivegate_models.steady.plant import make_phases
    from drivegate_models.steady.steady_state import KEPT_TIME

    # Without core loss, which floating phases take from the shaft, powers add up from what a point shows.
    drive = load_drive(drive_name).plant()._replace(hysteresis_band=band, core_loss_conductance=0.0)
    work, slices = make_phases(drive, KEPT_TIME), make_phases(drive)
    count = POINTS // 10 if bench.quick else POINTS
    places = np.arange(count, dtype=np.float64)
    # Three lengths without a common divisor: no two points are alike.
    speeds = 60.0 + 100.0 * (places % 97) / 97.0
    references = 5.0 + 20.0 * (places % 89) / 89.0
    advances = 1.2 * (places % 83) / 83.0
    values = np.empty((count, len(POINT_COLUMNS)))

    def solve() -> None:
        solve_points(drive, work, slices, drive.half_supply_voltage, speeds, advances, references, values)

    solve()
    columns = dict(zip(POINT_COLUMNS, values.T, strict=True))
    certified = float(columns["certified"].mean())
    # What goes in and is neither shaft power nor loss is what the solution got wrong.
    exact = columns["certified"] > 0.0
    shaft = columns["torque_mean_nm"] * speeds
    lost = columns["input_power_w"] - shaft - columns["copper_loss_w"]
    residual = float(np.abs(lost[exact] / np.maximum(np.abs(columns["exchanged_power_w"][exact]), 1.0)).max())
    right = certified >= LEAST_CERTIFIED and residual <= CLOSING
    correctness = Correctness(
        right, f"{100.0 * certified:.1f} % certified periodic, power within {residual:.0e}"
    )
    return rate(count, timed(solve, time.process_time, bench.rounds), correctness)


def oracle_time(bench: Workbench, speed_rpm: float, torque: float) -> Value:
    """Measure how long the angle of least Σ|i| takes at one point."""
    from drivegate_cases.drive.drive_document import load_drive
    from drivegate_models.steady import oracle
    from drivegate_models.units import RADIANS_PER_RPM

    drive = load_drive(DEFAULT_DRIVE).plant()
    speed = speed_rpm * RADIANS_PER_RPM
    best = oracle.least_current_sum(drive, speed, torque)
    there = oracle.point_at_torque(drive, speed, best.advance, torque)
    edge = oracle.feasible_edge(drive, speed, torque)
    right = (
        best.advance >= edge - _EDGE
        and abs(there.torque - torque) <= 1e-6 * torque
        and abs(there.current_sum - best.current_sum) <= 1e-6 * best.current_sum
    )
    measured = f"{degrees(best.advance):.2f}° gives {there.torque:.4f} N·m with {best.current_sum:.3f} A"
    times = timed(lambda: oracle.least_current_sum(drive, speed, torque), time.process_time, bench.rounds)
    return duration(times, Correctness(right, measured), 1e3)


def start_time(bench: Workbench, words: tuple[str, ...], expected: str) -> Value:
    """Measure how long a fresh interpreter takes."""
    times, out = [], ""
    code: int | None = 0
    for _ in range(bench.rounds + 1):
        began = time.perf_counter()
        code, out = _ended(words, bench.scratch, os.environ)
        times.append(time.perf_counter() - began)
    right = code == 0 and expected in out
    measured = f"answers with '{expected}'" if right else f"ends with code {code} and without '{expected}'"
    return duration(times[1:], Correctness(right, measured))


def help_words() -> tuple[str, ...]:
    """Return the arguments of ``drivegate --help``."""
    return ("-c", _COMMAND_LINE, "--help")


def gate_time(bench: Workbench, effort: str, *, kind: DriveKind, cold: bool) -> Value:
    """Measure ``drivegate check`` of the usual candidate on the default drive of a kind, with the report's pages."""
    output = bench.scratch / f"gate-{kind.name}-{'cold' if cold else 'warm'}"
    check = ("check", contract_named(kind.contract).usual_candidate, "--drive", kind.default_drive)
    environment = dict(os.environ)
    if cold:
        # Whatever names a folder of compiled code here must not lead there.
        for name in CACHE_VARIABLES:
            environment.pop(name, None)
        environment["DRIVEGATE_CACHE"] = str(bench.scratch / f"nothing-compiled-{kind.name}")
    words = ("-c", _COMMAND_LINE, *check, "--effort", effort, "--output", str(output), "--json")
    began = time.perf_counter()
    code, out = _ended(words, bench.scratch, environment)
    seconds = time.perf_counter() - began
    verdict, runs = "none", 0
    if out.startswith("{"):
        document = json.loads(out)
        verdict, runs = document.get("verdict", "none"), document.get("runs", 0)
    right = code == 0 and verdict == "pass"
    return duration([seconds], Correctness(right, f"verdict {verdict}, {runs} runs, exit code {code}"))


def _ended(words: tuple[str, ...], folder: Path, environment: Mapping[str, str]) -> tuple[int | None, str]:
    try:
        ended = subprocess.run(
            [sys.executable, *words],
            cwd=folder,
            env=dict(environment),
            capture_output=True,
            encoding="utf-8",
            errors="replace",
            timeout=LONGEST,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise NotMeasured(f"it took longer than {LONGEST:.0f} s") from error
    return ended.returncode, ended.stdout
