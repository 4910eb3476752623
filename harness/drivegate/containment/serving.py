"""The inside of a candidate's process: it carries out orders, one after another, until its judge hangs up.

It judges nothing: of a run it returns the commands. Its plant is there to close the loop only.
"""

import ctypes
import faulthandler
import gc
import hashlib
import os
import pickle
import resource
import signal
import socket
import sys
import threading
import traceback
from collections.abc import Callable
from typing import Any, Final

import psutil
from numpy.typing import NDArray

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind, Phase, exception_fault
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.step_costs import NO_COSTS, StepCosts
from drivegate.containment.protocol import (
    CHECK_BYTES,
    PACKET,
    CloseLoop,
    Ending,
    GiveSenses,
    MakeInstance,
    Order,
    Reply,
    Reset,
    Setup,
    fault_text,
    packed,
    remarks_text,
)
from drivegate.containment.restarting import Restarter
from drivegate.containment.shared_memory import Activity, SharedMemory, SharedProgress
from drivegate.isolation.system_calls import end_with_parent
from drivegate_models.errors import InputError
from drivegate_models.loop.loop_inputs import SteppedController

STACK_SIGNAL: Final = signal.SIGUSR1
"""Signal at which a candidate's process prints the Python stack of its threads."""
LOST_CONNECTION: Final = 119
"""Exit status of a process whose connection to its judge the candidate has closed."""


def serve(connection: int, progress: int, parent: int) -> None:
    end_with_parent(parent)
    # A check leaves nothing next to the candidate's sources.
    sys.dont_write_bytecode = True
    faulthandler.enable()
    faulthandler.register(STACK_SIGNAL, all_threads=True)
    # Programs that the candidate starts could otherwise write into the connection, or keep it open.
    for descriptor in (connection, progress):
        os.set_inheritable(descriptor, False)
    server = _Server(socket.socket(fileno=connection), SharedProgress(progress))
    try:
        server.serve()
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return


