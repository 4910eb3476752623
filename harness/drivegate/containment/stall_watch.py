"""Deciding from a worker's progress and the time it used whether it hangs."""

from dataclasses import dataclass

from drivegate.containment.shared_progress import Activity


@dataclass(frozen=True)
class WorkerLimits:
    """What a worker process may use.

    Attributes
    ----------
    step_processor_seconds : float
        Processor time of one step, the first one apart (s).
    start_processor_seconds : float
        Processor time without progress of all else: imports, compilation, the first step (s).
    idle_seconds : float
        Time without progress in which hardly any processor time is used (s).
    job_seconds : float
        Time of a whole job (s).
    memory_bytes : int
        Memory that may be allocated beyond what the process has at its start.
    """

    step_processor_seconds: float = 5.0
    start_processor_seconds: float = 120.0
    idle_seconds: float = 60.0
    job_seconds: float = 1800.0
    memory_bytes: int = 4 * 2**30


class StallWatch:
    """Follows one activity of a worker from its start."""

    def __init__(self, limits: WorkerLimits, processor: float, now: float) -> None:
        self._limits = limits
        self._began = now
        self._state: tuple[int, int] | None = None
        self._processor = processor
        self._moved = now

    def stalled(self, state: tuple[int, int], activity: Activity, processor: float, now: float) -> str | None:
        """Look at the worker once."""
        limits = self._limits
        if now - self._began > limits.job_seconds:
            return f"the job did not end within {limits.job_seconds:g} s"
        if state != self._state:
            self._state, self._processor, self._moved = state, processor, now
            return None
        stepping = activity is Activity.RUNNING and state[1] > 1
        allowed = limits.step_processor_seconds if stepping else limits.start_processor_seconds
        used, waited = processor - self._processor, now - self._moved
        if used > allowed:
            return f"no progress within {allowed:g} s of processor time"
        if waited > limits.idle_seconds and used < limits.idle_seconds / 20:
            return f"no progress within {limits.idle_seconds:g} s of waiting"
        return None
