"""Deciding from the progress of a candidate's process and the time it used whether it hangs."""

from dataclasses import dataclass

from drivegate.containment.shared_progress import Activity


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
    """Time of a whole order, such as one run, beside what is allowed for each of its steps (s)."""
    order_step_seconds: float = 1e-3
    """Time that a run is allowed for each step, in the mean (s)."""
    memory_bytes: int = 4 * 2**30
    """Memory that may be allocated beyond what the process has at its start."""

    def allowed_seconds(self, steps: int) -> float:
        """Return the time of an order of so many steps (s)."""
        return self.order_seconds + steps * self.order_step_seconds


class StallWatch:
    """Follows one order from its start."""

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
        stepping = activity is Activity.RUNNING and state[1] > 1
        brief = stepping or activity is Activity.LETTING_GO
        allowed = limits.step_processor_seconds if brief else limits.start_processor_seconds
        used, waited = processor - self._processor, now - self._moved
        if used > allowed:
            return f"no progress within {allowed:g} s of processor time"
        if waited > limits.idle_seconds and used < limits.idle_seconds / 20:
            return f"no progress within {limits.idle_seconds:g} s of waiting"
        return None
