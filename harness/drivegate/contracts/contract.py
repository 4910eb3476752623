"""What everything outside of the contracts' folders knows of a contract."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

if TYPE_CHECKING:
    import numpy as np
    from hypothesis.strategies import SearchStrategy
    from numpy.typing import NDArray

    from drivegate.candidates.declaration import Declaration
    from drivegate.checks.check import Check, Record, ShardOutcome
    from drivegate.checks.margin import Margin
    from drivegate.containment.messages import AnyController, Job, JudgedCandidate
    from drivegate.contracts.comparison import Comparison
    from drivegate.contracts.drawings import Panel
    from drivegate.contracts.given_steps import GivenSteps
    from drivegate.scenarios.drawn_range import DrawnRange
    from drivegate.scenarios.simplification import Simplification
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.scenario import Scenario
    from drivegate_cases.scenario.script import Script
    from drivegate_models.contract.layout import Layout

Columns: TypeAlias = "dict[str, NDArray[np.float64]]"
"""Arrays of equal length, shape (n,), by the name of the column, which has the unit."""


@dataclass(frozen=True)
class RecordedTrace:
    """The signals of a run, each a mean over a stretch of it."""

    scenario: Scenario
    columns: Columns
    judged_s: tuple[float, float]
    """Start and end of the stretch that the check was judged on (s)."""


@dataclass(frozen=True)
class Witness:
    """A built-in controller that passes the packaged drives of some kinds."""

    candidate: str
    kinds: tuple[str, ...]
    """Kinds of drives whose packaged ones it passes; on others it is no witness."""
    knows_plant: bool = False
    """Whether it knows more of the drive than its nameplate states, so that it shows what is possible, not what is
    reasonable."""
    made_for: Callable[[Scenario], Any] | None = None
    """Make a controller in Python for one scenario, of a witness that knows the scenario; None for a candidate that
    its string names."""
    only_on: tuple[str, ...] = ()
    """The checks that it is heard on, where it shares the part that all others judge with an earlier witness; all
    without any."""
    silent_on: tuple[str, ...] = ()
    """Checks that it is not heard on, since it shares or lacks the part that they judge."""
    sensed: bool = True
    """Whether it controls drives with a position sensor; otherwise those without one."""

    def is_heard_on(self, check: str) -> bool:
        """Return True if it can show something on a check that earlier witnesses cannot."""
        return check not in self.silent_on and (not self.only_on or check in self.only_on)


class Contract(ABC):
    """The boundary between a controller and a drive, and everything that is judged by it.

    A contract's module imports compiled code, so `contracts.catalogue` imports it when the contract is first asked for.
    What takes long to import and few commands need is imported in the methods: Hypothesis, comparisons, behaviour.
    """

    name: ClassVar[str]
    """Its name in manifests, drives and results."""
    candidates: ClassVar[str]
    usual_candidate: ClassVar[str]
    """Name of a built-in controller that runs on every drive of this contract."""
    rehearsed: ClassVar[str]
    """Name of a built-in controller that fails checks: running it compiles what only failures need."""
    witnesses: ClassVar[tuple[Witness, ...]]
    """Known good controllers, in the order in which they are run where a candidate fails a check."""
    checks: ClassVar[tuple[Check, ...]]
    """The checks of a run, in the order in which they are reported."""
    families: ClassVar[tuple[str, ...]]
    simplifications: ClassVar[tuple[Simplification, ...]]
    """The ways in which a scenario can be simplified, in the order in which they are tried."""
    layout: ClassVar[Layout]
    """The records that pass between controller and drive."""
    sensed: ClassVar[Mapping[str, str]]
    """Fields of a sense to print, each with its unit."""
    moved_by: ClassVar[Mapping[str, str]]
    """Fields of a sense, each with the keys of a scenario or a drive that move it."""
    outputs: ClassVar[Mapping[str, tuple[str, str]]]
    """Fields of a command that a controller writes, each with its name and unit."""
    plotted: ClassVar[Mapping[str, tuple[str, float]]]
    """Fields of a command that figures show, each with the unit there and a factor for it."""
    recorded_names: ClassVar[tuple[str, ...]]
    """Names of the recorded columns without which a run cannot be described."""
    signal_names: ClassVar[tuple[str, ...]] = ()
    """Names of the columns of `signals`, which the user's own requirements can limit."""
    further_names: ClassVar[tuple[str, ...]] = ()
    """Names of columns that some results keep besides, such as what the controller sensed in a run that fails."""
    panels: ClassVar[tuple[Panel, ...]] = ()
    """How figures show the recorded columns; without any, each has a panel. `panels_of` has those of one run."""
    summary_rows: ClassVar[tuple[tuple[str, str, str], ...]]
    """Keys of `summary` to print, each with its name and unit."""
    window_columns: ClassVar[tuple[tuple[str, str], ...]]
    """Keys of `windows` to print, each with its heading."""
    observations: ClassVar[tuple[str, ...]]
    """Names of the figures that a campaign keeps of each run, with their units."""
    has_behaviour: ClassVar[bool] = False
    """Whether reports show more of a candidate than its checks."""

    @abstractmethod
    def numbers(self, drive: DriveDocument, declaration: Declaration, /) -> Mapping[str, str]:
        """Return a drive's numbers, and those that a candidate declares, by the names that the texts of checks use."""

    @abstractmethod
    def fixed_scenarios(self, drive: DriveDocument, declaration: Declaration) -> tuple[Scenario, ...]:
        """Return the scenarios that every check of a candidate runs first."""

    def long_scenarios(self, _drive: DriveDocument, _declaration: Declaration, /) -> tuple[Scenario, ...]:
        """Return the runs of some minutes that only the greatest effort makes."""
        return ()

    @abstractmethod
    def drawn_scenarios(
        self, drive: DriveDocument, declaration: Declaration, group: int | None
    ) -> SearchStrategy[Scenario]:
        """Return the scenarios to draw from: those of one group of families, or of all for None."""

    def joint_rows(self) -> int:
        """Return the number of joint changes in one pass; 0 where this contract has none."""
        return 0

    def joint_scenarios(
        self, drive: DriveDocument, declaration: Declaration, seed: int, part: int, parts: int
    ) -> tuple[Scenario, ...]:
        """From a seed, the number of a part and of all parts, return fair scenarios of joint changes."""
        raise NotImplementedError

    def scripted_runs(
        self, _drive: DriveDocument, _declaration: Declaration, _seed: int, _examples: int, /
    ) -> tuple[Job[ShardOutcome], int] | None:
        """Return the job that runs fixed and drawn scripts, and their number; None for a candidate without any."""
        return None

    def script_margin(self, _loaded: JudgedCandidate, _script: Script, /) -> Margin | None:
        """Judge a candidate on one script; None where it is not judged by scripts."""
        return None

    @abstractmethod
    def unfair_because(self, scenario: Scenario) -> str | None:
        """Return the reason why no controller can do what a scenario requires; None where one can."""

    @abstractmethod
    def drawn_range(self, scenario: Scenario) -> DrawnRange:
        """Return the range that scenarios of a family are drawn from, which no simplification leaves."""

    @abstractmethod
    def unseen(self, declaration: Declaration, scenario: Scenario) -> Record:
        """Return the record of a run that was not made: reading what only a run shows raises `checks.check.NotRun`."""

    @abstractmethod
    def record(
        self,
        prepare: Any,
        declaration: Declaration,
        scenario: Scenario,
        controller: AnyController,
        *,
        trace_every: int = 0,
        kept: NDArray[Any] | None = None,
        keeps_steps: bool = False,
    ) -> Record:
        """Run a controller for the checks against a plant's loop; `kept` receives its commands.

        With `keeps_steps` the record has what the controller sensed and answered, where the trace has every step.
        """

    @abstractmethod
    def judged_window(self, check: Check, record: Any, margin: Margin | None) -> tuple[float, float]:
        """Return start and end of the stretch of a run that decides a margin (s)."""

    def settled_until(self, scenario: Scenario, /) -> tuple[float, ...]:
        """Return the ends of the stretches in which nothing changes for as long as a drive needs to settle (s)."""
        from drivegate_cases.scenario.profile import dwells

        return tuple(dwell.end for dwell in dwells(scenario))

    @abstractmethod
    def step_seconds(self, controller: AnyController, record: Any) -> float:
        """Measure the time of one step on what was sensed in a run whose trace has every step (s)."""

    def nameplate(self, scenario: Scenario, **_options: Any) -> Any:
        """Return what a controller is reset with before a scenario."""
        return scenario.nameplate()

    @abstractmethod
    def run(self, *arguments: Any, **options: Any) -> Any:
        """Run a controller once: plant's loop, scenario, controller, and by name `wrap`, to put something around it."""

    @abstractmethod
    def given_steps(self, controller: AnyController, nameplate: Any) -> GivenSteps:
        """From a controller and its nameplate, return steps through given Senses."""

    @abstractmethod
    def plant_state(
        self, prepare: Any, scenario: Scenario, commands: NDArray[Any], step: int
    ) -> dict[str, Any]:
        """From a plant's loop, a scenario, a run's commands and a step, return the plant's own state at its start."""

    @abstractmethod
    def signals(self, run: Any) -> Columns:
        """Return the columns of a run's trace in people's units, by name."""

    def signal(self, run: Any, name: str) -> NDArray[np.float64]:
        """Return one column of a run's trace, one of `signal_names`."""
        return self.signals(run)[name]

    def signal_names_on(self, _drive: DriveDocument, /) -> tuple[str, ...]:
        """Return those of `signal_names` that runs on a drive show."""
        return self.signal_names

    def recorded_signals(self, run: Any) -> Columns:
        """Return the columns of a run's trace that a result keeps."""
        return self.signals(run)

    def panels_of(self, _scenario: Scenario, /) -> tuple[Panel, ...]:
        """Return how figures show the recorded columns of a run."""
        return self.panels

    def sensed_signals(self, _scenario: Scenario, _run: Any, _steps: NDArray[Any], /) -> Columns:
        """Return what the controller of a run has sensed, as columns as long as those of the trace."""
        return {}

    @abstractmethod
    def account(self, trace: RecordedTrace) -> tuple[str, ...]:
        """Describe a recorded run in sentences."""

    def marked_angle(self, _trace: RecordedTrace) -> tuple[float, float] | None:
        """Return from when on, and at what advance angle, a plot marks the feasible edge (s, deg); None for no mark."""
        return None

    def common_cause(self, _trace: RecordedTrace) -> str | None:
        """Return what a failed run shows that other failed checks may show too, in one clause; None for nothing."""
        return None

    def likely_causes(
        self,
        _failed: Sequence[Mapping[str, Any]],
        _met: Collection[str],
        _unjudged: Collection[str],
        _command: Callable[[str], str],
        /,
    ) -> tuple[str, ...]:
        """Return the likely causes of failed checks, each in one clause with what confirms it.

        That is another check that failed, or the command that runs one which was not judged.
        """
        return ()

    def causes_of(self, _check: str, /) -> tuple[str, ...]:
        """Return what usually breaks a check, the most specific first."""
        return ()

    @abstractmethod
    def summary(self, record: Any) -> dict[str, Any]:
        """Summarize a run with its trace: `summary`, `windows` and `clamped`."""

    @abstractmethod
    def observe(self, record: Any, /) -> dict[str, float]:
        """Return the `observations` of a run, without those that it has not."""

    @abstractmethod
    def comparison(self) -> Comparison:
        """Return how controllers are compared."""

    def behaviour(
        self, run: Callable[[Scenario], Record], drive: DriveDocument, step: Scenario | None
    ) -> dict[str, Any]:
        """From what runs a candidate, a drive and a scenario with steps, return what reports show besides checks."""
        raise NotImplementedError

    def is_fair(self, scenario: Scenario) -> bool:
        """Return True if a candidate may be judged on a scenario."""
        return self.unfair_because(scenario) is None

    def is_as_fair(self, simpler: Scenario, start: Scenario) -> bool:
        """Return True if a simplified scenario could have been drawn like the one that simplification started from."""
        return self.drawn_range(start).covers(simpler, start) and self.is_fair(simpler)
