"""What everything outside of the contracts' folders knows of a contract."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any, TypeAlias

if TYPE_CHECKING:
    import numpy as np
    from hypothesis.strategies import SearchStrategy
    from numpy.typing import NDArray

    from drivegate.candidates.declaration import Declaration
    from drivegate.checks.check import Check, Record
    from drivegate.checks.margin import Margin
    from drivegate.containment.messages import AnyController
    from drivegate.contracts.comparison import Comparison
    from drivegate.contracts.drawings import Panel
    from drivegate.contracts.given_steps import GivenSteps
    from drivegate.scenarios.drawn_range import DrawnRange
    from drivegate.scenarios.simplification import Simplification
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.scenario import Scenario
    from drivegate_models.contract.layout import Layout

Columns: TypeAlias = "dict[str, NDArray[np.float64]]"
"""Arrays of equal length, shape (n,), by the name of the column, which has the unit."""


@dataclass(frozen=True)
class RecordedTrace:
    """The signals of a run, each a mean over a stretch of it."""

    scenario: Scenario
    """The scenario of the run."""
    columns: Columns
    """Its signals."""
    judged_s: tuple[float, float]
    """Start and end of the stretch that the check was judged on (s)."""


@dataclass(frozen=True)
class Witness:
    """A built-in controller that passes the packaged drives of some kinds."""

    candidate: str
    """The string that names it."""
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

    def is_heard_on(self, check: str) -> bool:
        """Return True if it can show something on a check that earlier witnesses cannot."""
        return check not in self.silent_on and (not self.only_on or check in self.only_on)


@dataclass(frozen=True)
class Later:
    """A function or a value that is imported when it is first used."""

    module: str
    """Full name of its module."""
    name: str
    """Its name there."""

    def value(self) -> Any:
        """Import it."""
        return getattr(import_module(self.module), self.name)

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        """Call the function."""
        return self.value()(*arguments, **options)


@dataclass(frozen=True, kw_only=True)
class Contract:
    """The boundary between a controller and a drive, and everything that is judged by it.

    Whatever is compiled, or takes long to import, is imported by `Later`: a bundle costs nothing until it is called.
    """

    name: str
    """Its name in manifests, drives and results."""
    candidates: str
    """What its candidates are called."""
    default_drive: str
    """Name of the packaged drive that candidates are judged on by default."""
    usual_candidate: str
    """Name of a built-in controller that runs on every drive of this contract."""
    witnesses: tuple[Witness, ...]
    """Known good controllers, in the order in which they are run where a candidate fails a check."""
    checks: Callable[[], tuple[Check, ...]]
    """Return the checks of a run, in the order in which they are reported."""
    families: tuple[str, ...]
    """Names of the families of drawn scenarios."""
    numbers: Callable[[DriveDocument, Declaration], Mapping[str, str]]
    """Return a drive's numbers, and those that a candidate declares, by the names that the texts of checks use."""
    fixed_scenarios: Callable[[DriveDocument, Declaration], tuple[Scenario, ...]]
    """Return the scenarios that every check of a candidate runs first."""
    drawn_scenarios: Callable[[DriveDocument, Declaration, int | None], SearchStrategy[Scenario]]
    """Return the scenarios to draw from: those of one group of families, or of all for None."""
    joint_scenarios: Callable[[DriveDocument, Declaration, int, int, int], tuple[Scenario, ...]]
    """From a seed, the number of a part and of all parts, return fair scenarios of joint changes."""
    joint_rows: Callable[[], int]
    """Return the number of joint changes in one pass; 0 where this contract has none."""
    unfair_because: Callable[[Scenario], str | None]
    """Return the reason why no controller can do what a scenario requires; None where one can."""
    simplifications: Callable[[], tuple[Simplification, ...]]
    """Return the ways in which a scenario can be simplified, in the order in which they are tried."""
    drawn_range: Callable[[Scenario], DrawnRange]
    """Return the range that scenarios of a family are drawn from, which no simplification leaves."""
    unseen: Callable[[Declaration, Scenario], Record]
    """Return the record of a run that was not made: reading what only the run shows raises `checks.unseen.NotRun`."""
    record: Callable[..., Record]
    """Run a controller for the checks: plant's loop, declaration, scenario, controller, `trace_every`, `kept`."""
    judged_window: Callable[[Check, Record, Margin | None], tuple[float, float]]
    """Return start and end of the stretch of a run that decides a margin (s)."""
    step_seconds: Callable[[AnyController, Record], float]
    """Measure the time of one step on what was sensed in a run whose trace has every step (s)."""
    layout: Callable[[], Layout]
    """Return the records that pass between controller and drive."""
    sensed: Mapping[str, str]
    """Fields of a sense to print, each with its unit."""
    outputs: Mapping[str, tuple[str, str]]
    """Fields of a command that a controller writes, each with its name and unit."""
    plotted: Mapping[str, tuple[str, float]]
    """Fields of a command that figures show, each with the unit there and a factor for it."""
    nameplate: Callable[[Scenario], Any]
    """Return what a controller is reset with before a scenario."""
    run: Callable[..., Any]
    """Run a controller once: plant's loop, scenario, controller, and by name `wrap`, to put something around it."""
    given_steps: Callable[[AnyController, Any], GivenSteps]
    """From a controller and its nameplate, return steps through given Senses."""
    plant_state: Callable[[Callable[..., Any], Scenario, NDArray[Any], int], dict[str, Any]]
    """From a plant's loop, a scenario, a run's commands and a step, return the plant's own state at its start."""
    signals: Callable[[Any], dict[str, NDArray[Any]]]
    """Return the columns of a run's trace in people's units, by name."""
    recorded_signals: Callable[[Any], dict[str, NDArray[Any]]]
    """Return the columns of a run's trace that a result keeps."""
    recorded_names: tuple[str, ...]
    """Names of the recorded columns without which a run cannot be described."""
    account: Callable[[RecordedTrace], tuple[str, ...]]
    """Describe a recorded run in sentences."""
    marked_angle: Callable[[RecordedTrace], tuple[float, float] | None]
    """Return from when on, and at what advance angle, a plot marks the feasible edge (s, deg); None for no mark."""
    common_cause: Callable[[RecordedTrace], str | None]
    """Return what a failed run shows that other failed checks may show too, in one clause; None for nothing."""
    summary: Callable[[Record], dict[str, Any]]
    """Summarize a run with its trace: `summary`, `windows` and `clamped`."""
    summary_rows: tuple[tuple[str, str, str], ...]
    """Keys of `summary` to print, each with its name and unit."""
    window_columns: tuple[tuple[str, str], ...]
    """Keys of `windows` to print, each with its heading."""
    observations: tuple[str, ...]
    """Names of the figures that a campaign keeps of each run, with their units."""
    observe: Callable[[Record], dict[str, float]]
    """Return these figures of a run, without those that it has not."""
    rehearsed: str
    """Name of a built-in controller that fails checks: running it compiles what only failures need."""
    comparison: Callable[[], Comparison]
    """Return how controllers are compared."""
    likely_causes: Callable[[Sequence[Mapping[str, Any]]], tuple[str, ...]] = lambda _: ()
    """Return the likely causes of failed checks, each with what would confirm it, in one clause."""
    panels: tuple[Panel, ...] = ()
    """How figures show the recorded columns; without any, each has a panel."""
    behaviour: (
        Callable[[Callable[[Scenario], Record], DriveDocument, Scenario | None], dict[str, Any]] | None
    ) = None
    """From what runs a candidate, a drive and a scenario with steps, return what reports show besides the checks."""

    def is_fair(self, scenario: Scenario) -> bool:
        """Return True if a candidate may be judged on a scenario."""
        return self.unfair_because(scenario) is None

    def is_as_fair(self, simpler: Scenario, start: Scenario) -> bool:
        """Return True if a simplified scenario could have been drawn like the one that simplification started from."""
        return self.drawn_range(start).covers(simpler, start) and self.is_fair(simpler)
