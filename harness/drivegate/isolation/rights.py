"""Rights that a process gives up: on files, sockets and other processes by Landlock, and system calls by seccomp.

A process in a Landlock domain can trace and inspect only processes of its own domain, whoever its user is.
Source: the kernel's documentation, ``userspace-api/landlock``.

Refused calls reach into other processes, make memory that no limit counts, or open parts of the kernel that no
controller needs. Calls that need a privilege are not listed, since the process has none.
"""

import ctypes
import errno
import os
import platform
import stat
import struct
from collections.abc import Iterable
from typing import Final

from drivegate.isolation.system_calls import NUMBERS, control_process, system_call

_VERSION: Final = 1
_PATH_BENEATH: Final = 1

_EXECUTE, _WRITE_FILE, _READ_FILE, _READ_DIR = (1 << bit for bit in range(4))
_TRUNCATE, _IOCTL_DEVICE = 1 << 14, 1 << 15
_OF_FILES: Final = _EXECUTE | _WRITE_FILE | _READ_FILE | _TRUNCATE | _IOCTL_DEVICE
_READING: Final = _EXECUTE | _READ_FILE | _READ_DIR
_FILE_RIGHTS: Final = {1: 13, 2: 14, 3: 15, 4: 15, 5: 16}
"""Number of rights on files of each version; later versions have no more."""
_TCP: Final = 0b11
_ABSTRACT_SOCKETS_AND_SIGNALS: Final = 0b11
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


def restrict_to(readable: Iterable[str], writable: Iterable[str], *, without_tcp: bool) -> None:
    """Restrict this process, for good and with all that it starts.

    `readable`, `writable`: files and folders that may be read and executed, and those that may also be changed. What
    does not exist is left out. `without_tcp`: true to deny TCP connections. Raises OSError if the kernel has no
    Landlock, or `no_new_privs` is not set.
    """
    # A right that a version does not know is refused as an error, so the attributes follow the kernel's version.
    version = system_call("landlock_create_ruleset", None, 0, _VERSION)
    everything = (1 << _FILE_RIGHTS[min(version, 5)]) - 1
    attributes = struct.pack(
        "=QQQ",
        everything,
        _TCP if without_tcp and version >= 4 else 0,
        _ABSTRACT_SOCKETS_AND_SIGNALS if version >= 6 else 0,
    )
    # The structure's length in the kernel's version; versions 4 and 6 have added fields.
    size = 8 if version < 4 else 16 if version < 6 else 24
    rules = system_call("landlock_create_ruleset", attributes[:size], size, 0)
    try:
        for path in readable:
            _allow(rules, path, _READING)
        for path in writable:
            _allow(rules, path, everything)
        system_call("landlock_restrict_self", rules, 0)
    finally:
        os.close(rules)


def _allow(rules: int, path: str, rights: int) -> None:
    """Add a rule for a file, or for a folder with all that is in it."""
    try:
        place = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except OSError:
        return
    try:
        # The kernel refuses a rule that grants rights on folders for a file.
        allowed = rights if stat.S_ISDIR(os.fstat(place).st_mode) else rights & _OF_FILES
        system_call("landlock_add_rule", rules, _PATH_BENEATH, struct.pack("=Qi", allowed, place), 0)
    finally:
        os.close(place)


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
        # Numbers of calls differ by architecture, so that one of another table would pass for an allowed call.
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
        # A process has every capability inside a user namespace that it makes.
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
