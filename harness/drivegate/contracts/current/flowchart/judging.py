"""Judging a controller on a script: whether its changes of angle are those of the flowchart (FLO-1).

A search is judged by its offset from the initial angle, which is learnt first: the same speeds are run with a
speed reference so far away that the search has to rest. When in its period the search decides is learnt too, from
power that falls and rises; the rows of the script then change right after a decision, so that what a search
measures from one decision to the next belongs to one row, whether it takes a mean or the last sample.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.controller import show_drive
from drivegate.candidates.declaration import FlowchartProfile
from drivegate.checks.margin import GREATEST, Margin
from drivegate.containment.messages import AnyController
from drivegate.contracts.current.flowchart.chart import (
    LARGEST_ANGLE,
    SearchState,
    Sensed,
    allowed,
    beginnings,
    described,
)
from drivegate.contracts.current.flowchart.scripts import probe
from drivegate.contracts.current.timed_steps import scripted_angles
from drivegate_cases.scenario.script import Script, ScriptRow
from drivegate_models.errors import InputError
from drivegate_models.units import RADIANS_PER_RPM

CHECK: Final = "FLO-1"
ANGLE_ROUNDING: Final = 1e-9
"""Rounding of a sum of steps, within which two angles are the same (rad)."""
FREE_DECISIONS: Final = 2
"""Decisions within the first row, which are the beginning of a search; the first may fall into its first step."""
_AWAY_RPM: Final = 10.0
_DIGITS: Final = 9
_FAR_OUT: Final = 1e6


@dataclass(frozen=True)
class ScriptVerdict:
    """The verdict on a script."""

    margin: Margin
    rows: int
    """Number of rows up to the first departure from the flowchart; all of them where there is none."""


def judge_script(controller: AnyController, profile: FlowchartProfile, script: Script) -> ScriptVerdict:
    """Run a controller through a script and compare its angles with those that Fig. 4 allows."""
    interval = _interval(profile, script)
    runner = _Runner(controller, profile, script, interval)
    decision = runner.first_decision()
    if decision is None:
        measured = "the angle never changes, though W falls and rises by 3 k2 from decision to decision"
        return ScriptVerdict(Margin(CHECK, -1.0, measured), 1)
    line = runner.angles(script.rows, decision, resting=True)
    angles = runner.angles(script.rows, decision, resting=False)
    return _compared(_ScriptRun(script, profile, interval, decision, line, angles))


def _interval(profile: FlowchartProfile, script: Script) -> int:
    """Return the number of steps from decision to decision."""
    steps = profile.period / script.control_period_s
    if round(steps) < 1 or not math.isclose(steps, round(steps), rel_tol=1e-6):
        raise InputError(
            f"the script '{script.name}' has a control_period_s of {script.control_period_s:g} s, but the candidate's "
            f"search has a period of {profile.period:g} s, which must be a whole number of them"
        )
    return round(steps)


@dataclass(frozen=True)
class _Runner:
    """Runs rows, each held from one decision to the next."""

    controller: AnyController
    profile: FlowchartProfile
    script: Script
    interval: int

    def first_decision(self) -> int | None:
        """Return the first step, within an interval, in which a decision shows; None where none ever does."""
        rows = probe(self.script.drive, self.profile, self.script.rows[0].speed_rpm).rows
        line = self.angles(rows, 0, resting=True)
        changes = np.abs(np.diff(self.angles(rows, 0, resting=False) - line, prepend=0.0))
        found = np.flatnonzero(changes > ANGLE_ROUNDING)
        return int(found[0]) % self.interval if found.size else None

    def angles(self, rows: tuple[ScriptRow, ...], decision: int, *, resting: bool) -> NDArray[np.float64]:
        """Return the angle of every step, with the search at work or resting."""
        values = np.array(
            [(row.speed_reference_rpm, row.speed_rpm, row.current_sum_a, row.supply_v) for row in rows]
        )
        if resting:
            away = 2.0 * self.profile.speed_tolerance / RADIANS_PER_RPM + _AWAY_RPM
            values[:, 0] = values[:, 1] + away
            values[:, 2] = values[0, 2]
        values[:, :2] *= RADIANS_PER_RPM
        lengths = np.full(len(rows), self.interval)
        lengths[0] += decision + 1
        signals = np.repeat(values, lengths, axis=0)
        show_drive(self.controller, self.script.drive)
        angles = scripted_angles(self.controller, self.script.nameplate(), signals)
        # An angle so far out departs from any flowchart, and differences of angles stay finite.
        return np.clip(angles, -_FAR_OUT, _FAR_OUT)


@dataclass(frozen=True)
class _ScriptRun:
    """A script's run, and the same with the search at rest."""

    script: Script
    profile: FlowchartProfile
    interval: int
    decision: int
    line: NDArray[np.float64]
    angles: NDArray[np.float64]

    def sensed(self, number: int) -> Sensed:
        """Return what the search senses at a decision."""
        row = self.script.rows[self.row(number)]
        error = (row.speed_reference_rpm - row.speed_rpm) * RADIANS_PER_RPM
        line = float(self.line[self.step(number)])
        return Sensed(error, row.current_sum_a, row.supply_v, line)

    def step(self, number: int) -> int:
        """Return the step in which a decision shows."""
        return self.decision + number * self.interval

    def row(self, number: int) -> int:
        return max(number - FREE_DECISIONS + 1, 0)

    def deviations(self, searches: frozenset[SearchState], begin: int, end: int) -> dict[float, float]:
        """Return how far the angles of some steps are from those of searches, by their offset (rad)."""
        line, angles = self.line[begin:end], self.angles[begin:end]
        return {
            offset: float(np.max(np.abs(angles - np.clip(line + offset, 0.0, LARGEST_ANGLE)), initial=0.0))
            for offset in {search.offset for search in searches}
        }


