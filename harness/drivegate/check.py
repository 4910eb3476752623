"""What a check is: a requirement declared once, and a function from a run to margins."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

from drivegate.margin import Margin
from drivegate.run_record import RunRecord

Evaluate: TypeAlias = Callable[[RunRecord], Margin | None]
"""From a finished run to the check's margin; None where the check does not apply to the run."""


@dataclass(frozen=True)
class Check:
    """A requirement and how it is judged.

    Attributes
    ----------
    id : str
        Identifier, such as ``ADV-1``.
    requirement : str
        The requirement in one sentence.
    source : str
        Facts of the publication that it rests on, such as ``P5``.
    subject : {"candidate", "plant"}
        Whose requirement it is; a failure of the plant is a fault of the harness.
    level : {"required", "advisory"}
        Whether a failure fails the candidate.
    limit : str
        The limit in people's units.
    scenarios : str
        The scenarios that it applies to, in words.
    evaluate : callable
        The margin of a run.
    """

    id: str
    requirement: str
    source: str
    subject: Literal["candidate", "plant"]
    level: Literal["required", "advisory"]
    limit: str
    scenarios: str
    evaluate: Evaluate
