"""Telling from the first seconds of a run how long it will take, where that is longer than anyone waits."""

from dataclasses import dataclass
from typing import Final

KNOWN_AFTER: Final = 4.0
"""Time of stepping after which the pace is known (s)."""
LONG: Final = 60.0
"""Time from which on a run is long (s)."""


@dataclass(frozen=True)
class SlowRun:
    """A run that will take long."""

    steps: int
    """Its steps."""
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
        """Look at the number of parts done; gives the mean time of one (s), once that is known."""
        # A count that falls is that of other work.
        if self._first is None or done < self._first[0]:
            self._first = done, now
        first, since = self._first
        if done == first or now - since < known_after:
            return None
        return (now - since) / (done - first)


class PaceWatch:
    """Follows one run from its start."""

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
