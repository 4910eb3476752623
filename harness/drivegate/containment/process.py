"""The inside of a worker process: it loads one candidate, then does jobs until its parent hangs up."""

import faulthandler
import os
import pickle
import resource
import signal
import sys
import traceback
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from multiprocessing.connection import Connection
from typing import Any

import psutil

from drivegate.candidates.fault import CandidateFault, Fault, Phase, exception_fault
from drivegate.containment.messages import (
    LOST_CONNECTION,
    Broken,
    Faulted,
    Finished,
    Job,
    LoadedCandidate,
    Ready,
    Refused,
    Reply,
    Setup,
)
from drivegate.containment.parent_death import end_with_parent
from drivegate.containment.shared_progress import Activity, SharedProgress
from drivegate_models.errors import InputError

STACK_SIGNAL = signal.SIGUSR1
"""Signal at which a worker process prints the Python stack of its threads."""


def main(connection: int, progress: int, parent: int) -> None:
    """Serve the parent process."""
    end_with_parent(parent)
    # A check leaves nothing beside the candidate's sources.
    sys.dont_write_bytecode = True
    faulthandler.enable()
    faulthandler.register(STACK_SIGNAL, all_threads=True)
    for descriptor in (connection, progress):
        os.set_inheritable(descriptor, False)
    channel: Connection[Any, Any] = Connection(connection)
    try:
        _serve(channel, SharedProgress(progress), _identity(connection))
    except (EOFError, BrokenPipeError, ConnectionResetError):
        return


def _serve(
    channel: "Connection[Any, Any]", progress: SharedProgress, identity: tuple[int, ...] | None
) -> None:
    process = os.getpid()
    setup: Setup = channel.recv()
    _limit_memory(setup.memory_limit)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    loaded = LoadedCandidate(setup.candidate, setup.load, progress)
    reply = _reply_of(partial(_first_load, loaded), progress)
    while True:
        if os.getpid() != process:
            # The candidate made a copy of the process, and the copy came back from the candidate's code.
            os._exit(0)
        if _identity(channel.fileno()) != identity:
            os._exit(LOST_CONNECTION)
        progress.enter(Activity.WAITING)
        _send(channel, reply)
        message = channel.recv_bytes()
        progress.enter(Activity.PREPARING)
        reply = _reply_of(partial(_finish, loaded, message), progress)


def _identity(descriptor: int) -> tuple[int, ...] | None:
    """Tell which file a descriptor stands for, since its number may have been given to another one."""
    try:
        status = os.fstat(descriptor)
    except OSError:
        return None
    return status.st_dev, status.st_ino


def _first_load(loaded: LoadedCandidate) -> Reply:
    loaded.controller()
    return Ready()


def _finish(loaded: LoadedCandidate, message: bytes) -> Reply:
    job: Job[Any] = pickle.loads(message)
    return Finished(job.target(loaded, job.payload))


def _reply_of(work: Callable[[], Reply], progress: SharedProgress) -> Reply:
    """Do something and turn each way in which it can end into a message."""
    try:
        return work()
    except CandidateFault as error:
        return Faulted(_with_step(error.fault, progress))
    except MemoryError as error:
        phase: Phase = "loading" if progress.activity is Activity.LOADING else "step"
        return Faulted(_with_step(exception_fault(error, phase), progress))
    except InputError as error:
        return Refused(str(error))
    except Exception:
        return Broken(traceback.format_exc())


def _with_step(fault: Fault, progress: SharedProgress) -> Fault:
    if fault.phase != "step" or fault.step is not None:
        return fault
    return replace(fault, step=max(int(progress.steps[0]) - 1, 0))


def _send(channel: "Connection[Any, Any]", reply: Reply) -> None:
    try:
        message = pickle.dumps(reply, pickle.HIGHEST_PROTOCOL)
    except Exception:
        message = pickle.dumps(Broken(traceback.format_exc()), pickle.HIGHEST_PROTOCOL)
    channel.send_bytes(message)


def _limit_memory(allowance: int) -> None:
    """Let allocations beyond the allowance fail with a MemoryError, where the system can."""
    if not sys.platform.startswith("linux"):
        return
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    limit = psutil.Process().memory_info().data + allowance
    resource.setrlimit(
        resource.RLIMIT_DATA, (limit if hard == resource.RLIM_INFINITY else min(limit, hard), hard)
    )
