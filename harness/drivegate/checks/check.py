"""What a check is: a requirement declared once, and a function from a run to margins."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from drivegate.candidates.declaration import Declaration
from drivegate.checks.margin import Margin, Moment
from drivegate.checks.record import Record
from drivegate_cases.drive.drive_document import DriveDocument

Evaluate: TypeAlias = Callable[[Any], Margin | None]
"""From the record of a run of the check's contract to its margin; None where it does not apply to the run."""
StateMoment: TypeAlias = Callable[[Any], Moment | None]
"""From the record of a run to the moment that decides its margin; None where no single signal shows it."""
ReasonNotApplicable: TypeAlias = Callable[[Declaration, DriveDocument], str | None]
"""From a declaration and a drive to the reason why the check does not apply to that candidate; None where it does."""


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
    source: str
    """Facts of the publication that it rests on, such as ``P5``."""
    level: Literal["required", "advisory"]
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
    """The margin of a run."""
    moment: StateMoment = no_moment
    """The moment that decides the margin of a run, and what figures mark in it."""
    reason_not_applicable: ReasonNotApplicable = always_applicable
    """Why the check does not apply, on a drive, to a candidate that declares what it does."""
    volatile: bool = False
    """Whether the measured numbers depend on the machine, so that they belong beside a result's times."""
