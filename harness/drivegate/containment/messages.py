"""What a worker process and its parent tell each other."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, Generic, TypeAlias, TypeVar

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import Fault
from drivegate.containment.shared_progress import SharedProgress

ResultT = TypeVar("ResultT")

LOST_CONNECTION: Final = 119
"""Exit status of a worker process whose connection to its parent the candidate has closed."""

LoadController: TypeAlias = Callable[[Candidate], Controller]
"""Makes a new instance of a candidate; raises `InputError` or `CandidateFault`."""


@dataclass(frozen=True)
class LoadedCandidate:
    """A candidate whose code has been imported in this worker process.

    Attributes
    ----------
    candidate : Candidate
        What it is.
    load : callable
        Makes a new instance.
    progress : SharedProgress
        Where the parent reads what the process is doing.
    """

    candidate: Candidate
    load: LoadController
    progress: SharedProgress

    def controller(self) -> Controller:
        """Make a new instance, so that nothing of an earlier job is left in it."""
        with self.progress.loading():
            return self.load(self.candidate)


@dataclass(frozen=True)
class Job(Generic[ResultT]):
    """Something to do with a candidate in a worker process.

    Attributes
    ----------
    target : callable
        A module's function, called with the loaded candidate and the payload.
    payload : object
        Anything that can be pickled.
    afresh : bool
        Whether it needs a process that has done nothing before.
    """

    target: Callable[[LoadedCandidate, Any], ResultT]
    payload: Any
    afresh: bool = False


@dataclass(frozen=True)
class Setup:
    """First message to a worker process.

    Attributes
    ----------
    candidate : Candidate
        The candidate to load.
    load : callable
        How to load it.
    memory_limit : int
        Bytes that the process may allocate beyond what it has at its start.
    """

    candidate: Candidate
    load: LoadController
    memory_limit: int


@dataclass(frozen=True)
class Ready:
    """The candidate is loaded."""


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
class Broken:
    """The harness's own code failed in a job."""

    traceback: str


Reply: TypeAlias = Ready | Finished | Faulted | Refused | Broken
