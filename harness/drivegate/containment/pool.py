"""Doing many jobs with one candidate in several processes; the results do not depend on how many."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from multiprocessing.connection import wait
from typing import Any, Generic, Self

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault
from drivegate.candidates.kinds import KINDS
from drivegate.containment.candidate_isolation import isolating_layers
from drivegate.containment.judge import is_hang
from drivegate.containment.judge_process import JudgeProcess
from drivegate.containment.kept_process import prepare_judges
from drivegate.containment.machine_memory import require_memory
from drivegate.containment.messages import Faulted, Finished, Job, ResultT
from drivegate.containment.templates import Preparation
from drivegate.containment.watches import SlowRun, WorkerLimits
from drivegate_models.compilation.kernel_files import saved_digests
from drivegate_models.compilation.kernels import kernel_digests, remove_changed_kernels

# An outcome ends the wait at once. Only `is_ended` and a stopped judge have to be looked for.
_LOOK_EVERY = 0.25


class WorkEnded(Exception):
    """Work ends with what is known so far: by index, the outcomes that have not been yielded."""

    def __init__(self, outcomes: Mapping[int, Any] | None = None) -> None:
        super().__init__()
        self.outcomes = dict(outcomes or {})


class WorkerPool:
    """Several judges of one candidate, each with a process of the candidate's, watched by a single thread.

    `on_slow` is called with the first run that will take long, while it runs. Waiting for jobs raises `WorkEnded` as
    soon as `is_ended` returns True. `preparation` is what the judges have in common, for example loaded kernels.
    """

    def __init__(
        self,
        candidate: Candidate,
        *,
        workers: int,
        limits: WorkerLimits | None = None,
        on_slow: Callable[[SlowRun], None] | None = None,
        is_ended: Callable[[], bool] = lambda: False,
        preparation: Preparation | None = None,
    ) -> None:
        report = None if on_slow is None else _once(on_slow)
        # Listed and loaded before any of the candidate's code runs, which might change them.
        kernels = {} if KINDS[candidate.kind].is_included else kernel_digests()
        require_memory()
        if preparation is not None:
            prepare_judges(preparation, is_one_of_many=workers > 1)
        self._workers = [
            JudgeProcess(candidate, limits, kernels, report, is_one_of_many=workers > 1)
            for _ in range(max(workers, 1))
        ]
        self._kernels = kernels if isolating_layers(candidate) == () else None
        self._final: Fault | None = None
        self._is_ended = is_ended

    def map(self, jobs: Iterable[Job[ResultT]]) -> Iterator[ResultT | Fault]:
        """Do jobs side by side; one that hangs is tried once more while no other job runs.

        Leaving the iteration ends the jobs that are still under way. A fault while loading, and a hang in the second
        try, hold for every job that has not been started by then, also for those of later calls.
        """
        schedule = _Schedule(self._workers, jobs, self._is_ended, self._final)
        try:
            for index in range(schedule.total):
                yield schedule.outcome(index)
        finally:
            self._final = self._final or schedule.final
            for worker in schedule.running:
                worker.kill()

    def close(self) -> None:
        # All end at the same time: one after the other, their times would add up.
        for worker in self._workers:
            worker.hang_up()
        for worker in self._workers:
            worker.close()
        if self._kernels is not None:
            # Nothing has kept the candidate from writing there.
            known = (self._kernels, saved_digests(), *(worker.saved for worker in self._workers))
            remove_changed_kernels(known)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class _Schedule(Generic[ResultT]):
    """Which worker does which job, and the outcomes so far."""

    def __init__(
        self,
        workers: list[JudgeProcess],
        jobs: Iterable[Job[ResultT]],
        is_ended: Callable[[], bool],
        final: Fault | None = None,
    ) -> None:
        self._workers = workers
        self._is_ended = is_ended
        self._jobs = list(jobs)
        self.total = len(self._jobs)
        self._waiting = deque(range(self.total))
        self._suspects: deque[int] = deque()
        self._tried_alone: set[int] = set()
        self.running: dict[JudgeProcess, int] = {}
        self._outcomes: dict[int, ResultT | Fault] = {}
        self.final = final
        if final is not None:
            self._give_up(final)

    def outcome(self, index: int) -> ResultT | Fault:
        while index not in self._outcomes:
            if self._is_ended():
                self._collect()
                raise WorkEnded(self._outcomes)
            self._dispatch()
            wait([waitable for worker in self.running for waitable in worker.waitables], _LOOK_EVERY)
            self._collect()
        return self._outcomes.pop(index)

    def _dispatch(self) -> None:
        """Send jobs to idle workers; as long as there is a suspected hang, only that, and alone."""
        if self._suspects:
            if not self.running:
                index = self._suspects.popleft()
                self._tried_alone.add(index)
                self._start(self._workers[0], index)
            return
        if self._tried_alone.intersection(self.running.values()):
            return
        for worker in self._workers:
            if worker not in self.running and self._waiting:
                self._start(worker, self._waiting.popleft())

    def _start(self, worker: JudgeProcess, index: int) -> None:
        self.running[worker] = index
        worker.start(self._jobs[index])

    def _collect(self) -> None:
        for worker, index in list(self.running.items()):
            ending = worker.poll()
            if ending is not None:
                del self.running[worker]
                self._settle(index, ending)

    def _settle(self, index: int, ending: Finished | Faulted) -> None:
        if isinstance(ending, Finished):
            self._outcomes[index] = ending.result
            return
        fault, confirmed = ending.fault, index in self._tried_alone
        if is_hang(fault) and not confirmed:
            self._suspects.append(index)
            return
        self._outcomes[index] = fault
        # One that cannot be loaded will not be next time; and to wait for the same hang again and again shows nothing.
        if fault.phase == "loading" or is_hang(fault):
            self.final = fault
            self._give_up(fault)

    def _give_up(self, fault: Fault) -> None:
        for left in (self._waiting, self._suspects):
            while left:
                self._outcomes[left.popleft()] = fault


def _once(on_slow: Callable[[SlowRun], None]) -> Callable[[SlowRun], None]:
    """Make what reports the first slow run alone."""
    left = [on_slow]

    def report(run: SlowRun) -> None:
        if left:
            left.pop()(run)

    return report
