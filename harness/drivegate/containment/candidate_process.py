"""The process that runs a candidate's code: asked, watched, and replaced after a crash or a hang.

What comes back from it is never believed: commands are played back by whoever judges them, and text is bounded.
"""

import signal
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from multiprocessing.connection import wait
from typing import Any, Final

from numpy.typing import NDArray

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.contract import other_contract
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind, bounded_text, ending_in_words
from drivegate.candidates.kinds import KINDS
from drivegate.candidates.sanitizers import read_report
from drivegate.candidates.step_costs import NO_COSTS, StepCosts
from drivegate.containment.candidate_handle import CandidateHandle
from drivegate.containment.machine_memory import is_for_memory, killed_for_memory, lack_of_memory
from drivegate.containment.protocol import (
    CHECK_BYTES,
    CloseLoop,
    Ending,
    MakeInstance,
    Order,
    Reply,
    RunOrder,
    Setup,
    UnreadableReply,
    fault_of,
    remarks_of,
)
from drivegate.containment.serving import LOST_CONNECTION
from drivegate.containment.shared_memory import Activity
from drivegate.containment.watches import MemoryWatch, PaceWatch, SlowRun, StallWatch, WorkerLimits
from drivegate.isolation.layers import Layer, layers_in_words
from drivegate_cases.documents.wording import counted
from drivegate_models.errors import HarnessFault, InputError
from drivegate_models.loop.exchange import COMPLETED, STOPPED

LOOK_EVERY: Final = 0.05
"""Time between two looks at a process that reports nothing by itself (s)."""

_OTHER_CONTRACT = (other_contract("current", "duty"), other_contract("duty", "current"))
# What isolation makes of an attempt to use a file, a device or the network.
_OF_ISOLATION = ("PermissionError", "FileNotFoundError", "OSError", "ConnectionRefusedError")
_NOT_ITS_OWN = "a candidate must leave alone what it has not opened"
_CONNECTION_CLOSED = f"the process closed its connection to the harness; {_NOT_ITS_OWN}"
_CONNECTION_GARBLED = f"the process wrote into its connection to the harness; {_NOT_ITS_OWN}"


@dataclass(frozen=True)
class Answered:
    """What a candidate's process has answered in a run."""

    commands: NDArray[Any]
    """The commands, as they were given, of the contract's layout; the last one is what is wrong where the
    status says so, shape (n,)."""
    status: int
    """Status of the loop there, of `drivegate_models.loop.exchange` or `duty_command`."""
    check: bytes
    """Digest of the plant's results there."""
    fault: Fault | None
    """What ended the run, where it is known there."""
    costs: StepCosts = NO_COSTS
    remarks: tuple[str, ...] = ()
    """What the process has warned of so far."""


