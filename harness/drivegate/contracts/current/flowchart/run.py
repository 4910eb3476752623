"""The job that runs scripts with a candidate of the profile `flowchart`, and makes a failing one shorter."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from drivegate.candidates.declaration import Declaration, FlowchartProfile
from drivegate.checks.check import JudgedRun, ShardOutcome
from drivegate.checks.margin import Margin
from drivegate.containment.messages import AnyController, Job, JudgedCandidate
from drivegate.contracts.current.flowchart.judging import judge_script
from drivegate.contracts.current.flowchart.scripts import Event, fixed_scripts, script_of, usual_speed
from drivegate.scenarios.drive_scale import scale_of, tidy
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.script import Script

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy


@dataclass(frozen=True)
class ScriptRuns:
    """Scripts to be run with a candidate of the profile `flowchart`."""

    drive: DriveDocument
    seed: int
    examples: int
    """Number of scripts to draw, besides the fixed ones."""


def scripted_runs(
    drive: DriveDocument, declaration: Declaration, seed: int, examples: int
) -> tuple[Job[ShardOutcome], int] | None:
    """Plan the scripts of a candidate, and count them; None for one of another profile."""
    speed = usual_speed(drive, declaration.speed_range_rpm)
    if declaration.flowchart is None or speed is None:
        return None
    count = len(fixed_scripts(drive, declaration.flowchart, speed)) + examples
    return Job(run_scripts, ScriptRuns(drive, seed, examples)), count


SHORTENING_RUNS: Final = 60
"""Runs that may be spent on making one failing script shorter."""


def run_scripts(loaded: JudgedCandidate, plan: ScriptRuns) -> ShardOutcome:
    """Run the fixed scripts, then drawn ones."""
    declaration = loaded.candidate.declaration
    profile = declaration.flowchart
    speed = usual_speed(plan.drive, declaration.speed_range_rpm)
    if profile is None or speed is None:
        return ShardOutcome(())
    controller = loaded.controller()
    runs: dict[str, JudgedRun] = {}
    failures: list[Script] = []

    def judge(script: Script) -> None:
        if script.name not in runs:
            margin = judge_script(controller, profile, script).margin
            runs[script.name] = JudgedRun(script.to_mapping(), (margin,))
            if not margin.met:
                failures.append(script)

    for fixed in fixed_scripts(plan.drive, profile, speed):
        judge(fixed)

    for drawn in _drawn(_drawn_scripts(plan.drive, profile, declaration.speed_range_rpm), plan):
        judge(drawn)
    if failures:
        shortest = min(failures, key=lambda script: len(script.rows))
        judge(shortened(controller, profile, shortest))
    return ShardOutcome(tuple(runs.values()))


def _drawn(scripts: SearchStrategy[Script], plan: ScriptRuns) -> list[Script]:
    """Draw as many scripts as planned; Hypothesis cannot draw none."""
    drawn: list[Script] = []
    if plan.examples == 0:
        return drawn
    from hypothesis import HealthCheck, Phase, given, seed, settings

    from drivegate.scenarios.isolation import from_the_seed_alone

    @seed(plan.seed)
    @settings(
        max_examples=plan.examples,
        database=None,
        deadline=None,
        derandomize=False,
        phases=(Phase.generate,),
        suppress_health_check=list(HealthCheck),
    )
    @given(scripts)
    def draw(script: Script) -> None:
        drawn.append(script)

    with from_the_seed_alone():
        draw()
    return drawn


def script_margin(loaded: JudgedCandidate, script: Script) -> Margin | None:
    profile = loaded.candidate.declaration.flowchart
    if profile is None:
        return None
    return judge_script(loaded.controller(), profile, script).margin


def shortened(controller: AnyController, profile: FlowchartProfile, script: Script) -> Script:
    """Make a failing script shorter and rounder for as long as it fails."""
    verdict = judge_script(controller, profile, script)
    # What comes after the first departure has no part in it.
    simplest = script.replaced(rows=script.rows[: verdict.rows])
    waiting = _simpler(simplest)
    for _ in range(SHORTENING_RUNS):
        simpler = next(waiting, None)
        if simpler is None:
            break
        if not judge_script(controller, profile, simpler).margin.met:
            simplest, waiting = simpler, _simpler(simpler)
    if simplest == script:
        return script
    return simplest.replaced(
        name=f"{script.name}-shortened",
        description=f"The script {script.name}, made simpler for as long as the candidate departs from Fig. 4.",
    )


def _simpler(script: Script) -> Iterator[Script]:
    """Return scripts that are simpler in one thing each, what simplifies most first."""
    rows = script.rows
    if len(rows) > 1:
        for index in range(len(rows)):
            yield script.replaced(rows=rows[:index] + rows[index + 1 :])
    speed = rows[0].speed_rpm
    for index, row in enumerate(rows):
        for change in (
            {"speed_reference_rpm": row.speed_rpm},
            {"speed_rpm": speed, "speed_reference_rpm": speed},
            *({"current_sum_a": round(row.current_sum_a, digits)} for digits in range(4)),
        ):
            simpler = row.model_copy(update=change)
            if simpler != row:
                yield script.replaced(rows=(*rows[:index], simpler, *rows[index + 1 :]))


def _drawn_scripts(
    drive: DriveDocument, profile: FlowchartProfile, speed_range_rpm: tuple[float, float] | None
) -> SearchStrategy[Script]:
    lowest, highest = speed_range_rpm or (0.0, math.inf)
    scale = scale_of(drive)
    step = scale.speed_step_rpm
    lowest = max(lowest, scale.speed(0.1))
    highest = max(min(highest, scale.highest_loaded_rpm), lowest)
    from hypothesis import strategies as st

    powers = st.sampled_from((0.0, -2.0, 2.0, -3.0, 3.0, -5.0, 5.0, -0.5, 0.5))
    errors = st.sampled_from((0.0, 0.0, 0.0, 0.0, 0.0, 0.5, -0.5, 1.5, -1.5))

    def script(slower: int, events: list[Event]) -> Script:
        speed_rpm = tidy(highest - step * slower)
        digest = hashlib.sha256(repr(events).encode()).hexdigest()[:8]
        name = f"drawn-{speed_rpm:g}rpm-{len(events) + 1}-rows-{digest}"
        return script_of(
            name, drive, profile, speed_rpm, events, "Changes of power and speed drawn at random."
        )

    return st.builds(
        script,
        st.integers(0, int((highest - lowest) // step)),
        st.lists(st.tuples(powers, errors).map(lambda pair: Event(*pair)), min_size=1, max_size=24),
    )
