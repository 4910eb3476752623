"""A judge in a process of its own, so that several work side by side; it never runs a candidate's code."""

import os
import pickle
import tempfile
import time
import traceback
import weakref
from collections.abc import Callable, Mapping
from contextlib import suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.kinds import KINDS
from drivegate.containment.candidate_isolation import isolating_layers
from drivegate.containment.judge import Judge
from drivegate.containment.kept_process import KeptProcess, Role
from drivegate.containment.machine_memory import killed_for_memory, lack_of_memory
from drivegate.containment.messages import (
    Broken,
    Compiled,
    Faulted,
    Finished,
    Job,
    Outcome,
    Refused,
    WithoutMemory,
)
from drivegate.containment.watches import SlowRun, WorkerLimits
from drivegate.isolation.layers import refuse_inspection
from drivegate.isolation.system_calls import end_with_parent
from drivegate_cases.documents.system_failure import refusal_by_system
from drivegate_models.errors import HarnessFault, InputError, OutOfMemory

_KILLED = "a process of the harness that watched the candidate was killed"
_STOPPED = "a process of the harness that watched the candidate was stopped"
_STILL_SECONDS = 60.0
_STILL = f"a process of the harness that watched the candidate did nothing for {_STILL_SECONDS:g} s"
# A debugger that attaches also stops a process, for a moment.
_STOPPED_SECONDS = 10.0


class JudgeProcess:
    """Does jobs with one candidate, one after another, in a process that is replaced when it has died."""

    def __init__(
        self,
        candidate: Candidate,
        limits: WorkerLimits | None,
        kernels: Mapping[str, bytes],
        on_slow: Callable[[SlowRun], None] | None = None,
        *,
        is_one_of_many: bool = False,
    ) -> None:
        self._is_one_of_many = is_one_of_many
        self._candidate = candidate
        self._limits = limits
        self._kernels = kernels
        self._on_slow = on_slow
        self._kept: KeptProcess | None = None
        self._killed_before = 0
        self._connection: Connection[Any, Any] | None = None
        self._busy = False
        self._stopped_since: float | None = None
        self._moved = (0.0, 0.0)
        self.saved: dict[str, bytes] = {}
        """Digests of the compiled kernels that the process has saved."""

    def start(self, job: Job[Any]) -> None:
        """Begin a job; `poll` shows its end."""
        if self._connection is None:
            self._begin(job.target.__module__)
        assert self._connection is not None, "a process was started"
        self._busy = True
        self._moved = (-1.0, time.monotonic())
        with suppress(BrokenPipeError, ConnectionResetError):
            self._connection.send(job)

    def _begin(self, module: str) -> None:
        layers = isolating_layers(self._candidate)
        if layers:
            refuse_inspection()
        ours, theirs = Pipe()
        self._killed_before = killed_for_memory()
        try:
            self._kept = KeptProcess(
                Role.JUDGE,
                None,
                (theirs.fileno(),),
                # A template runs nobody else's code.
                modules=(module,) if module.startswith("drivegate.") else (),
                is_one_of_many=self._is_one_of_many,
            )
        finally:
            theirs.close()
        self._connection = ours
        self.end = weakref.finalize(self, _end, self._kept, ours)
        ours.send((self._candidate, self._limits, layers, self._kernels))

    @property
    def waitables(self) -> list[Any]:
        """What becomes readable when there may be news for `poll`."""
        return [] if self._connection is None else [self._connection]

    def poll(self) -> Any:
        """Look for the end of the job that was started: a `Finished` or `Faulted`, or None."""
        connection = self._connection
        if connection is None or not self._busy:
            raise HarnessFault("a judge without a job was polled for its end")
        try:
            if not connection.poll():
                return self._stopped() or self._standing_still()
            outcome: Outcome | SlowRun | Compiled = connection.recv()
        except (EOFError, ConnectionResetError):
            self.kill()
            if killed_for_memory() > self._killed_before:
                raise lack_of_memory("the system killed a worker") from None
            if KINDS[self._candidate.kind].is_included:
                raise HarnessFault("a judge's process has died") from None
            # No candidate but one that means it ends the process that judges it.
            return Faulted(Fault(FaultKind.CRASH, _KILLED, "step"))
        if isinstance(outcome, SlowRun):
            if self._on_slow is not None:
                self._on_slow(outcome)
            return None
        if isinstance(outcome, Compiled):
            self.saved |= outcome.kernels
            return None
        self._busy = False
        if isinstance(outcome, Refused):
            raise InputError(outcome.sentence)
        if isinstance(outcome, WithoutMemory):
            raise OutOfMemory(outcome.sentence)
        if isinstance(outcome, Broken):
            raise HarnessFault(f"the harness failed in a judge's process: {outcome.traceback}")
        return outcome

    def _stopped(self) -> Faulted | None:
        """Look whether the process has been stopped for some time, which a candidate may have done; end it then."""
        kept = self._kept
        if kept is None or KINDS[self._candidate.kind].is_included or not kept.is_stopped():
            self._stopped_since = None
            return None
        now = time.monotonic()
        self._stopped_since = self._stopped_since or now
        if now - self._stopped_since < _STOPPED_SECONDS:
            return None
        self.kill()
        return Faulted(Fault(FaultKind.CRASH, _STOPPED, "step"))

    def _standing_still(self) -> Faulted | None:
        """Look whether the process has used no processor time for long, and end it then.

        A judge that waits for its candidate looks at it several times a second. One that waits for the system, such as
        for a file that another process has leased, does nothing.
        """
        kept = self._kept
        if kept is None or KINDS[self._candidate.kind].is_included:
            return None
        used, now = kept.processor_seconds(), time.monotonic()
        if used > self._moved[0]:
            self._moved = (used, now)
            return None
        if now - self._moved[1] < _STILL_SECONDS:
            return None
        self.kill()
        return Faulted(Fault(FaultKind.HANG, _STILL, "step"))

    def kill(self) -> None:
        """End the process at once; the next job starts another one."""
        if self._connection is not None:
            self.end()
        self._connection, self._kept, self._busy = None, None, False

    def hang_up(self) -> None:
        """Request an idle process to end by itself, without waiting for it."""
        if self._connection is not None and not self._busy:
            self._connection.close()

    def close(self) -> None:
        """End the process: at once if it is busy, otherwise by itself within a moment."""
        if self._kept is not None and not self._busy:
            self._kept.wait_for_worker()
        self.kill()


