"""What a check does, in which order: a fixed number of jobs, whatever the number of workers."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from enum import Enum, auto
from typing import Final

from drivegate.candidates.declaration import NOTHING_DECLARED, Declaration
from drivegate.candidates.kinds import KINDS
from drivegate.candidates.python.bridge import PythonController
from drivegate.candidates.step_costs import greatest_costs
from drivegate.checks.check import JudgedRun, ShardOutcome
from drivegate.checks.every_contract import LARGEST_SHARE, TIM_1, counted_margin
from drivegate.checks.margin import Margin, below
from drivegate.containment.contained_controller import ContainedController
from drivegate.containment.messages import AnyController, Job, JudgedCandidate
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.kinds import DEFAULT_DRIVE
from drivegate.drives.running import recorded, taken_costs
from drivegate.gate.focus import WHOLE, Focus
from drivegate.gate.own_requirements import own_job
from drivegate.gate.shard import DrawnRuns, FixedRuns, JointRuns, run_drawn, run_fixed, run_joint
from drivegate.results.baseline import Baseline, scenario_key
from drivegate.results.counterexample import Counterexample
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.drive.plant import NOMINAL
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.script import Script

EXAMPLES: Final = {"quick": 4, "default": 36, "nightly": 400}
"""Scenarios drawn in each shard, by effort."""
SHARDS: Final = 8
"""Number of seeded shards, whatever the number of workers; those of odd numbers are a candidate's own."""
_TURNS: Final = 720720
"""A number that 1 to 16 divide: seeds that differ by it take the same turn at as many families of scenarios."""
JOINT: Final = {"quick": 0, "default": 1, "nightly": 5}
"""Times that the runs of joint changes are drawn, by effort."""
OWN_DRAWS: Final = {"quick": 4, "default": 16, "nightly": 100}
"""Scenarios drawn from each of the user's own that has ranges, by effort."""
SCRIPTS: Final = {"quick": 10, "default": 60, "nightly": 600}
"""Scripts drawn for a candidate of the profile `flowchart`, by effort."""
LONG_RUNS: Final = "nightly"
"""Effort with runs of some minutes."""
REPEATED: Final = "DET-1"
"""Check that is judged on repetitions of a scenario."""


class Origin(Enum):
    """Where the scenarios of a job come from, in the order in which their runs are judged."""

    LAST_FAILED = auto()
    FIXED = auto()
    CORPUS = auto()
    BASELINE = auto()
    SCRIPTS = auto()
    DRAWN = auto()
    TIMED = auto()


_OF_ONE_CHECK: Final = {Origin.SCRIPTS: "FLO-1", Origin.TIMED: TIM_1.id}


@dataclass(frozen=True)
class Work:
    job: Job[ShardOutcome]
    runs: int
    """Number of runs at most."""
    label: str
    """Name of its last scenario."""
    origin: Origin


def planned_work(
    effort: str,
    seed: int,
    *,
    declaration: Declaration = NOTHING_DECLARED,
    search: bool = True,
    corpus: Sequence[Counterexample] = (),
    baseline: Baseline | None = None,
    drive: DriveDocument | None = None,
    focus: Focus = WHOLE,
    content_hash: str = "",
) -> list[Work]:
    """Plan the runs of a check on a drive, the default one where none is given.

    `content_hash`: that of a candidate that is to meet scenarios of its own, empty where candidates are compared.
    """
    drive = drive or load_drive(DEFAULT_DRIVE)
    fixed = contract_of(drive).fixed_scenarios(drive, declaration)
    repeated = _repeated(fixed[2:])
    if effort == LONG_RUNS:
        fixed += contract_of(drive).long_scenarios(drive, declaration)
    examples = EXAMPLES[effort]
    judges_scripts = focus.judges(_OF_ONE_CHECK[Origin.SCRIPTS])
    shards = [
        DrawnRuns(drive, shard_seed, examples, search=search, only=focus.only)
        for shard_seed in shard_seeds(seed, content_hash)
    ]
    scripts = contract_of(drive).scripted_runs(drive, declaration, seed, SCRIPTS[effort])
    work = [
        *(_stored(stored, Origin.LAST_FAILED, focus) for stored in focus.first),
        _as_they_are(fixed[:2], Origin.FIXED, focus, repeat=True),
        *(
            _as_they_are((scenario,), Origin.FIXED, focus, repeat=scenario in repeated)
            for scenario in fixed[2:]
        ),
        *_own(drive, declaration, effort, seed),
        *(
            _stored(stored, Origin.CORPUS, focus)
            for stored in corpus
            if judges_scripts or not isinstance(stored.scenario, Script)
        ),
        *(_as_they_are((scenario,), Origin.BASELINE, focus) for scenario in _not_among(fixed, baseline)),
        *([] if scripts is None else [Work(*scripts, "scripts", Origin.SCRIPTS)]),
        *(
            Work(Job(run_drawn, drawn), examples, f"shard {number}", Origin.DRAWN)
            for number, drawn in enumerate(shards, start=1)
        ),
        *_joint(drive, seed, JOINT[effort], focus),
        # Last, so that fewer processes are at work beside it.
        Work(Job(time_steps, fixed[0], is_plain=True), 1, fixed[0].name, Origin.TIMED),
    ]
    return [item for item in work if _serves(item.origin, focus)]


def shard_seeds(seed: int, content_hash: str = "") -> tuple[int, ...]:
    """Derive the seeds of all shards; with a candidate's hash, every other one depends on that too.

    So a controller that has learned the scenarios of a seed by heart, and was changed for that, meets others.
    """
    own = seed
    if content_hash:
        digest = hashlib.sha256(f"{seed} {content_hash}".encode()).hexdigest()
        own += _TURNS * int(digest[:10], 16)
    return tuple((own if shard % 2 else seed) * SHARDS + shard for shard in range(SHARDS))


