"""Linux system calls that Python and the C library do not offer, or offer only from a later version on."""

from __future__ import annotations

import ctypes
import os
import platform
import signal
import sys
from contextlib import suppress
from pathlib import Path
from typing import Final

# Numbers from 424 on are the same on every architecture; those below differ.
_ARCHITECTURES: Final = ("x86_64", "aarch64")
_BY_ARCHITECTURE: Final = {
    "shmget": (29, 194),
    "socket": (41, 198),
    "socketpair": (53, 199),
    "clone": (56, 220),
    "semget": (64, 190),
    "msgget": (68, 186),
    "fcntl": (72, 25),
    "ptrace": (101, 117),
    "syslog": (103, 116),
    "setpriority": (141, 140),
    "sched_setparam": (142, 118),
    "sched_setscheduler": (144, 119),
    "pivot_root": (155, 41),
    "mount": (165, 40),
    "umount2": (166, 39),
    "sched_setaffinity": (203, 122),
    "mq_open": (240, 180),
    "add_key": (248, 217),
    "request_key": (249, 218),
    "keyctl": (250, 219),
    "ioprio_set": (251, 30),
    "unshare": (272, 97),
    "perf_event_open": (298, 241),
    "prlimit64": (302, 261),
    "open_by_handle_at": (304, 265),
    "setns": (308, 268),
    "process_vm_readv": (310, 270),
    "process_vm_writev": (311, 271),
    "kcmp": (312, 272),
    "sched_setattr": (314, 274),
    "memfd_create": (319, 279),
    "bpf": (321, 280),
    "userfaultfd": (323, 282),
}
_COMMON: Final = {
    "io_uring_setup": 425,
    "io_uring_enter": 426,
    "io_uring_register": 427,
    "open_tree": 428,
    "move_mount": 429,
    "fsopen": 430,
    "clone3": 435,
    "pidfd_getfd": 438,
    "process_madvise": 440,
    "mount_setattr": 442,
    "landlock_create_ruleset": 444,
    "landlock_add_rule": 445,
    "landlock_restrict_self": 446,
    "memfd_secret": 447,
}

NUMBERS: Final = _COMMON | {
    name: number
    for name, numbers in _BY_ARCHITECTURE.items()
    for architecture, number in zip(_ARCHITECTURES, numbers, strict=True)
    if architecture == platform.machine()
}
"""Number of each system call on this machine; without most of them on an architecture that is not listed."""

_SET_DEATH_SIGNAL: Final = 1

SYSTEM: Final = ctypes.CDLL(None, use_errno=True)
"""The C library, whose functions set `errno`."""


def system_call(name: str, *arguments: int | bytes | None) -> int:
    """Make a system call, and return its result.

    Raises OSError if the call fails.
    """
    given = [ctypes.c_long(a) if isinstance(a, int) else ctypes.c_char_p(a) for a in arguments]
    SYSTEM.syscall.restype = ctypes.c_long
    return succeeded(SYSTEM.syscall(ctypes.c_long(NUMBERS[name]), *given), name)


def succeeded(result: int, name: str) -> int:
    """Return the result of a C function, or raise an `OSError` if it is negative."""
    if result < 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number), name)
    return int(result)


def die_with_parent(by: int = signal.SIGKILL) -> None:
    """Have the kernel send this process a signal when its parent ends."""
    control_process(_SET_DEATH_SIGNAL, by)


def control_process(option: int, *arguments: int) -> int:
    """Call `prctl`."""
    four = (*arguments, 0, 0, 0, 0)[:4]
    return succeeded(SYSTEM.prctl(option, *map(ctypes.c_ulong, four)), "prctl")


def end_with_parent(parent: int, by: int = signal.SIGKILL) -> None:
    """Ask Linux to end this process by a signal when its parent dies, also from within an endless loop.

    Elsewhere the process ends when it next waits for a message.
    """
    if sys.platform.startswith("linux"):
        die_with_parent(by)
    # A parent outside of this process's table has the number 0.
    # Looked at after the request: a parent that ended before it sends no signal.
    if os.getppid() not in (parent, 0):
        os._exit(1)


def die_first() -> None:
    """Have the system kill this process, and those that it starts, before others where memory is short."""
    with suppress(OSError):
        Path("/proc/self/oom_score_adj").write_text("500", encoding="ascii")