class _Server:
    def __init__(self, channel: socket.socket, progress: SharedProgress) -> None:
        self._channel = channel
        self._identity = _identity(channel.fileno())
        self._progress = progress
        self._memory: SharedMemory | None = None
        self._candidate: Candidate | None = None
        self._controller: Controller | None = None
        self._nameplate: Any = None

    def serve(self) -> None:
        process = os.getpid()
        while True:
            self._progress.enter(Activity.WAITING if self._candidate else Activity.STARTING)
            length = self._awaited_length()
            self._progress.enter(Activity.PREPARING if self._candidate else Activity.STARTING)
            reply = self._carried_out(length)
            if os.getpid() != process:
                # The candidate made a copy of the process, and the copy came back from the candidate's code.
                os._exit(0)
            if _identity(self._channel.fileno()) != self._identity:
                os._exit(LOST_CONNECTION)
            self._channel.send(packed(reply))

    def _awaited_length(self) -> int:
        """Wait for an order, and return the number of its bytes."""
        packet, descriptors, _, _ = socket.recv_fds(self._channel, PACKET.size, 1)
        if not packet:
            raise EOFError
        _, length, size = PACKET.unpack(packet)
        if descriptors:
            self._memory = SharedMemory(descriptors[0], size)
            self._memory.close()
        return int(length)

    def _carried_out(self, length: int) -> Reply:
        """Carry out an order, and turn each way in which that can end into a reply."""
        try:
            return self._done(length)
        except CandidateFault as error:
            return _fault_reply(error.fault)
        except MemoryError as error:
            phase: Phase = "loading" if self._progress.activity is Activity.LOADING else "step"
            return _fault_reply(exception_fault(error, phase))
        except InputError as error:
            return Reply(Ending.REFUSED, text=str(error))
        except Exception as error:
            if self._candidate is None:
                return Reply(Ending.BROKEN, text=traceback.format_exc())
            return _fault_reply(_disturbed(error, "loading" if self._controller is None else "step"))

    def _done(self, length: int) -> Reply:
        memory = self._memory
        assert memory is not None, "the first order brings the memory"
        _without_observers()
        # What is to come in a run must not lie in a variable when the candidate's code looks around, so the order
        # of a run is taken apart where it is used.
        pending: list[Any] = [pickle.loads(memory.take(length))]
        if isinstance(pending[0], CloseLoop):
            return self._loop_closed(pending, memory)
        if isinstance(pending[0], GiveSenses):
            return self._senses_given(pending, memory)
        return self._set_up(pending.pop())

    def _set_up(self, order: Order) -> Reply:
        if isinstance(order, Setup):
            _limit_memory(order.memory_limit)
            # A crash is a verdict here, and must not fill the candidate's folder with images of its memory.
            resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
            self._candidate = order.candidate
        elif isinstance(order, MakeInstance):
            return self._instance_made()
        elif isinstance(order, Reset):
            self._reset(order)
        return Reply(Ending.DONE)

    def _instance_made(self) -> Reply:
        from drivegate.candidates.python.bridge import PythonController

        assert self._candidate is not None, "the first order names the candidate"
        # Deleted before the next one is made: what goes wrong in the deletion is no fault of loading.
        with self._progress.marked(Activity.LETTING_GO):
            self._controller = None
        with self._progress.marked(Activity.LOADING):
            self._controller = load_controller(self._candidate)
            size = getattr(self._controller, "state_size", 0)
            is_python = isinstance(self._controller, PythonController)
        return Reply(Ending.DONE, is_python=is_python, state_size=size if isinstance(size, int) else 0)

    def _reset(self, order: Reset) -> None:
        self._progress.steps[0] = 0
        self._nameplate = order.nameplate
        with self._progress.running():
            self._instance.reset(order.nameplate)

    @property
    def _instance(self) -> Controller:
        assert self._controller is not None, "an instance is made before it is used"
        return self._controller

    def _loop_closed(self, pending: list[Any], memory: SharedMemory) -> Reply:
        from drivegate_models.loop.exchange import COMPLETED

        restarter = Restarter(self._instance, self._nameplate)
        loop, records = self._made_ready(pending, memory, restarter)
        self._begin_counting()
        with self._progress.running():
            status, _ = loop(*pending.pop())
        self._write_counters()
        steps = int(records.run["steps"][0])
        if restarter.failures:
            # The run ended because the instance could not be reset in the middle of it.
            failure = restarter.failures[0]
            fault = (
                failure.fault if isinstance(failure, CandidateFault) else exception_fault(failure, "reset")
            )
            return Reply(Ending.FAULT, int(status), steps, text=fault_text(fault))
        if status == COMPLETED:
            return Reply(
                Ending.DONE,
                status,
                steps,
                costs=self._taken_costs(),
                check=check_of(records),
                text=self._remarks(),
            )
        return self._stopped(int(status), steps)

    def _made_ready(
        self, pending: list[Any], memory: SharedMemory, restarter: Restarter
    ) -> tuple[Callable[..., Any], Any]:
        """Exchange a pending order for the arguments of the compiled loop."""
        order: CloseLoop = pending.pop()
        stepped = self._stepped(memory.commands(order.commands))
        prepared = order.prepare(order.inputs, stepped, restarter.restarts(order.restart_steps))
        arguments = _out_of_sight(prepared.arguments)
        pending.append(arguments)
        return _entry_point(prepared.loop, arguments), prepared.records

    def _stepped(self, kept: NDArray[Any]) -> SteppedController:
        instance = self._instance
        return SteppedController(instance.step_address, instance.state_address, self._progress.steps, kept)

    def _senses_given(self, pending: list[Any], memory: SharedMemory) -> Reply:
        from drivegate_models.loop.exchange import COMPLETED

        # Only here, since it slows each step down and nobody asks for that of a run.
        getattr(self._instance, "watch_accesses", lambda: None)()
        steps = self._steps_made_ready(pending, memory)
        self._begin_counting()
        with self._progress.running():
            status, answered = steps(*pending.pop())
        self._write_counters()
        if status == COMPLETED:
            return Reply(Ending.DONE, int(status), int(answered), costs=self._taken_costs())
        return self._stopped(int(status), int(answered))

    def _remarks(self) -> str:
        return remarks_text(getattr(self._instance, "remarks", tuple)())

    def _begin_counting(self) -> None:
        """Count what the run reaches of the candidate's code, where the interpreter does that."""
        getattr(self._instance, "begin_counting", lambda: None)()

    def _write_counters(self) -> None:
        """Write what the run has reached of the candidate's code, where that is counted."""
        getattr(self._instance, "write_counters", lambda: None)()

    def _taken_costs(self) -> StepCosts:
        take = getattr(self._instance, "taken_costs", None)
        costs: StepCosts = NO_COSTS if take is None else take()
        return costs

    def _steps_made_ready(self, pending: list[Any], memory: SharedMemory) -> Callable[..., Any]:
        """Exchange a pending order for the arguments of the compiled steps."""
        from drivegate_models.contract.layout import LAYOUTS
        from drivegate_models.loop.given_steps import MAKE_STEPS, given_senses

        order: GiveSenses = pending.pop()
        self._progress.steps[0] = 0
        given = given_senses(self._stepped(memory.commands(order.commands)), order.senses, order.currents)
        arguments = _out_of_sight((given,))
        pending.append(arguments)
        return _entry_point(MAKE_STEPS[LAYOUTS[order.senses.dtype].name], arguments)

    def _stopped(self, status: int, steps: int) -> Reply:
        """Answer for a run that ended before its end: with the fault, if the controller itself knows it."""
        refusal: InputError | None = getattr(self._instance, "refusal", None)
        # A candidate that has answered before as its drive takes it is not one for another drive.
        if refusal is not None and steps == 0:
            raise refusal
        fault = self._instance.fault
        if fault is None:
            return Reply(Ending.DONE, status, steps)
        return Reply(Ending.FAULT, status, steps, text=fault_text(fault))


