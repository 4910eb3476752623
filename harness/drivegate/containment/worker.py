"""Doing jobs with one candidate in a process of its own, so that none of its faults reaches the harness.

This contains faults, not malice: a candidate runs with the rights of the user.
"""

import time
from dataclasses import replace
from multiprocessing.connection import wait
from types import TracebackType
from typing import Any, Self

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.ending import ending_in_words
from drivegate.candidates.fault import Fault, FaultKind, bounded_text
from drivegate.candidates.kinds import KINDS
from drivegate.containment.handle import UnreadableReply, WorkerHandle
from drivegate.containment.messages import (
    LOST_CONNECTION,
    Broken,
    Faulted,
    Finished,
    Job,
    LoadController,
    Ready,
    Refused,
    Reply,
    ResultT,
    Setup,
)
from drivegate.containment.shared_progress import Activity
from drivegate.containment.stall_watch import StallWatch, WorkerLimits
from drivegate_cases.documents.wording import counted
from drivegate_models.errors import HarnessFault, InputError

LOOK_EVERY = 0.05
"""Time between two looks at a worker that tells nothing by itself (s)."""

_HARNESS_OWN = (Activity.STARTING, Activity.WAITING, Activity.PREPARING)
_NOT_ITS_OWN = "a candidate must leave alone what it has not opened"
_CONNECTION_CLOSED = f"the process closed its connection to the harness; {_NOT_ITS_OWN}"
_CONNECTION_GARBLED = f"the process wrote into its connection to the harness; {_NOT_ITS_OWN}"


