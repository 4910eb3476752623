"""Lines that say why a command takes long: kernels that are compiled first, and slow candidates."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable
from typing import Final

from drivegate.containment.watches import Pace, SlowRun
from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.gate.warm_up import compile_kernels, uncompiled_kinds
from drivegate.output.progress import duration_in_words
from drivegate.output.streams import write_to
from drivegate_cases.drive.drive_document import DriveDocument

LONG_CHECK: Final = 300.0
"""Time that is left of a check from which on it is long (s)."""
CHECK_KNOWN_AFTER: Final = 5.0
"""Time between two looks at a check from which its pace is known (s)."""


def with_compiled_kernels(drives: Iterable[DriveDocument]) -> None:
    """Compile the kernels of some drives' kinds unless they are kept from before.

    A process that compiles a kernel itself may round otherwise, in the last digit, than one that loads it.
    """
    kinds = uncompiled_kinds(drives)
    if kinds:
        write_to(sys.stderr, f"{compiling_in_words(kinds)}\n")
        compile_kernels(kinds)


def compiling_in_words(kinds: Iterable[str]) -> str:
    """State what is compiled and how long it takes; kinds are compiled at the same time."""
    times = " and ".join(f"about {DRIVE_KINDS[kind].compiling_s} s for {kind} drives" for kind in kinds)
    return f"compiling the kernels, which is done once and takes {times} on 2 processors"


class CheckPace:
    """Follows the runs of a check, which may be quick or of some checks alone already."""

    def __init__(
        self, clock: Callable[[], float] = time.monotonic, *, is_quick: bool = False, is_part: bool = False
    ) -> None:
        self._clock = clock
        ways = [way for way, is_used in (("--effort quick", is_quick), ("--only", is_part)) if not is_used]
        self._shorter = (
            f"{' or '.join(ways)} makes it shorter, and --max-time ends it" if ways else "--max-time ends it"
        )
        self._pace = Pace()
        self._reported = False
        self._shared_runs: float | None = None

    def begin(self, planned: int, workers: int) -> None:
        """Note how many runs are shared by how many processes."""
        self._shared_runs = planned / workers

    def slow_in_words(self, done: int, planned: int) -> str:
        """State once how long the rest takes, where it is long; otherwise nothing."""
        # Compiling and starting say nothing about how fast runs are made, and are over at the first look.
        run_seconds = self._pace.seconds_each(done, self._clock(), CHECK_KNOWN_AFTER)
        if self._reported or run_seconds is None:
            return ""
        left = (planned - done) * run_seconds
        if left < LONG_CHECK:
            return ""
        self._reported = True
        return f"at this pace this check takes about {duration_in_words(left)} more; {self._shorter}"

    def slow_run_in_words(self, run: SlowRun) -> str:
        """Project the whole check from its first slow run."""
        words = slow_in_words(run)
        if self._shared_runs is None or self._reported or run.seconds > run.allowed_seconds:
            return words
        self._reported = True
        whole = duration_in_words(self._shared_runs * run.seconds)
        return f"{words}, and this check about {whole}; {self._shorter}"


def slow_in_words(run: SlowRun) -> str:
    """State how long a run takes at its pace, and what will become of it."""
    words = (
        f"at this pace this run takes about {duration_in_words(run.seconds)}: {run.steps} steps of "
        f"{run.step_seconds:.2g} s each"
    )
    if run.seconds > run.allowed_seconds:
        words += f"; it will be ended as a hang after {run.allowed_seconds:.0f} s"
    return words


def report_slow(run: SlowRun) -> None:
    write_to(sys.stderr, f"{slow_in_words(run)}\n")
