"""The inside of a template: a process that has imported what a role needs, and offers copies of itself.

A copy starts in a fraction of the time of a new Python. It is a keeper, and becomes one as a new process does: what it
works on and its environment come from the harness over a connection of its own, which the template never reads. So
a template knows no candidate, and its copies know nothing of each other.
"""

import gc
import json
import os
import signal
import socket
import sys
from collections.abc import Iterable
from contextlib import suppress
from importlib import import_module
from itertools import pairwise
from pathlib import Path
from types import FrameType
from typing import Final

from drivegate.containment.keeper import import_role, keep
from drivegate.isolation.layers import refuse_inspection
from drivegate_models.compilation.cache_folder import NUMBA_VARIABLE

# A worker gets two at most, after the folder and the three standard ones.
FEW: Final = 16
"""Greatest number of descriptors that a copy gets."""
_BLOCK: Final = 65536


def offer_copies(role: str, connection: str, _owner: str) -> None:
    """Import what a role needs, and make a copy for each connection that arrives, until the harness hangs up.

    With it come the names of modules, which are imported as well. What arrives without a connection is a preparation:
    all later copies have its results. In the template this does not return; in a copy it returns as `keep` does.
    """
    names = frozenset(os.environ)
    prepared: list[list[str]] = []
    requests = socket.socket(fileno=int(connection))
    requests.set_inheritable(False)
    import_role(role)
    _require_one_thread()
    if role == "judge":
        # Whoever changed it would change every later judge.
        refuse_inspection()
    # Whoever ordered a copy sees its end by itself.
    signal.signal(signal.SIGCHLD, _reap)
    while True:
        order, received, _, _ = socket.recv_fds(requests, _BLOCK, 1)
        if not order:
            break
        stated = json.loads(order)
        if not received:
            if stated not in prepared:
                prepared.append(stated)
                _prepare(*stated)
            continue
        import_role(role, *stated)
        if os.fork() == 0:
            requests.close()
            _become_keeper(socket.socket(fileno=received[0]), names)
            return
        os.close(received[0])
    requests.close()
    with suppress(ChildProcessError):
        while True:
            os.wait()
    os._exit(0)


def _reap(_number: int, _frame: FrameType | None) -> None:
    with suppress(ChildProcessError):
        while os.waitpid(-1, os.WNOHANG)[0]:
            continue


def _prepare(module: str, function: str, argument: str) -> None:
    # What is wrong shows in the jobs of the copies.
    with suppress(Exception):
        getattr(import_module(module), function)(argument)
    gc.freeze()
    _require_one_thread()


def _require_one_thread() -> None:
    """End this process unless it can be copied: a copy has only the thread that made it.

    A library for linear algebra starts threads when it is imported, and ends them before a process is copied.
    """
    first = os.fork()
    if first == 0:
        os._exit(0)
    with suppress(ChildProcessError):
        os.waitpid(first, 0)
    if len(list(Path("/proc/self/task").iterdir())) != 1:
        os._exit(1)


def _become_keeper(connection: socket.socket, names: frozenset[str]) -> None:
    """Make of a copy what a new process is, and keep what is ordered.

    `names`: variables that the template was started with; those that its imports have set remain.
    """
    # The keeper waits for its worker's status, which the template's handler would take away.
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    os.setsid()
    own = os.pidfd_open(os.getpid())
    socket.send_fds(connection, [str(os.getpid()).encode()], [own])
    os.close(own)
    begin, (folder, *descriptors), _, _ = socket.recv_fds(connection, _BLOCK, FEW)
    order = begin
    while block := connection.recv(_BLOCK):
        order += block
    connection.close()
    os.fchdir(folder)
    for place, descriptor in enumerate(descriptors[:3]):
        os.dup2(descriptor, place)
    given = descriptors[3:]
    _close_all_but(given)
    for descriptor in given:
        os.set_inheritable(descriptor, True)
    words, environment = json.loads(order)
    del order, begin
    for name in names.difference(environment):
        os.environ.pop(name, None)
    os.environ.update(environment)
    _renew_imported()
    keep(*words, *map(str, given))


def _close_all_but(kept: Iterable[int]) -> None:
    """Close all descriptors but these, and those of standard input, output and error."""
    bounds = [2, *sorted(kept), os.sysconf("SC_OPEN_MAX")]
    for before, after in pairwise(bounds):
        if before + 1 < after:
            os.closerange(before + 1, after)


def _renew_imported() -> None:
    """Renew what libraries took from the template: random numbers and a folder. Python renews its own."""
    randomness = sys.modules.get("numpy.random")
    if randomness is not None:
        randomness.seed()
    numba = sys.modules.get("numba")
    if numba is not None:
        numba.config.CACHE_DIR = os.environ[NUMBA_VARIABLE]
