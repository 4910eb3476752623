"""What a check is: a requirement declared once, what it sees of a finished run, and the margins that it returns."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Protocol, TypeAlias

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.step_costs import NO_COSTS, StepCosts
from drivegate.checks.margin import Margin, Moment
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.requirements.row import Row
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.steady.plant import AnyDrive

if TYPE_CHECKING:
    from numpy.typing import NDArray

Evaluate: TypeAlias = Callable[[Any], Margin | None]
"""From the record of a run of the check's contract to its margin; None where it does not apply to the run."""
StateMoment: TypeAlias = Callable[[Any], Moment | None]
"""From the record of a run to the moment that decides its margin; None where no single signal shows it."""
Nearness: TypeAlias = Callable[[Scenario], tuple[float, str]]
"""From a scenario that a check did not judge to how far it is from one that it judges, from 0, and why, in a clause."""
ReasonNotApplicable: TypeAlias = Callable[[Declaration, DriveDocument], str | None]
"""From a declaration and a drive to the reason why the check does not apply to that candidate; None where it does."""


class Run(Protocol):
    """The observation of a run, whatever its contract."""

    @property
    def digest(self) -> int:
        """Digest of all commands, bit for bit."""


@dataclass(frozen=True)
class Record:
    """A finished run with what belongs to it."""

    scenario: Scenario
    run: Run
    """The observation; each contract has its own type."""
    declaration: Declaration
    repeated_digests: tuple[int, ...] = ()
    """Digests of further runs of the same scenario; empty where it ran once."""
    costs: StepCosts = NO_COSTS
    """Greatest costs of a step on an emulated target."""
    allowed_costs: StepCosts = NO_COSTS
    """What the candidate's manifest allows of them."""
    parting: str = ""
    """Where one of these runs first differs from this one, in words; empty where none does."""
    steps: NDArray[Any] | None = None
    """What the controller sensed and answered, as rows of `loop.step_recording.row_layout`: of every control period, or
    of every n-th of a long run; None where that was not kept."""
    remarks: tuple[str, ...] = ()
    """What the candidate's process has warned of so far."""

    @cached_property
    def drive(self) -> AnyDrive:
        """The plant that the run was made on."""
        return self.scenario.drive.plant(self.scenario.scales)

    @cached_property
    def derived(self) -> dict[str, Any]:
        """What one check has derived from the run for those after it, by name."""
        return {}


class NotRun(Exception):
    """Raised where something is read that only the run shows."""


class Unseen:
    """Stand-in for what a run shows: reading anything but what is already known raises `NotRun`."""

    def __init__(self, **known: Any) -> None:
        self.__dict__.update(known)

    def __getattr__(self, name: str) -> Any:
        raise NotRun(name)


def always_applicable(_declaration: Declaration, _drive: DriveDocument) -> str | None:
    """Let a check apply to every candidate."""
    return None


def no_moment(_record: Record) -> None:
    """State no moment: a figure shows the stretch that is judged."""
    return


def judged_elsewhere(_record: Record) -> Margin | None:
    """Leave a check out of closed-loop runs: its margins come from jobs of their own."""
    return None


@dataclass(frozen=True, kw_only=True)
class Check:
    """A requirement and how it is judged.

    Its texts name a drive's numbers, such as ``{k1}``; `drivegate.contracts.catalogue.on_drive` fills them in.
    """

    id: str
    """Identifier, such as ``ADV-1``."""
    requirement: str
    """The requirement in one sentence."""
    source: str = "the contract"
    """Facts of the publication that it is derived from, such as ``P5``, where it is not the contract's own."""
    level: Literal["required", "advisory"] = "required"
    """Whether a failure fails the candidate."""
    limit: str
    """The limit in people's units."""
    scenarios: str
    """The scenarios that it applies to, in words."""
    formula: str
    """How the margin follows from what is measured."""
    why: str
    """Why the requirement is worth checking."""
    subject: Literal["candidate", "plant"] = "candidate"
    """Whose requirement it is; a failure of the plant is a fault of the harness."""
    every_run: bool = False
    """Whether it judges every run in the closed loop."""
    families: tuple[str, ...] = ()
    """Families of drawn scenarios that exercise it, where it does not judge every run."""
    evaluate: Evaluate = judged_elsewhere
    moment: StateMoment = no_moment
    """The moment that decides the margin of a run, and what figures mark in it."""
    reason_not_applicable: ReasonNotApplicable = always_applicable
    """Why the check does not apply, on a drive, to a candidate that declares what it does."""
    volatile: bool = False
    """Whether the measured numbers depend on the machine, so that they belong beside a result's times."""
    nearness: Nearness | None = None
    """How near a scenario comes that it did not judge, of a check that must have judged some run; None of others."""
    row: Row | None = None
    """The user's row that it was made from; None of a check of drivegate's own."""


@dataclass(frozen=True)
class JudgedRun:
    """A run's scenario and margins; what a worker returns."""

    scenario: dict[str, Any]
    """The scenario as plain data."""
    margins: tuple[Margin, ...]
    """Of every check that applies."""
    digest: int = 0
    """Digest of the commands; 0 where they are not compared."""
    costs: StepCosts = NO_COSTS
    """Greatest costs of a step on an emulated target."""
    remarks: tuple[str, ...] = ()
    """What the candidate's process has warned of so far."""


@dataclass(frozen=True)
class InfeasibleScenario:
    """A drawn scenario on which no candidate may be judged; it was not run."""

    scenario: str
    """Its name."""
    reason: str
    """Why no controller could do what it requires."""


@dataclass(frozen=True)
class ShardOutcome:
    """The result of a job."""

    runs: tuple[JudgedRun, ...]
    """In the order in which they were made."""
    infeasible: tuple[InfeasibleScenario, ...] = ()
    """Drawn scenarios that no controller could do, which were not run."""


def deciding_stretch(
    check: Check,
    record: Record,
    margin: Margin | None,
    stretches: Iterable[tuple[float, float]],
    part: Callable[[Sequence[int]], Record],
) -> tuple[float, float]:
    """Find the stretch (s) of a run that alone gives the same margin; the whole run where none decides.

    `part` returns the record of the run with some of the stretches, by their places.
    """
    if margin is not None and check.evaluate(part(())) is None:
        for place, stretch in enumerate(stretches):
            alone = check.evaluate(part((place,)))
            if alone is not None and alone.value == margin.value:
                return stretch
    return 0.0, record.scenario.duration_s


def judged(record: Record, checks: Iterable[Check]) -> JudgedRun:
    margins = (check.evaluate(record) for check in checks)
    return JudgedRun(
        record.scenario.to_mapping(),
        tuple(margin for margin in margins if margin is not None),
        record.run.digest,
        record.costs,
        record.remarks,
    )
