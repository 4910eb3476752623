"""The list of what ``drivegate bench`` measures, by name."""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Final

from drivegate.contracts.catalogue import contract_named
from drivegate.drives.kinds import DEFAULT_KIND, DRIVE_KINDS
from drivegate.drives.running import run_scenario
from drivegate_cases.documents.wording import nearest, one_line
from drivegate_lab.bench.measurements import (
    CANDIDATES,
    OVERHEAD_SIMULATED,
    POINTS,
    SENSORS,
    SIMULATED,
    SPEEDS_RPM,
    gate_time,
    help_words,
    loop_rate,
    oracle_time,
    python_overhead,
    start_time,
    steady_rate,
)
from drivegate_lab.bench.record import BenchRow
from drivegate_lab.bench.workbench import (
    Better,
    Correctness,
    NotMeasured,
    Value,
    Workbench,
    operating_scenario,
)
from drivegate_models.errors import InputError
from drivegate_models.loop import observation

_GROWTH: Final = 4096
"""Bytes that a run of twenty times the length may take more, for what the interpreter itself counts."""
_SHORT, _LONG = 4.0, 80.0
RATE_UNIT: Final = "× real time"
"""Unit of the closed loop's rate: simulated seconds a second."""
NATIVE_BAR: Final = 300.0
"""Rate that the reference controller is meant to reach at 9.8 N·m and a control period of 0.5 ms, at 1500 rpm, and on
the star at 1000 rpm."""
STAR_DRIVE: Final = "star-3-phase"
"""The star that is measured: the iron and copper of the default drive."""
PYTHON_BAR: Final = 50.0
"""The same of a controller in Python."""
EXEC_BAR: Final = 3.0
"""The same of a program of its own."""
OVERHEAD_BAR: Final = 5.0
"""Time that calling a candidate in Python is meant to cost a step beyond its own (µs)."""
POINTS_BAR: Final = 50_000.0
"""Steady states a second."""
HELP_BAR: Final = 0.3
"""Time until the command line answers (s)."""
IMPORT_BAR: Final = 0.15
"""Time of ``import drivegate`` in a fresh process (s)."""
GATE_BARS: Final = {"warm": 60.0, "cold": 120.0}
"""Time of a gate at default effort, with everything compiled and with nothing (s)."""

_POINT = (1500.0, 9.8)
_BARRED_RPM = 1500
_BARRED_STAR_RPM, _HIGHEST_STAR_RPM = 1000, 1500
_REPORTED = ("name", "title", "setting", "unit", "better", "bar")


@dataclass(frozen=True)
class Planned:
    """Something to measure."""

    name: str
    """Its name, such as ``loop.reference.1500.ideal``."""
    title: str
    """What it is, for people."""
    setting: str
    """What the work is; numbers of different settings are not compared."""
    unit: str
    """The number's unit."""
    better: Better
    """Which way it is better."""
    bar: float | None
    """What it is meant to reach on an ordinary machine; a bar that is missed is reported and is no failure.
    """
    measure: Callable[[Workbench], Value]
    """Does it."""

    def row(self, bench: Workbench) -> BenchRow:
        """Measure."""
        about: dict[str, Any] = {field: getattr(self, field) for field in _REPORTED}
        try:
            made = self.measure(bench)
        except NotMeasured as error:
            return BenchRow(
                **about, value=None, median=None, rounds=0, valid=None, check=one_line(str(error))
            )
        return BenchRow(
            **about,
            value=made.value,
            median=made.median,
            rounds=made.rounds,
            valid=made.correctness.valid,
            check=made.correctness.measured,
        )


def planned(*, quick: bool, cold: bool) -> tuple[Planned, ...]:
    """List all that can be measured."""
    return (*_loops(quick), _overhead(quick), *_points(quick), *_star(quick), *_processes(quick, cold))


def run_setting(seconds: float, quick: bool) -> str:
    """State what a run in closed loop simulates."""
    return f"{seconds * (0.5 if quick else 1.0):g} s at a control period of 0.5 ms"


def chosen(plan: Sequence[Planned], names: Sequence[str]) -> tuple[Planned, ...]:
    """Choose from a plan by name, or by the beginning of names up to a point."""
    known = _names_and_groups(plan)
    for name in names:
        if name not in known:
            groups = dict.fromkeys(planned.name.partition(".")[0] for planned in plan)
            raise InputError(
                f"--only '{one_line(name)}' names nothing that is measured, the nearest is "
                f"'{nearest(name, known)}'; there are {', '.join(groups)}, and each row's own name"
            )
    if not names:
        return tuple(plan)
    return tuple(
        one for one in plan if any(one.name == name or one.name.startswith(f"{name}.") for name in names)
    )


def _names_and_groups(plan: Sequence[Planned]) -> list[str]:
    known: dict[str, None] = {}
    for one in plan:
        words = one.name.split(".")
        known |= dict.fromkeys(".".join(words[: end + 1]) for end in range(len(words)))
    return list(known)