def _own(drive: DriveDocument, declaration: Declaration, effort: str, seed: int) -> list[Work]:
    """Plan the scenarios of the user's own requirements; those with ranges are drawn."""
    own = declaration.requirements
    if own is None:
        return []
    drawn = own.drawn_on(drive, OWN_DRAWS[effort], seed)
    runs = [(Origin.FIXED, scenario) for scenario in own.scenarios_on(drive)]
    runs += [(Origin.DRAWN, scenario) for scenario in drawn]
    return [Work(own_job(scenario), 1, scenario.name, origin) for origin, scenario in runs]


def _repeated(fixed: Sequence[Scenario]) -> list[Scenario]:
    """Choose what is repeated beside the first run: the fastest one, and the first with each kind of trouble.

    Counters of errors and detected failures are what a reset forgets most easily.
    """
    fastest = sorted(fixed, key=lambda run: -max(speed for _, speed in run.speed_rpm))
    on_other_plants = [run for run in fixed if run.scales != NOMINAL]
    losing_samples = [run for run in fixed if run.dropouts]
    failing = [run for run in fixed if run.failure is not None]
    return [run for runs in (fastest, on_other_plants, losing_samples, failing) for run in runs[:1]]


def _serves(origin: Origin, focus: Focus) -> bool:
    """Return True if runs of an origin can say anything of the checks that are judged."""
    if not focus.only or origin in (Origin.LAST_FAILED, Origin.CORPUS):
        return True
    if origin in _OF_ONE_CHECK:
        return _OF_ONE_CHECK[origin] in focus.only
    others = set(focus.only) - set(_OF_ONE_CHECK.values())
    return bool(others if origin is Origin.FIXED else others - {REPEATED})


def _stored(stored: Counterexample, origin: Origin, focus: Focus) -> Work:
    if isinstance(stored.scenario, Script):
        return Work(Job(run_stored_script, stored.scenario), 1, stored.scenario.name, origin)
    return _as_they_are((stored.scenario,), origin, focus, repeat=stored.check == REPEATED)


def run_stored_script(loaded: JudgedCandidate, script: Script) -> ShardOutcome:
    """Run a script of the corpus; this is what the worker process does."""
    margin = contract_of(script.drive).script_margin(loaded, script)
    return ShardOutcome(() if margin is None else (JudgedRun(script.to_mapping(), (margin,)),))


def _joint(drive: DriveDocument, seed: int, times: int, focus: Focus) -> list[Work]:
    """Plan runs of joint changes, all parts of every pass over the covering array."""
    rows = contract_of(drive).joint_rows()
    if rows == 0:
        return []
    most = -(-rows // SHARDS) + 1
    return [
        Work(
            Job(run_joint, JointRuns(drive, seed * times + number, part, SHARDS, focus.only)),
            most,
            f"joint {number * SHARDS + part + 1}",
            Origin.DRAWN,
        )
        for number in range(times)
        for part in range(SHARDS)
    ]


def _as_they_are(
    scenarios: tuple[Scenario, ...], origin: Origin, focus: Focus, *, repeat: bool = False
) -> Work:
    # What is kept was found on a run that was made; of a drive of one's own, nobody knows yet what it can do.
    plan = FixedRuns(
        scenarios,
        repeat=repeat and focus.judges(REPEATED),
        only_fair=origin is Origin.FIXED,
        only=focus.only,
    )
    job = Job(run_fixed, plan)
    return Work(job, len(scenarios), scenarios[-1].name, origin)


def _not_among(fixed: Iterable[Scenario], baseline: Baseline | None) -> list[Scenario]:
    """Choose the baseline's scenarios that are not run anyway, each once."""
    known = {scenario_key(scenario.to_mapping()) for scenario in fixed}
    chosen = []
    for scenario in (run.scenario for run in (baseline.fixed if baseline is not None else ())):
        key = scenario_key(scenario.to_mapping())
        if key not in known:
            known.add(key)
            chosen.append(scenario)
    return chosen


def time_steps(loaded: JudgedCandidate, scenario: Scenario) -> ShardOutcome:
    """Record a run, then time the candidate's steps on its first Senses."""
    controller = loaded.controller()
    record = recorded(loaded, scenario, controller, trace_every=1)
    step_time = contract_of(scenario.drive).step_seconds(controller, record)
    kind = loaded.candidate.kind
    costs = greatest_costs((record.costs, taken_costs(controller)))
    margin = counted_margin(costs, loaded.candidate.step_limits)
    if margin is None and not KINDS[kind].untimed_because:
        margin = timing_margin(way_of_running(kind, controller), step_time, scenario.control_period_s)
    margins = () if margin is None else (margin,)
    return ShardOutcome((JudgedRun(scenario.to_mapping(), margins, costs=costs),))


def way_of_running(kind: str, controller: AnyController) -> str:
    """State how a candidate's step runs, without which its time says little."""
    is_python = (
        controller.is_python
        if isinstance(controller, ContainedController)
        else isinstance(controller, PythonController)
    )
    return KINDS[kind].way_of_running or ("Python" if is_python else "native")


def timing_margin(way: str, step_time: float, control_period: float) -> Margin:
    share = step_time / control_period
    measured = f"{1e6 * step_time:.3g} µs a step ({way}), {100.0 * share:.3g} % of the control period"
    return Margin(TIM_1.id, below(step_time, LARGEST_SHARE * control_period), measured, is_timed=True)
