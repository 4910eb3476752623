"""What is watched of a candidate's process: its memory, whether it hangs, and how long a run will take."""

import os
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from drivegate.containment.shared_memory import Activity

WATCHED_EVERY: Final = 0.25
"""Time between two looks at the memory of a candidate's processes (s)."""

_PAGE: Final = os.sysconf("SC_PAGE_SIZE")
KNOWN_AFTER: Final = 4.0
"""Time of stepping after which the pace is known (s)."""
LONG: Final = 60.0
"""Time from which on a run is long (s)."""


class MemoryWatch:
    """Follows the memory of a candidate's processes beyond what they had at the start."""

    def __init__(self, allowed: int, at_start: int) -> None:
        self._allowed = allowed
        self._at_start = at_start
        self._next = 0.0

    def is_due(self, now: float) -> bool:
        if now < self._next:
            return False
        self._next = now + WATCHED_EVERY
        return True

    def excess(self, used: int) -> str | None:
        """Describe a use of more memory than is allowed; None if it is not."""
        if used - self._at_start <= self._allowed:
            return None
        return f"the candidate's processes used more than {self._allowed / 2**30:g} GiB of memory"


def memory_of_descendants(ancestor: int) -> int:
    """Measure the memory of all processes that came from one, each shared page in parts (bytes).

    Adding up what each process has in memory takes no time, but counts shared pages several times. Only where that is
    a lot are the parts worth their time.
    """
    processes = _descendants(ancestor)
    resident = sum(map(_resident, processes))
    if resident < _LITTLE:
        return resident
    return sum(map(_proportional, processes))


# A quarter of the usual limit. The sum is never too small, so below this there is no excess to be found.
_LITTLE: Final = 2**30


def _descendants(ancestor: int) -> list[int]:
    found = [ancestor]
    for process in found:
        with suppress(OSError, ValueError):
            for children in Path(f"/proc/{process}/task").glob("*/children"):
                found.extend(map(int, children.read_text(encoding="ascii").split()))
    return found[1:]


def _resident(process: int) -> int:
    with suppress(OSError, ValueError, IndexError):
        return int(Path(f"/proc/{process}/statm").read_text(encoding="ascii").split()[1]) * _PAGE
    return 0


def _proportional(process: int) -> int:
    """Measure the memory of a process, each shared page divided by the number of its users."""
    with suppress(OSError, ValueError, IndexError):
        for line in Path(f"/proc/{process}/smaps_rollup").read_text(encoding="ascii").splitlines():
            if line.startswith("Pss:"):
                return int(line.split()[1]) * 1024
    return _resident(process)


@dataclass(frozen=True)
class WorkerLimits:
    """What a candidate's process may use."""

    step_processor_seconds: float = 5.0
    """Processor time of one step, the first one apart, and of the deletion of an instance (s)."""
    start_processor_seconds: float = 120.0
    """Processor time without progress of all else: imports, compilation, the first step (s)."""
    idle_seconds: float = 60.0
    """Time without progress in which hardly any processor time is used (s)."""
    order_seconds: float = 120.0
    """Time of a whole order, such as one run, in addition to what is allowed for each of its steps (s)."""
    order_step_seconds: float = 1e-3
    """Time that a run is allowed for each step, in the mean (s)."""
    memory_bytes: int = 4 * 2**30
    """Memory that may be allocated beyond what the process has at its start."""

    def allowed_seconds(self, steps: int) -> float:
        return self.order_seconds + steps * self.order_step_seconds


class StallWatch:
    def __init__(self, limits: WorkerLimits, processor: float, now: float, steps: int = 0) -> None:
        self._limits = limits
        self._allowed = limits.allowed_seconds(steps)
        self._began = now
        self._state: tuple[int, int] | None = None
        self._processor = processor
        self._moved = now

    def stalled(self, state: tuple[int, int], activity: Activity, processor: float, now: float) -> str | None:
        """Look at the process once."""
        limits = self._limits
        if now - self._began > self._allowed:
            return f"the run did not end within {self._allowed:g} s"
        if state != self._state:
            self._state, self._processor, self._moved = state, processor, now
            return None
        # The first step may compile, and so has the time of a start.
        stepping = activity is Activity.RUNNING and state[1] > 1
        brief = stepping or activity is Activity.LETTING_GO
        allowed = limits.step_processor_seconds if brief else limits.start_processor_seconds
        used, waited = processor - self._processor, now - self._moved
        if used > allowed:
            return f"no progress within {allowed:g} s of processor time"
        # Less than a twentieth of a processor is waiting. More is work, which the limit on processor time bounds.
        if waited > limits.idle_seconds and used < limits.idle_seconds / 20:
            return f"no progress within {limits.idle_seconds:g} s of waiting"
        return None


@dataclass(frozen=True)
class SlowRun:
    steps: int
    step_seconds: float
    """Time of one step so far, in the mean (s)."""
    allowed_seconds: float
    """Time after which the run is ended as a hang (s)."""

    @property
    def seconds(self) -> float:
        """Time of the whole run at this pace (s)."""
        return self.steps * self.step_seconds


class Pace:
    """How long one of many parts takes, since the first look at how many are done."""

    def __init__(self) -> None:
        self._first: tuple[int, float] | None = None

    def seconds_each(self, done: int, now: float, known_after: float) -> float | None:
        """Look at the number of parts done; return the mean time of one (s), once that is known."""
        # A count that falls is that of other work.
        if self._first is None or done < self._first[0]:
            self._first = done, now
        first, since = self._first
        if done == first or now - since < known_after:
            return None
        return (now - since) / (done - first)


class PaceWatch:
    def __init__(self, steps: int, allowed_seconds: float) -> None:
        self._steps = steps
        self._allowed = allowed_seconds
        self._pace = Pace()
        self._reported = False

    def slow(self, begun: int, now: float) -> SlowRun | None:
        """Look at the number of steps begun; return what is to be reported, once."""
        # The first step may compile, and says nothing about the others.
        if self._reported or begun < 2:
            return None
        step_seconds = self._pace.seconds_each(begun, now, KNOWN_AFTER)
        if step_seconds is None:
            return None
        self._reported = True
        run = SlowRun(self._steps, step_seconds, self._allowed)
        return run if run.seconds > min(LONG, self._allowed) else None