def _compared(run: _ScriptRun) -> ScriptVerdict:
    rows = run.script.rows
    searches = beginnings()
    before = _nearest(run, searches, 0, run.decision)
    if before > ANGLE_ROUNDING:
        return _departure(run, 0, before, "the angle moves before the first decision")
    for number in range(len(rows) + FREE_DECISIONS - 1):
        begin, end = run.step(number), min(run.step(number + 1), len(run.angles))
        options = allowed(
            searches,
            run.sensed(number),
            run.profile,
            run.script.drive.inverter.supply_voltage_v,
            free=number < FREE_DECISIONS,
        )
        deviations = run.deviations(options, begin, end)
        searches = frozenset(search for search in options if deviations[search.offset] <= ANGLE_ROUNDING)
        if not searches:
            measured = _deviation_text(run, number, options)
            return _departure(run, number, min(deviations.values()), measured)
    decisions = len(rows) + FREE_DECISIONS - 1
    return ScriptVerdict(Margin(CHECK, 1.0, f"all {decisions} decisions as Fig. 4 has them"), len(rows))


def _nearest(run: _ScriptRun, options: frozenset[SearchState], begin: int, end: int) -> float:
    return min(run.deviations(options, begin, end).values())


def _departure(run: _ScriptRun, number: int, deviation: float, measured: str) -> ScriptVerdict:
    row = run.row(number)
    steps = min(deviation / run.profile.step, GREATEST)
    return ScriptVerdict(
        Margin(CHECK, -(round(steps, _DIGITS) or steps), f"row {row + 1}, {measured}"), row + 1
    )


def _deviation_text(run: _ScriptRun, number: int, options: frozenset[SearchState]) -> str:
    """State what is wrong with a decision."""
    begin = run.step(number)
    time = begin * run.script.control_period_s
    if _nearest(run, options, begin, begin + 1) <= ANGLE_ROUNDING:
        return f"after the decision at {time:.4g} s: the angle changes before the next one is due"
    sensed = run.sensed(number)
    offset = float(run.angles[begin] - run.line[begin])
    expected = sorted({round(math.degrees(search.angle(sensed.line) - sensed.line), 6) for search in options})
    listed = " or ".join(f"{angle:+.4g}°" for angle in expected)
    reason = described(sensed, run.sensed(max(number - 1, 0)), run.profile)
    return (
        f"at {time:.4g} s: the angle is {math.degrees(offset):+.4g}° from the initial one, but Fig. 4 has {listed}, "
        f"since {reason}"
    )
