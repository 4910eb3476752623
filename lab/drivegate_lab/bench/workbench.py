"""What the measurements share: one measured number with its check, timing, scenarios, and candidates to measure."""

from __future__ import annotations

import gc
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from shlex import quote
from statistics import median
from timeit import Timer
from typing import TYPE_CHECKING, Final, Literal

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.kinds import DEFAULT_DRIVE
from drivegate.results.waivers import present_day
from drivegate.studies.new import write_candidate
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario, load_scenario
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

if TYPE_CHECKING:
    from drivegate.candidates.controller import Controller

Better = Literal["more", "less"]
"""Which way a number is better."""

LEAST_ROUND_SECONDS: Final = 0.02
"""Time that one timed round lasts at least (s), so that neither clock nor scheduler is what is measured."""
BUILTIN: Final = ("reference", "initial")
"""Candidates that are there already; those of other kinds are written by the templates of ``drivegate new``."""

_MOST_TORQUE = 9.8
_SHARE_OF_POWER = 0.98


class NotMeasured(Exception):
    """Something that a measurement needs is not here; the message says what."""


@dataclass(frozen=True)
class Correctness:
    """Whether the work that was timed gave the right result."""

    valid: bool
    """Whether it did."""
    measured: str
    """What was looked at, with its numbers."""


@dataclass(frozen=True)
class Value:
    """What a measurement gives."""

    value: float
    """The best of all rounds, in the measurement's unit."""
    median: float
    """Their median; far from the best where the machine was busy."""
    rounds: int
    """How many there were."""
    correctness: Correctness
    """Whether the result was right."""


def timed(work: Callable[[], object], clock: Callable[[], float], rounds: int) -> list[float]:
    """Time a piece of work."""
    return interleaved((work,), clock, rounds)[0]


def interleaved(
    works: tuple[Callable[[], object], ...], clock: Callable[[], float], rounds: int
) -> list[list[float]]:
    """Time several pieces of work in turns, so that what disturbs one disturbs the others too."""
    # The collector of garbage, which a timer turns off, is part of what a candidate in Python costs.
    timers = [Timer(work, setup=gc.enable, timer=clock) for work in works]
    repeats = [max(1, round(LEAST_ROUND_SECONDS / max(timer.timeit(1), 1e-6))) for timer in timers]
    times: list[list[float]] = [[] for _ in works]
    for _ in range(rounds):
        for timer, count, kept in zip(timers, repeats, times, strict=True):
            kept.append(timer.timeit(count) / count)
    return times


def rate(amount: float, times: list[float], correctness: Correctness) -> Value:
    """Turn times into a rate."""
    return Value(amount / min(times), amount / median(times), len(times), correctness)


def duration(times: list[float], correctness: Correctness, scale: float = 1.0) -> Value:
    """Turn times into a duration."""
    return Value(scale * min(times), scale * median(times), len(times), correctness)


def ratio(ours: list[float], theirs: list[float], correctness: Correctness) -> Value:
    """Set times taken in turns against each other: what else runs slows both of a turn, but not every turn."""
    # The best of each may be from different turns.
    middle = median(own / other for own, other in zip(ours, theirs, strict=True))
    return Value(middle, middle, len(ours), correctness)


@dataclass
class Workbench:
    """Where and how measurements are made."""

    scratch: Path
    """An empty folder that is removed afterwards."""
    quick: bool
    """Whether few and short rounds will do."""
    _controllers: dict[str, Controller] = field(default_factory=dict)

    @property
    def rounds(self) -> int:
        """Number of rounds of each measurement."""
        return 3 if self.quick else 11

    def simulated(self, seconds: float) -> float:
        """Return how much time a run simulates."""
        return 0.5 * seconds if self.quick else seconds

    def controller(self, kind: str) -> Controller:
        """Load a controller, once."""
        if kind not in self._controllers:
            self._controllers[kind] = self._loaded(kind)
        return self._controllers[kind]

    def _loaded(self, kind: str) -> Controller:
        if kind in BUILTIN:
            return load_controller(resolve_candidate(kind))
        folder = self.scratch / f"bench-{kind}"
        if not folder.exists():
            write_candidate(kind, f"bench-{kind}", folder, present_day(), DEFAULT_DRIVE)
        manifest = folder / "candidate.toml"
        if kind == "exec":
            # The interpreter that runs here, whatever is first on the path.
            command = f'entry = "{quote(sys.executable)} controller.py"'
            manifest.write_text(manifest.read_text().replace('entry = "python3 controller.py"', command))
        try:
            return load_controller(resolve_candidate(str(manifest)))
        except InputError as error:
            raise NotMeasured(str(error)) from error


def operating_scenario(
    speed_rpm: int, sensors: str, seconds: float, drive_name: str = DEFAULT_DRIVE
) -> Scenario:
    """Make a run at one speed: 9.8 N·m, or less where that would be more than rated power."""
    published, drive = load_scenario("fig5-search"), load_drive(drive_name)
    rated = drive.rating.rated_power_w / (speed_rpm * RADIANS_PER_RPM)
    torque = round(min(_MOST_TORQUE, _SHARE_OF_POWER * rated), 2)
    return published.replaced(
        name=f"bench-{speed_rpm}-{sensors}",
        drive=drive,
        duration_s=seconds,
        initial_speed_rpm=float(speed_rpm),
        speed_rpm=((0.0, float(speed_rpm)),),
        sensors=sensors,
        load={"kind": "constant_torque", "torque_nm": torque, "factor": [[0.0, 0.0], [0.2, 1.0]]},
    )
