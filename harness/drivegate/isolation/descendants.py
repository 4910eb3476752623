"""Ending all processes that came from this one, also those that made a session of their own."""

import os
import signal
import sys
import time
from contextlib import suppress
from pathlib import Path
from typing import Final

from drivegate.isolation.system_calls import control_process

# Number of the option in linux/prctl.h.
_SET_CHILD_SUBREAPER: Final = 36
# A process that waits for a device cannot be killed, and must not delay the verdict for ever.
_PATIENCE: Final = 10.0


def adopt_orphans() -> None:
    """Become the parent, on Linux, of all later descendants whose own parents end."""
    if sys.platform.startswith("linux"):
        control_process(_SET_CHILD_SUBREAPER, 1)


def kill_descendants(leader: int | None = None) -> int | None:
    """Kill all descendants, and return the exit status of one that leads a process group, if it is not reaped yet.

    A process that is killed while it starts another one leaves it to this one, hence the repetition.
    """
    status = None
    if leader is not None:
        with suppress(ProcessLookupError, PermissionError):
            os.killpg(leader, signal.SIGKILL)
    until = time.monotonic() + _PATIENCE
    while time.monotonic() < until:
        # This raises ChildProcessError once no child is left: all descendants are below one.
        try:
            while (ended := os.waitpid(-1, os.WNOHANG))[0]:
                if ended[0] == leader:
                    status = os.waitstatus_to_exitcode(ended[1])
        except ChildProcessError:
            break
        for process in _descendants(os.getpid()):
            with suppress(ProcessLookupError, PermissionError):
                os.kill(process, signal.SIGKILL)
        # Killed children need a moment to end.
        time.sleep(0.002)
    return status


def _descendants(ancestor: int) -> list[int]:
    """Find the processes that came from one, where the system lists them; zombies among them."""
    children: dict[int, list[int]] = {}
    for place in Path("/proc").glob("[0-9]*/stat"):
        with suppress(OSError, ValueError, IndexError):
            # The name, in parentheses, may hold anything; the state and the parent's id follow its end.
            parent = int(place.read_bytes().rpartition(b")")[2].split()[1])
            children.setdefault(parent, []).append(int(place.parent.name))
    found = list(children.get(ancestor, ()))
    for process in found:
        found.extend(children.get(process, ()))
    return found