def check_of(records: Any) -> bytes:
    """Digest the results of a run's plant: its totals, and the last speed."""
    speed = float(records.run["speed_final"][0])
    digest = hashlib.blake2b(records.totals.tobytes(), digest_size=CHECK_BYTES)
    digest.update(speed.hex().encode())
    return digest.digest()


def _entry_point(function: Any, arguments: tuple[Any, ...]) -> Callable[..., Any]:
    """Compile a function for arguments; called by its own name it would pass them on in a tuple that is in sight."""
    if not hasattr(function, "compile"):
        # Compilation is switched off.
        plain: Callable[..., Any] = function
        return plain
    from numba import typeof

    # A function that kernels call has no way in of its own.
    enterable = getattr(function, "from_python", function)
    signature = tuple(map(typeof, arguments))
    enterable.compile(signature)
    entry: Callable[..., Any] = enterable.overloads[signature].entry_point
    return entry


def _out_of_sight(arguments: Any) -> Any:
    """Take tuples, and those inside, off the list of objects that the garbage collector shows to everyone."""
    untrack = ctypes.pythonapi.PyObject_GC_UnTrack
    untrack.argtypes, untrack.restype = [ctypes.py_object], None
    for part in arguments:
        if isinstance(part, tuple):
            _out_of_sight(part)
    if gc.is_tracked(arguments):
        untrack(arguments)
    return arguments


def _without_observers() -> None:
    """Switch off what a candidate may have set to look on while an order is taken apart."""
    sys.settrace(None)
    sys.setprofile(None)
    threading.settrace(None)
    threading.setprofile(None)


def _fault_reply(fault: Fault) -> Reply:
    return Reply(Ending.FAULT, text=fault_text(fault))


def _disturbed(error: Exception, phase: Phase) -> Fault:
    """Describe an error of drivegate's own code in a process that has run the candidate's."""
    fault = exception_fault(error, phase)
    return Fault(
        FaultKind.CRASH,
        f"drivegate's own code failed in the candidate's process, which only the candidate could have changed: "
        f"{fault.message}",
        phase,
        error=fault.error,
        traceback=fault.traceback,
    )


def _identity(descriptor: int) -> tuple[int, ...] | None:
    """Return which file a descriptor stands for, since its number may have been given to another one."""
    try:
        status = os.fstat(descriptor)
    except OSError:
        return None
    return status.st_dev, status.st_ino


def _limit_memory(allowance: int) -> None:
    """Let allocations beyond the allowance fail with a MemoryError, where the system can."""
    if not sys.platform.startswith("linux"):
        return
    # Not RLIMIT_AS, which also counts addresses that libraries only reserve, and never use.
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    limit = psutil.Process().memory_info().data + allowance
    resource.setrlimit(
        resource.RLIMIT_DATA, (limit if hard == resource.RLIM_INFINITY else min(limit, hard), hard)
    )
