"""The memory that this machine gives: what limits it, the workers that it suffices for, and how its want shows.

A candidate may allocate 4 GiB. Where the machine gives less, a process that ends for want of memory shows nothing about
the candidate.
"""

from __future__ import annotations

import os
import re
import resource
import signal
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Final

import psutil

from drivegate.candidates.fault import Fault
from drivegate_models.errors import OutOfMemory

MEBIBYTE: Final = 2**20
BASE_BYTES: Final = 460 * MEBIBYTE
"""Memory of a check without its workers, once kernels are compiled: the command, its templates, and the longest run."""
WORKER_BYTES: Final = 200 * MEBIBYTE
"""Further memory of each worker: a judge and a candidate's process, without what the candidate itself allocates."""
LEAST_BYTES: Final = 500 * MEBIBYTE
"""Memory without which no check ends: much of what processes map from files may be read again and again."""
_NEAR: Final = 256 * MEBIBYTE
"""Free memory with which a process may end at any allocation."""
_CONTROL_GROUPS: Final = Path("/sys/fs/cgroup")
_PROC: Final = Path("/proc")
_LIMITS: Final = ("memory.max", "memory.limit_in_bytes")
_KILLS: Final = (("memory.events", "oom_kill "), ("memory.oom_control", "oom_kill "))
_SAID: Final = re.compile(
    r"cannot allocate memory|bad_alloc|out of memory|failed to map segment|MemoryError", re.IGNORECASE
)
"""What a process prints, or an exception says, that has been refused memory."""


def _control_groups() -> Iterator[Path]:
    """List the folders of this process's control groups that govern memory, each before those around it."""
    with suppress(OSError):
        for line in (_PROC / "self" / "cgroup").read_text(encoding="utf-8").splitlines():
            _, controllers, path = line.split(":", 2)
            if controllers and "memory" not in controllers.split(","):
                continue
            root = _CONTROL_GROUPS / "memory" if controllers else _CONTROL_GROUPS
            own = root / path.lstrip("/")
            yield from (folder for folder in (own, *own.parents) if folder.is_relative_to(root))


def memory_limit() -> int:
    """Return the least of the machine's memory and the limits of the control groups of this process (bytes)."""
    limits = [psutil.virtual_memory().total]
    for folder in _control_groups():
        for name in _LIMITS:
            with suppress(OSError, ValueError):
                limits.append(int((folder / name).read_text(encoding="ascii")))
    return min(limits)


def killed_for_memory() -> int:
    """Count the processes that the system has killed for want of memory: of this control group, else of the machine."""
    for folder in _control_groups():
        for name, key in _KILLS:
            found = _number_after(folder / name, key)
            if found is not None:
                return found
    return _number_after(_PROC / "vmstat", "oom_kill ") or 0


def _number_after(file: Path, key: str) -> int | None:
    with suppress(OSError, ValueError):
        for line in file.read_text(encoding="ascii").splitlines():
            if line.startswith(key):
                return int(line.removeprefix(key))
    return None


def usual_workers() -> int:
    """Return the workers that are started where the user names no number: as many as processors and memory allow."""
    affordable = (memory_limit() - BASE_BYTES) // WORKER_BYTES
    return max(min(os.cpu_count() or 1, affordable), 1)


def require_memory() -> None:
    """Refuse to begin where the memory does not suffice for a single worker."""
    if memory_limit() < LEAST_BYTES:
        raise lack_of_memory("there is too little to begin")


def lack_of_memory(what: str) -> OutOfMemory:
    """Describe that the machine's memory does not suffice, with what is needed."""
    base, each, limit = (round(size / MEBIBYTE) for size in (BASE_BYTES, WORKER_BYTES, memory_limit()))
    reserved = _address_limit()
    here = f"{limit} MB here"
    if reserved is not None:
        here += f", and {round(reserved / MEBIBYTE)} MB of addresses or data for each process (ulimit -v, ulimit -d)"
    return OutOfMemory(
        f"the machine has too little memory, which is no verdict on a candidate: {what}; drivegate needs about {base} "
        f"MB, {each} MB for each worker, and what the candidate allocates, of {here}; give it more, or name fewer "
        "workers with --workers"
    )


def _address_limit() -> int | None:
    """Return the least limit of a process's addresses or data (bytes); None without any."""
    limits = [
        value
        for which in (resource.RLIMIT_AS, resource.RLIMIT_DATA)
        for value in resource.getrlimit(which)[:1]
        if value != resource.RLIM_INFINITY
    ]
    return min(limits, default=None)


def free_memory_of(process: int) -> int:
    """Return what limits of the system leave a process to allocate (bytes)."""
    free = [psutil.virtual_memory().total + psutil.swap_memory().total]
    with suppress(psutil.Error, OSError, AttributeError):
        used = psutil.Process(process).memory_info()
        for which, size in ((resource.RLIMIT_AS, used.vms), (resource.RLIMIT_DATA, used.data)):
            # The candidate's process has hard limits like this one, and lowers one of the others itself.
            limit = resource.getrlimit(which)[1]
            soft = resource.getrlimit(which)[0]
            least = min((value for value in (soft, limit) if value != resource.RLIM_INFINITY), default=None)
            if least is not None:
                free.append(max(least - size, 0))
    return min(free)


def is_for_memory(fault: Fault, free: int, allowed: int) -> bool:
    """Return True if a fault may come from a machine that gives less than a candidate is allowed to allocate.

    `free`: what the machine's limits left the candidate's process at its start (bytes). `allowed`: what it may allocate
    (bytes).
    """
    if free >= allowed:
        return False
    says = _SAID.search(f"{fault.error} {fault.message} {fault.traceback}") is not None
    # A null pointer from an allocation that nobody checked.
    return says or (
        free < _NEAR and fault.error in (signal.SIGSEGV.name, signal.SIGABRT.name, signal.SIGBUS.name)
    )
