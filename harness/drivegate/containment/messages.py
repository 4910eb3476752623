"""Jobs with a candidate, and their outcomes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, TypeAlias, TypeVar

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault

if TYPE_CHECKING:
    from drivegate.candidates.controller import Controller
    from drivegate.containment.contained_controller import ContainedController

ResultT = TypeVar("ResultT")

AnyController: TypeAlias = "Controller | ContainedController"
"""An instance of drivegate's own code in this process, or of a candidate's in a process of its own."""


@dataclass(frozen=True)
class JudgedCandidate:
    candidate: Candidate
    controller: Callable[[], AnyController]
    """Makes a new instance, so that nothing of an earlier job is left in it."""


@dataclass(frozen=True)
class Job(Generic[ResultT]):
    """Something to do with a candidate, in a process that never runs its code."""

    target: Callable[[JudgedCandidate, Any], ResultT]
    """A module's function, called with the candidate and the payload."""
    payload: Any
    """Anything that can be pickled."""
    afresh: bool = False
    """Whether the candidate needs a process that has done nothing before."""
    is_plain: bool = False
    """Whether nothing may look into the candidate while it runs."""


@dataclass(frozen=True)
class Finished:
    """A job has ended with a result."""

    result: Any


@dataclass(frozen=True)
class Faulted:
    """The candidate failed, while loading or in a job."""

    fault: Fault


@dataclass(frozen=True)
class Refused:
    """Loading or a job ended with a sentence for the user."""

    sentence: str


@dataclass(frozen=True)
class WithoutMemory:
    """The machine has too little memory for the job."""

    sentence: str


@dataclass(frozen=True)
class Broken:
    """The harness's own code failed in a job."""

    traceback: str


@dataclass(frozen=True)
class Compiled:
    """A judge has compiled kernels in a job, and saved them."""

    kernels: dict[str, bytes]
    """Digest of each file, by its path in the folder of compiled kernels."""


Outcome: TypeAlias = Finished | Faulted | Refused | WithoutMemory | Broken
"""How a job ended, as a judge's process reports it."""
