"""System calls that a candidate's process is refused, by a seccomp filter.

They reach into other processes, make memory that no limit counts, or open parts of the kernel that no controller needs.
Calls that need a privilege are not listed, since the process has none.
"""

import ctypes
import errno
import os
import platform
import struct
from typing import Final

from drivegate.isolation.system_calls import NUMBERS, control_process

REFUSED: Final = (
    "ptrace",
    "process_vm_readv",
    "process_vm_writev",
    "process_madvise",
    "pidfd_getfd",
    "kcmp",
    "io_uring_setup",
    "io_uring_enter",
    "io_uring_register",
    "bpf",
    "perf_event_open",
    "userfaultfd",
    "add_key",
    "request_key",
    "keyctl",
    "mount",
    "umount2",
    "pivot_root",
    "open_tree",
    "move_mount",
    "fsopen",
    "mount_setattr",
    "open_by_handle_at",
    "unshare",
    "setns",
    "memfd_create",
    "memfd_secret",
    "shmget",
    "msgget",
    "semget",
)
"""Calls that are refused whatever their arguments are."""

_ARCHITECTURES: Final = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
_X32: Final = 0x40000000
_NEW_USER: Final = 0x10000000

# A filter reads struct seccomp_data: number, architecture, address, then six arguments of 8 bytes.
_NUMBER, _ARCHITECTURE, _FIRST_ARGUMENT = 0, 4, 16
_LOAD, _IS_EQUAL, _IS_AT_LEAST, _HAS_BITS, _ANSWER = 0x20, 0x15, 0x35, 0x45, 0x06
_ALLOW: Final = 0x7FFF0000
_REFUSE: Final = 0x00050000 | errno.EPERM
_UNKNOWN: Final = 0x00050000 | errno.ENOSYS
_SET_SECCOMP, _FILTER = 22, 2


def refuse_calls(*, without_sockets: bool) -> None:
    """Install the filter in this process, for good and with all that it starts.

    Raises OSError if the kernel refuses, as it does without `no_new_privs`, or the processor has no filter here.
    """
    if platform.machine() not in _ARCHITECTURES:
        raise OSError(errno.ENOSYS, os.strerror(errno.ENOSYS), "seccomp")
    program = _program(without_sockets=without_sockets)
    code = ctypes.create_string_buffer(program)
    header = struct.pack("HP", len(program) // 8, ctypes.addressof(code))
    described = ctypes.create_string_buffer(header)
    control_process(_SET_SECCOMP, _FILTER, ctypes.addressof(described))


def _program(*, without_sockets: bool) -> bytes:
    """Return the filter as instructions of the classic BPF machine."""
    refused = [*REFUSED, *(["socket"] if without_sockets else [])]
    steps = [
        _step(_LOAD, _ARCHITECTURE),
        _step(_IS_EQUAL, _ARCHITECTURES[platform.machine()], 1, 0),
        _step(_ANSWER, _REFUSE),
        _step(_LOAD, _NUMBER),
        # The calls of another table of numbers, which x86-64 has.
        _step(_IS_AT_LEAST, _X32, 0, 1),
        _step(_ANSWER, _REFUSE),
        # Flags of clone3 are in memory, where a filter cannot look; libraries then use clone.
        _step(_IS_EQUAL, NUMBERS["clone3"], 0, 1),
        _step(_ANSWER, _UNKNOWN),
    ]
    for name in refused:
        steps += [_step(_IS_EQUAL, NUMBERS[name], 0, 1), _step(_ANSWER, _REFUSE)]
    steps += [
        _step(_IS_EQUAL, NUMBERS["clone"], 0, 4),
        _step(_LOAD, _FIRST_ARGUMENT),
        _step(_HAS_BITS, _NEW_USER, 0, 1),
        _step(_ANSWER, _REFUSE),
        _step(_ANSWER, _ALLOW),
        # Limits of another process; 0 is the calling one.
        _step(_IS_EQUAL, NUMBERS["prlimit64"], 0, 3),
        _step(_LOAD, _FIRST_ARGUMENT),
        _step(_IS_EQUAL, 0, 1, 0),
        _step(_ANSWER, _REFUSE),
        _step(_ANSWER, _ALLOW),
    ]
    return b"".join(steps)


def _step(code: int, value: int, if_true: int = 0, if_false: int = 0) -> bytes:
    return struct.pack("=HBBI", code, if_true, if_false, value)