class CandidateWorker:
    """Does jobs with one candidate, one after another, in a process that is replaced after a crash or a hang.

    On Linux the process dies with the thread that started it.
    """

    def __init__(
        self, candidate: Candidate, load: LoadController, *, limits: WorkerLimits | None = None
    ) -> None:
        self._limits = limits or WorkerLimits()
        self._setup = Setup(candidate, load, self._limits.memory_bytes)
        self._handle: WorkerHandle | None = None
        self._loaded = False
        self._job: Job[Any] | None = None

    def run(self, job: Job[ResultT]) -> ResultT | Fault:
        """Do one job and wait for its end; one that hangs is tried once more."""
        ending = self._awaited(job)
        if is_hang(ending):
            ending = self._awaited(job)
        outcome: ResultT | Fault = unwrapped(ending)
        return outcome

    def _awaited(self, job: Job[Any]) -> Finished | Faulted:
        self.start(job)
        while (ending := self.poll()) is None:
            wait(self.waitables, LOOK_EVERY)
        return ending

    def start(self, job: Job[Any]) -> None:
        """Begin a job; `poll` tells its end."""
        self._job = job
        if self._handle is not None and (job.afresh or self._handle.has_ended()):
            self.kill()
        if self._handle is None:
            self._handle, self._loaded = WorkerHandle(self._setup), False
        else:
            self._handle.forget_output()
            self._handle.send(job)
        self._watch = self._watch_from_now(self._handle)

    def _watch_from_now(self, handle: WorkerHandle) -> StallWatch:
        return StallWatch(self._limits, handle.processor_seconds(), time.monotonic())

    @property
    def waitables(self) -> list[Any]:
        """What becomes readable when there may be news for `poll`."""
        return self._handle.waitables if self._handle is not None else []

    def poll(self) -> Finished | Faulted | None:
        """Look after the job that was started."""
        handle = self._handle
        if handle is None or self._job is None:
            raise HarnessFault("a worker without a job was polled for its end")
        handle.drain_output()
        ended = handle.has_ended()
        try:
            reply = handle.receive()
        except UnreadableReply:
            reply = self._garbled(handle)
        if reply is None:
            reply = self._crash(handle) if ended else self._hang(handle)
        if isinstance(reply, Ready):
            self._loaded = True
            handle.forget_output()
            handle.send(self._job)
            self._watch = self._watch_from_now(handle)
            return None
        return None if reply is None else self._ending(handle, reply)

    def _ending(self, handle: WorkerHandle, reply: Reply) -> Finished | Faulted:
        self._job = None
        if isinstance(reply, Faulted):
            reply = self._with_output(handle, reply)
        if not self._loaded:
            self.kill()
        if isinstance(reply, Refused):
            raise InputError(reply.sentence)
        if isinstance(reply, Broken):
            raise HarnessFault(f"the harness failed in a worker process: {reply.traceback}")
        if isinstance(reply, Faulted):
            return self._without_exhausted(reply)
        if isinstance(reply, Finished):
            return reply
        raise HarnessFault("a worker process reported twice that it was ready")

    def _with_output(self, handle: WorkerHandle, reply: Faulted) -> Faulted:
        """Add to the fault of a program, which has no traceback, what the program printed."""
        reports_output = KINDS[self._setup.candidate.kind].reports_output
        if reply.fault.traceback or handle is not self._handle or not reports_output:
            return reply
        return Faulted(replace(reply.fault, traceback=bounded_text(handle.last_output())))

    def _without_exhausted(self, reply: Faulted) -> Faulted:
        """Replace a process whose memory the candidate may still hold."""
        if reply.fault.error != MemoryError.__name__:
            return reply
        self.kill()
        limit = f"{self._limits.memory_bytes / 2**30:g} GiB"
        message = f"{reply.fault.message} (a candidate may allocate {limit})"
        return Faulted(replace(reply.fault, message=message))

    def _crash(self, handle: WorkerHandle) -> Reply:
        output = bounded_text(handle.last_output())
        status = handle.exit_status()
        what, error = ending_in_words(status)
        fault = self._located(handle, Fault(FaultKind.CRASH, f"the process {what}", "loading", error=error))
        if status == LOST_CONNECTION:
            fault = replace(fault, message=_CONNECTION_CLOSED)
        activity = handle.progress.activity
        self.kill()
        if activity is Activity.STARTING:
            return Broken(f"the process {what} before it came to the candidate: {output}")
        return Faulted(replace(fault, traceback=output))

    def _garbled(self, handle: WorkerHandle) -> Reply:
        fault = self._located(handle, Fault(FaultKind.CRASH, "", "loading"))
        self.kill()
        return Faulted(replace(fault, message=_CONNECTION_GARBLED))

    def _hang(self, handle: WorkerHandle) -> Reply | None:
        progress = handle.progress
        why = self._watch.stalled(
            progress.state, progress.activity, handle.processor_seconds(), time.monotonic()
        )
        if why is None:
            return None
        fault = self._located(handle, Fault(FaultKind.HANG, why, "loading"))
        stack = bounded_text(handle.stack())
        self.kill()
        if progress.activity in _HARNESS_OWN:
            return Broken(f"{why}, outside the candidate: {stack}")
        return Faulted(replace(fault, traceback=stack))

    def _located(self, handle: WorkerHandle, fault: Fault) -> Fault:
        """Add to a fault what the shared memory tells of the step in which it happened."""
        progress = handle.progress
        if not self._loaded or progress.activity is Activity.LOADING:
            return replace(fault, message=f"{fault.message} while loading the candidate")
        if progress.activity is not Activity.RUNNING:
            return replace(fault, phase="step", message=f"{fault.message} outside of its steps")
        begun = int(progress.steps[0])
        if begun == 0:
            return replace(fault, phase="reset", message=f"{fault.message} in reset")
        sense, steps = progress.last_sense(), begun - 1
        time_of_step, inputs = (sense.time, sense._asdict()) if sense is not None else (None, None)
        message = f"{fault.message} after {counted(steps, 'completed step')}"
        return replace(fault, phase="step", message=message, step=steps, time=time_of_step, sense=inputs)

    def kill(self) -> None:
        """End the process at once; the next job starts another one."""
        if self._handle is not None:
            self._handle.end()
        self._handle = None

    def hang_up(self) -> None:
        """Tell the process to end by itself, without waiting for it."""
        if self._handle is not None:
            self._handle.hang_up()

    def close(self) -> None:
        """End the process: at once if it is busy, otherwise by itself within a moment."""
        if self._handle is not None and self._job is None:
            self._handle.end_in_peace()
        self.kill()
        self._job = None

    def __enter__(self) -> Self:
        """Return the worker; its process starts with its first job."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the worker."""
        self.close()


def is_hang(ending: Finished | Faulted) -> bool:
    """Tell whether a job ended with a hang, which is tried once more."""
    return isinstance(ending, Faulted) and ending.fault.kind is FaultKind.HANG


def unwrapped(ending: Finished | Faulted) -> Any:
    """Give what a job came to."""
    return ending.fault if isinstance(ending, Faulted) else ending.result