def judge_jobs(connection: int, temporary: str, parent: int) -> None:
    """Do jobs from a connection; this is the inside of a judge's process."""
    end_with_parent(parent)
    # The folder for kernels is chosen before, since it may lie among the temporary files.
    from drivegate_models.compilation import kernels  # noqa: F401
    from drivegate_models.compilation.kernel_files import saved_digests, trust_only

    # What a candidate's process leaves goes with this one, however it ends.
    tempfile.tempdir = temporary
    os.set_inheritable(connection, False)
    channel: Connection[Any, Any] = Connection(connection)
    try:
        candidate, limits, layers, digests = channel.recv()
        if not KINDS[candidate.kind].is_included:
            # The digests were taken before any code of the candidate ran, which could have changed the files since.
            trust_only(digests)
        if layers:
            refuse_inspection()

        def report(run: SlowRun) -> None:
            channel.send_bytes(_written(run))

        with Judge(candidate, limits=limits, on_slow=report, layers=layers) as judge:
            saved: dict[str, bytes] = {}
            while True:
                outcome = _outcome(judge, channel.recv())
                # Of what a judge does not report, nobody knows whether a candidate has written it.
                if not layers and saved != (saved := saved_digests()):
                    channel.send_bytes(_written(Compiled(saved)))
                channel.send_bytes(_written(outcome))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return


def _outcome(judge: Judge, job: Job[Any]) -> Outcome:
    """Do a job, and turn each way in which it can end into a message."""
    try:
        result = judge.once(job)
    except InputError as error:
        return Refused(str(error))
    except OutOfMemory as error:
        return WithoutMemory(str(error))
    except MemoryError:
        return WithoutMemory(str(lack_of_memory("an allocation of drivegate's own was refused")))
    except Exception as error:
        refusal = refusal_by_system(error)
        return Broken(traceback.format_exc()) if refusal is None else Refused(refusal)
    return Faulted(result) if isinstance(result, Fault) else Finished(result)


def _written(outcome: Outcome | SlowRun | Compiled) -> bytes:
    try:
        return pickle.dumps(outcome, pickle.HIGHEST_PROTOCOL)
    except Exception:
        return pickle.dumps(Broken(traceback.format_exc()), pickle.HIGHEST_PROTOCOL)


def _end(kept: KeptProcess, connection: "Connection[Any, Any]") -> None:
    kept.end()
    connection.close()