class CandidateProcess:
    """Carries out orders with one candidate, in a process that is replaced after a crash or a hang."""

    def __init__(
        self,
        candidate: Candidate,
        limits: WorkerLimits | None = None,
        on_slow: Callable[[SlowRun], None] | None = None,
        layers: tuple[Layer, ...] = (),
    ) -> None:
        self.candidate = candidate
        self._layers = layers
        self._limits = limits or WorkerLimits()
        self._on_slow = on_slow
        self._handle: CandidateHandle | None = None
        self._memory_watch: MemoryWatch | None = None
        self._killed_before = 0
        self._free_memory = 0
        self.generation = 0
        self.starts_afresh = False
        self._is_set_up = False
        self._has_instance = False
        self._has_run = False

    def made_instance(self) -> Reply:
        """Make a new instance of the candidate, and delete the previous one; start the process if there is none."""
        self._has_instance = False
        if not self.is_running:
            self.kill()
            self._start()
        try:
            reply = self.carried_out(MakeInstance())
        except CandidateFault:
            self.kill()
            raise
        self._has_instance = True
        return reply

    def carried_out(self, order: Order) -> Reply:
        """Have an order carried out that answers with no commands."""
        reply = self._replied(order, 0)
        fault = self._fault_in(reply)
        if fault is not None:
            self._end_without_memory(fault)
            raise CandidateFault(fault)
        return reply

    def answered(self, order: RunOrder, steps: int) -> Answered:
        """Have an order carried out that answers with commands, as many as there are steps."""
        try:
            reply = self._replied(order, steps)
        except CandidateFault as died:
            # The commands that it has given before are still in the memory that it shared.
            given = min(died.fault.step or 0, steps)
            commands = self._running.copied_commands(order.commands, given)
            self.kill()
            return Answered(commands, STOPPED, bytes(CHECK_BYTES), died.fault)
        finally:
            self._has_run = True
        fault = self._fault_in(reply)
        if fault is None and reply.status == COMPLETED and reply.steps != steps:
            fault = self._garbled(self._running)
        status = reply.status if fault is None else STOPPED
        # A command that ended the run is not among the answered steps, but the fault shows it.
        count = reply.steps + (status not in (COMPLETED, STOPPED))
        commands = self._running.copied_commands(order.commands, min(count, steps))
        if fault is not None:
            self._end_without_memory(fault)
        return Answered(commands, status, reply.check, fault, reply.costs, self._remarks_in(reply))

    def _end_without_memory(self, fault: Fault) -> None:
        """End a process whose memory the candidate may still hold."""
        if fault.error == MemoryError.__name__:
            self.kill()

    @property
    def _running(self) -> CandidateHandle:
        assert self._handle is not None, "a process was asked before"
        return self._handle

    @property
    def is_running(self) -> bool:
        return self._handle is not None and not self._handle.has_ended()

    def _start(self) -> None:
        self._killed_before = killed_for_memory()
        self._handle = CandidateHandle(self.candidate, self._layers, afresh=self.starts_afresh)
        self.generation += 1
        # Only before this can anything but the candidate be at fault, whatever the process reports later.
        self._is_set_up = False
        self._memory_watch = None
        self._replied(Setup(self.candidate, self._limits.memory_bytes), 0)
        self._memory_watch = MemoryWatch(self._limits.memory_bytes, self._handle.used_memory())
        self._free_memory = self._handle.free_memory()
        self._is_set_up = True

    def _replied(self, order: Order, steps: int) -> Reply:
        handle = self._running
        handle.forget_output()
        every = steps + order.steps_before if isinstance(order, CloseLoop) else steps
        watch = StallWatch(self._limits, handle.processor_seconds(), time.monotonic(), every)
        pace = PaceWatch(steps, self._limits.allowed_seconds(steps))
        handle.send(order, steps * order.commands.itemsize if isinstance(order, RunOrder) else 0)
        while True:
            wait(handle.waitables, LOOK_EVERY)
            self._look_at_pace(handle, pace, steps)
            handle.drain_output()
            # A process that has ended may have answered before.
            ended = handle.has_ended()
            try:
                reply = handle.receive()
            except UnreadableReply:
                raise CandidateFault(self._garbled(handle)) from None
            if reply is not None:
                return self._settled(reply, order)
            fault = self._crash(handle) if ended else self._hang(handle, watch) or self._excess(handle)
            if fault is not None:
                raise CandidateFault(fault)

    def _look_at_pace(self, handle: CandidateHandle, pace: PaceWatch, steps: int) -> None:
        """Report once that a run will take long; orders without steps are none."""
        # A process that prepares or compiles shows nothing of the pace of its steps.
        if self._on_slow is None or steps == 0 or handle.progress.activity is not Activity.RUNNING:
            return
        slow = pace.slow(int(handle.progress.steps[0]), time.monotonic())
        if slow is not None:
            on_slow, self._on_slow = self._on_slow, None
            on_slow(slow)

    def _settled(self, reply: Reply, order: Order) -> Reply:
        if reply.ending is Ending.REFUSED:
            if not self._may_refuse(reply, order):
                raise CandidateFault(self._garbled(self._running))
            self.kill()
            # Before the first run, code of the candidate may have written the sentence: say whose process it is from.
            raise InputError(f"{bounded_text(reply.text)} (reported by the candidate's process)")
        if reply.ending is Ending.BROKEN:
            if self._is_set_up:
                raise CandidateFault(self._garbled(self._running))
            self.kill()
            raise HarnessFault(f"the harness failed in a candidate's process: {reply.text}")
        return reply

    def _may_refuse(self, reply: Reply, order: Order) -> bool:
        """Return True if drivegate's own code there may have refused the candidate, rather than the candidate itself.

        It refuses one that cannot be loaded or reset, before any run. In a run it can only find, by the first command,
        that the candidate is for drives of the other contract.
        """
        if self._has_run or not isinstance(order, RunOrder):
            return not self._has_run
        return (
            self.candidate.contract is None
            and int(self._running.progress.steps[0]) <= 1
            and reply.text in _OTHER_CONTRACT
        )

    def _remarks_in(self, reply: Reply) -> tuple[str, ...]:
        """Read the remarks of a reply; those of a candidate that wrote something else there are lost."""
        if reply.ending is Ending.DONE:
            with suppress(UnreadableReply):
                return remarks_of(reply.text)
        return ()

    def _fault_in(self, reply: Reply) -> Fault | None:
        """Read the fault of a reply, and add what is known of it here."""
        if reply.ending is not Ending.FAULT:
            return None
        handle = self._running
        try:
            fault = fault_of(reply.text)
        except UnreadableReply:
            return self._garbled(handle)
        self._require_memory(fault)
        if not fault.traceback and KINDS[self.candidate.kind].reports_output:
            fault = replace(fault, traceback=bounded_text(handle.last_output()))
        if fault.error == MemoryError.__name__:
            limit = f"{self._limits.memory_bytes / 2**30:g} GiB"
            fault = replace(fault, message=f"{fault.message} (a candidate may allocate {limit})")
        if self._layers and fault.error in _OF_ISOLATION:
            hint = f"the candidate is {layers_in_words(self._layers)}, see --isolation and DRIVEGATE_READ"
            fault = replace(fault, message=f"{fault.message} ({hint})")
        if fault.phase == "step" and fault.step is None:
            fault = replace(fault, step=max(int(handle.progress.steps[0]) - 1, 0))
        return fault

    def _crash(self, handle: CandidateHandle) -> Fault:
        printed = handle.last_output()
        output, status = bounded_text(printed), handle.exit_status()
        what, error = ending_in_words(status)
        if status == -signal.SIGKILL and killed_for_memory() > self._killed_before:
            self.kill()
            raise lack_of_memory("the system killed the candidate's process")
        if not self._is_set_up:
            self.kill()
            raise HarnessFault(f"the process {what} before it came to the candidate: {output}")
        fault = self._located(handle, Fault(FaultKind.CRASH, f"the process {what}", "loading", error=error))
        if status == LOST_CONNECTION:
            fault = replace(fault, message=_CONNECTION_CLOSED)
        fault = replace(fault, traceback=output)
        self._require_memory(fault)
        return self._reported(fault, printed)

    def _reported(self, fault: Fault, output: str) -> Fault:
        """Make the end of a process that a sanitizer has ended into what that reports."""
        if self.candidate.instrumented is None or self.candidate.instrumented.by != "sanitizers":
            return fault
        if self.candidate.instrumented.copied is not None:
            original, copy = self.candidate.instrumented.copied
            output = output.replace(f"{copy}/", f"{original}/")
        report = read_report(output, self.candidate.folder, self.candidate.sources)
        if report is None:
            return fault
        return replace(fault, kind=FaultKind.SANITIZER, message=report.message, error=report.place)

    def _require_memory(self, fault: Fault) -> None:
        """End the job without a verdict where a candidate may have had less memory than it is allowed to allocate."""
        if self._is_set_up and is_for_memory(fault, self._free_memory, self._limits.memory_bytes):
            self.kill()
            raise lack_of_memory(f"the candidate's process was refused an allocation ({fault.message})")

    def _garbled(self, handle: CandidateHandle) -> Fault:
        fault = self._located(handle, Fault(FaultKind.CRASH, "", "loading"))
        handle.end()
        return replace(fault, message=_CONNECTION_GARBLED)

    def _hang(self, handle: CandidateHandle, watch: StallWatch) -> Fault | None:
        progress = handle.progress
        why = watch.stalled(progress.state, progress.activity, handle.processor_seconds(), time.monotonic())
        if why is None:
            return None
        fault = self._located(handle, Fault(FaultKind.HANG, why, "loading"))
        stack = bounded_text(handle.stack())
        handle.end()
        if not self._is_set_up:
            self.kill()
            raise HarnessFault(f"{why}, outside the candidate: {stack}")
        return replace(fault, traceback=stack)

    def _excess(self, handle: CandidateHandle) -> Fault | None:
        """End a process that uses too much memory, together with those that it has started."""
        watch = self._memory_watch
        if watch is None or not watch.is_due(time.monotonic()):
            return None
        why = watch.excess(handle.used_memory())
        if why is None:
            return None
        fault = self._located(handle, Fault(FaultKind.CRASH, why, "loading", error=MemoryError.__name__))
        handle.end()
        return fault

    def _located(self, handle: CandidateHandle, fault: Fault) -> Fault:
        """Add to a fault what the shared memory shows of the step in which it happened."""
        progress = handle.progress
        if progress.activity is Activity.LETTING_GO:
            return replace(fault, phase="step", message=f"{fault.message} in the deletion of an instance")
        if not self._has_instance or progress.activity is Activity.LOADING:
            return replace(fault, message=f"{fault.message} while loading the candidate")
        if progress.activity is not Activity.RUNNING:
            return replace(fault, phase="step", message=f"{fault.message} outside of its steps")
        begun = int(progress.steps[0])
        if begun <= 0:
            return replace(fault, phase="reset", message=f"{fault.message} in reset")
        message = f"{fault.message} after {counted(begun - 1, 'completed step')}"
        return replace(fault, phase="step", message=message, step=begun - 1)

    def kill(self) -> None:
        """End the process at once; the next order starts another one."""
        if self._handle is not None:
            self._handle.end()
        self._handle = None
        self._has_instance = False

    def close(self) -> None:
        """End the process: by itself within a moment, or else by force."""
        if self._handle is not None:
            self._handle.end_in_peace()
        self.kill()