def _loops(quick: bool) -> list[Planned]:
    bars = {"reference": NATIVE_BAR, "python": PYTHON_BAR, "exec": EXEC_BAR}
    return [
        Planned(
            f"loop.{candidate}.{speed}.{sensors}",
            f"{candidate}, {speed} rpm, {sensors} sensors",
            run_setting(SIMULATED[candidate], quick),
            RATE_UNIT,
            "more",
            bars.get(candidate) if speed == _BARRED_RPM and sensors == "ideal" else None,
            partial(loop_rate, candidate=candidate, speed_rpm=speed, sensors=sensors),
        )
        for candidate in CANDIDATES
        for speed in SPEEDS_RPM
        for sensors in SENSORS
    ]


def _star(quick: bool) -> list[Planned]:
    """List the closed loop and the steady states of a star, whose phases share a neutral."""
    loops = [
        Planned(
            f"star.loop.{speed}",
            f"reference on {STAR_DRIVE}, {speed} rpm, ideal sensors",
            run_setting(SIMULATED["reference"], quick),
            RATE_UNIT,
            "more",
            NATIVE_BAR if speed == _BARRED_STAR_RPM else None,
            partial(loop_rate, candidate="reference", speed_rpm=speed, sensors="ideal", drive=STAR_DRIVE),
        )
        for speed in SPEEDS_RPM
        if speed <= _HIGHEST_STAR_RPM
    ]
    steady = Planned(
        "star.steady",
        f"steady states of {STAR_DRIVE}, band 0 A",
        _points_setting(quick),
        "points/s",
        "more",
        POINTS_BAR,
        partial(steady_rate, band=0.0, drive_name=STAR_DRIVE),
    )
    return [*loops, steady]


def _overhead(quick: bool) -> Planned:
    return Planned(
        "overhead.python",
        "calling a candidate in Python",
        run_setting(OVERHEAD_SIMULATED, quick),
        "µs a step",
        "less",
        OVERHEAD_BAR,
        python_overhead,
    )


def _points(quick: bool) -> list[Planned]:
    speed, torque = _POINT
    steady = [
        Planned(
            f"steady.{name}",
            f"steady states, band {band:g} A",
            _points_setting(quick),
            "points/s",
            "more",
            POINTS_BAR,
            partial(steady_rate, band=band),
        )
        for name, band in (("band", 0.25), ("ideal", 0.0))
    ]
    oracle = Planned(
        "oracle.least-sum",
        "oracle, angle of least Σ|i|",
        f"at {speed:g} rpm and {torque:g} N·m",
        "ms",
        "less",
        None,
        partial(oracle_time, speed_rpm=speed, torque=torque),
    )
    return [*steady, oracle]


def _points_setting(quick: bool) -> str:
    return f"{POINTS // 10 if quick else POINTS} points over speed, angle and current"


def _processes(quick: bool, cold: bool) -> list[Planned]:
    effort = "quick" if quick else "default"
    measured = (
        [(kind, state) for kind in DRIVE_KINDS.values() for state in ("warm", "cold")]
        if cold
        else [(DEFAULT_KIND, "warm")]
    )
    gates = [
        Planned(
            f"gate.{state}.{kind.name}",
            f"check {contract_named(kind.contract).usual_candidate} on {kind.default_drive}, {state}",
            f"{effort} effort",
            "s",
            "less",
            None if quick else GATE_BARS[state],
            partial(gate_time, effort=effort, kind=kind, cold=state == "cold"),
        )
        for kind, state in measured
    ]
    shown = partial(start_time, words=help_words(), expected="Commands")
    imported = partial(
        start_time, words=("-c", "import drivegate; print(drivegate.__name__)"), expected="drivegate"
    )
    return [
        *gates,
        Planned("start.help", "drivegate --help", "a fresh process", "s", "less", HELP_BAR, shown),
        Planned("start.import", "import drivegate", "a fresh process", "s", "less", IMPORT_BAR, imported),
        Planned("memory.run", "memory of a run", "4 s, no trace", "KiB", "less", None, run_memory),
    ]


def run_memory(bench: Workbench) -> Value:
    """Measure the memory of a run without a trace."""
    controller = bench.controller("reference")
    peaks = []
    for seconds in (_SHORT, _SHORT, _LONG):
        scenario = operating_scenario(1500, "ideal", seconds)
        tracemalloc.start()
        try:
            run_scenario(scenario, controller)
            peaks.append(tracemalloc.get_traced_memory()[1])
        finally:
            tracemalloc.stop()
    _, short, long = peaks
    # The windows of the run keep three means for each averaging time.
    means = 3 * 8 * round((_LONG - _SHORT) / observation.MEAN_TIME)
    correctness = Correctness(
        long <= short + means + _GROWTH, f"a run of {_LONG:g} s takes {long - short} bytes more"
    )
    return Value(short / 1024.0, short / 1024.0, 1, correctness)
