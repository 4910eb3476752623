"""What a judge asks of a candidate's process, one order at a time.

Orders go from the harness to the candidate, never the other way: what comes back is a `reply.Reply` and commands.
None of them holds a scenario, a seed, or a limit that is judged.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from struct import Struct
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.candidate import Candidate
from drivegate_models.contract.current.records import COMMAND
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.contract.duty.signals import DutyNameplate
from drivegate_models.contract.layout import LAYOUTS

PACKET: Final = Struct("=8sqq")
"""A word that says whose it is, the number of bytes of the order, which lies in the shared memory, and that of the
memory itself. A memory that is new is included as a file descriptor."""
WORD: Final = b"drivegat"
"""First bytes of every packet, either way."""


@dataclass(frozen=True)
class Setup:
    """Take a candidate in hand, without running any of its code."""

    candidate: Candidate
    """What it is."""
    memory_limit: int
    """Bytes that the process may allocate beyond what it has at its start."""


@dataclass(frozen=True)
class MakeInstance:
    """Make a new instance of the candidate, and let go of the one before."""


@dataclass(frozen=True)
class Reset:
    """Reset the instance."""

    nameplate: Nameplate | DutyNameplate
    """What it gets."""


@dataclass(frozen=True)
class CloseLoop:
    """Close the loop between the instance and a plant, and keep the commands."""

    prepare: Callable[..., Any]
    """A module's function that makes the run ready, `drivegate_models.loop.closed_loop.prepared_loop` of a
    drive or `drivegate_models.pm_ac.closed_loop.prepared_duty_loop`."""
    plant: tuple[Any, ...]
    """Its arguments: constants of the drive, load and schedule."""
    options: Mapping[str, Any]
    """Its further arguments."""
    restart_steps: Sequence[int] = ()
    """Steps before which the instance is reset, in the process that has it."""
    commands: np.dtype[Any] = COMMAND
    """Layout of the commands that are kept."""


@dataclass(frozen=True)
class GiveSenses:
    """Step the instance through given Senses, which follow on those given since the reset, and keep the commands."""

    senses: NDArray[Any]
    """One for each step, as records of the contract, shape (n,)."""
    currents: NDArray[np.float64]
    """Their phase currents (A), shape (n, m)."""

    @property
    def commands(self) -> np.dtype[Any]:
        """Layout of the commands that are kept."""
        return LAYOUTS[self.senses.dtype].command


RunOrder: TypeAlias = CloseLoop | GiveSenses
"""What is answered with commands."""

Order: TypeAlias = Setup | MakeInstance | Reset | RunOrder
