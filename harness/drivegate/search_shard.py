"""The part of a check that one job does inside a worker process: run scenarios, judge them, search for worse."""

from __future__ import annotations

from dataclasses import dataclass
from tempfile import TemporaryDirectory
from typing import Any

from hypothesis import HealthCheck, Phase, given, seed, settings, target
from hypothesis.configuration import set_hypothesis_home_dir

from drivegate.catalogue import CHECKS
from drivegate.controller import Controller
from drivegate.drawn_scenarios import drawn_scenarios
from drivegate.margin import Margin
from drivegate.run_record import RunRecord
from drivegate.scenario_run import RADIANS_PER_RPM, run_scenario
from drivegate.shared_progress import SharedProgress
from drivegate.worker_messages import LoadedCandidate
from drivegate_cases.motor import load_motor
from drivegate_cases.profile import dwells
from drivegate_cases.scenario import Scenario
from drivegate_models.oracle import feasible_edge

_REQUIRED = frozenset(
    check.id for check in CHECKS if check.level == "required" and check.subject == "candidate"
)


@dataclass(frozen=True)
class FixedRuns:
    """Scenarios to be run as they are.

    Attributes
    ----------
    scenarios : tuple of Scenario
        The scenarios.
    repeat : bool
        Whether the first of them is run again afterwards, on the same instance and on a new one.
    """

    scenarios: tuple[Scenario, ...]
    repeat: bool = False


@dataclass(frozen=True)
class DrawnRuns:
    """A shard of the search.

    Attributes
    ----------
    motor : str
        Name of the motor.
    seed : int
        Seed of this shard.
    examples : int
        Number of scenarios to draw.
    """

    motor: str
    seed: int
    examples: int


@dataclass(frozen=True)
class JudgedRun:
    """A run's scenario and margins; what a worker hands back.

    Attributes
    ----------
    scenario : dict
        The scenario as plain data.
    margins : tuple of Margin
        Of every check that applies.
    """

    scenario: dict[str, Any]
    margins: tuple[Margin, ...]


@dataclass(frozen=True)
class ShardOutcome:
    """What a job came to.

    Attributes
    ----------
    runs : tuple of JudgedRun
        In the order in which they were made.
    set_aside : int
        Scenarios that no angle can satisfy, which were not run.
    """

    runs: tuple[JudgedRun, ...]
    set_aside: int = 0


def judged(record: RunRecord) -> JudgedRun:
    """Apply every check to a run.

    Parameters
    ----------
    record : RunRecord
        The run.

    Returns
    -------
    JudgedRun
        Scenario and margins.
    """
    margins = (check.evaluate(record) for check in CHECKS)
    return JudgedRun(record.scenario.to_mapping(), tuple(margin for margin in margins if margin is not None))


def is_feasible(scenario: Scenario) -> bool:
    """Tell whether the plant can give what every steady stretch asks for, at some angle.

    Parameters
    ----------
    scenario : Scenario
        The scenario.

    Returns
    -------
    bool
        Whether the oracle finds a robustly feasible angle for each.
    """
    drive = scenario.motor.drive(scenario.scales)
    for dwell in dwells(scenario):
        if dwell.load_factor == 0.0 or scenario.load.kind == "locked":
            continue
        torque = dwell.load_factor * scenario.load.torque_at(dwell.speed_rpm) + drive.friction
        edge = feasible_edge(drive, dwell.speed_rpm * RADIANS_PER_RPM, torque, dwell.supply_v)
        if edge != edge:
            return False
    return True


def run_fixed(loaded: LoadedCandidate, plan: FixedRuns) -> ShardOutcome:
    """Run scenarios as they are.

    Parameters
    ----------
    loaded : LoadedCandidate
        The candidate.
    plan : FixedRuns
        The scenarios.

    Returns
    -------
    ShardOutcome
        Their margins.
    """
    controller = loaded.controller()
    runs = [run_scenario(scenario, controller, progress=loaded.progress) for scenario in plan.scenarios]
    repeated: tuple[int, ...] = ()
    if plan.repeat:
        first = plan.scenarios[0]
        again = run_scenario(first, controller, progress=loaded.progress).digest
        afresh = run_scenario(first, loaded.controller(), progress=loaded.progress).digest
        repeated = (again, afresh)
    declaration = loaded.candidate.declaration
    records = [
        RunRecord(scenario, run, declaration, repeated if index == 0 else ())
        for index, (scenario, run) in enumerate(zip(plan.scenarios, runs, strict=True))
    ]
    return ShardOutcome(tuple(judged(record) for record in records))


class _Collector:
    """Runs what Hypothesis draws, and keeps what comes of it."""

    def __init__(self, loaded: LoadedCandidate) -> None:
        self._controller: Controller = loaded.controller()
        self._progress: SharedProgress = loaded.progress
        self._declaration = loaded.candidate.declaration
        self._seen: dict[str, float] = {}
        self.runs: list[JudgedRun] = []
        self.set_aside = 0

    def worst(self, scenario: Scenario) -> float:
        """Run a scenario, unless it was run before, and return the least required margin."""
        if scenario.name not in self._seen:
            self._seen[scenario.name] = self._run(scenario)
        return self._seen[scenario.name]

    def _run(self, scenario: Scenario) -> float:
        if not is_feasible(scenario):
            self.set_aside += 1
            return 1.0
        run = run_scenario(scenario, self._controller, progress=self._progress)
        outcome = judged(RunRecord(scenario, run, self._declaration))
        self.runs.append(outcome)
        return min(
            (margin.value for margin in outcome.margins if margin.check in _REQUIRED and not margin.advisory),
            default=1.0,
        )


def run_drawn(loaded: LoadedCandidate, plan: DrawnRuns) -> ShardOutcome:
    """Draw scenarios and climb toward the smallest margin.

    Parameters
    ----------
    loaded : LoadedCandidate
        The candidate.
    plan : DrawnRuns
        Motor, seed and effort.

    Returns
    -------
    ShardOutcome
        Margins of every distinct scenario drawn.
    """
    collector = _Collector(loaded)
    motor = load_motor(plan.motor)

    @seed(plan.seed)
    @settings(
        max_examples=plan.examples,
        database=None,
        deadline=None,
        derandomize=False,
        phases=(Phase.generate, Phase.target),
        suppress_health_check=list(HealthCheck),
    )
    @given(drawn_scenarios(motor))
    def explore(scenario: Scenario) -> None:
        target(-max(min(collector.worst(scenario), 1e6), -1e6), label="least margin")

    with TemporaryDirectory(prefix="drivegate") as folder:
        # Hypothesis keeps notes of its own; they belong to nobody's working folder.
        set_hypothesis_home_dir(folder)
        explore()
    return ShardOutcome(tuple(collector.runs), collector.set_aside)
