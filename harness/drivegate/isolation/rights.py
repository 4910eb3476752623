"""Rights that a process gives up: on files, sockets and other processes by Landlock, and system calls by seccomp.

A process in a Landlock domain can trace and inspect only processes of its own domain, whoever its user is.
Source: the kernel's documentation, ``userspace-api/landlock``.

Refused calls reach into other processes, make memory that no limit counts, or open parts of the kernel that no
controller needs. Calls that need a privilege are not listed, since the process has none. Landlock has no rule for
priority, scheduling and processors of other processes of the same user, nor for leases, by which a process that can
only read a file delays everybody who opens it.
"""

import ctypes
import errno
import os
import platform
import stat
import struct
from collections.abc import Iterable
from types import MappingProxyType
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
    "mq_open",
    "syslog",
)
"""Calls that are refused whatever their arguments are."""

OF_THE_CALLER: Final = MappingProxyType(
    {
        "prlimit64": (0,),
        "setpriority": (0, 1),
        "sched_setaffinity": (0,),
        "sched_setparam": (0,),
        "sched_setscheduler": (0,),
        "sched_setattr": (0,),
        "ioprio_set": (1,),
    }
)
"""Calls that change a process, and their arguments that must be 0: the calling process, and no group or user."""

# Numbers in linux/fcntl.h.
_SET_LEASE, _NOTIFY = 1024, 1026
# Numbers in linux/socket.h: local sockets, and the protocols of the internet, which end at the loopback device.
_LOCAL, _INTERNET, _INTERNET_6 = 1, 2, 10

_ARCHITECTURES: Final = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}
_X32: Final = 0x40000000
_NEW_USER: Final = 0x10000000

# A filter reads struct seccomp_data: number, architecture, address, then six arguments of 8 bytes.
_NUMBER, _ARCHITECTURE, _ARGUMENTS, _ARGUMENT_SIZE = 0, 4, 16, 8
_LOAD, _IS_EQUAL, _IS_AT_LEAST, _HAS_BITS, _ANSWER = 0x20, 0x15, 0x35, 0x45, 0x06
_ALLOW: Final = 0x7FFF0000
_REFUSE: Final = 0x00050000 | errno.EPERM
_UNKNOWN: Final = 0x00050000 | errno.ENOSYS
_NO_FAMILY: Final = 0x00050000 | errno.EAFNOSUPPORT
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
    families = () if without_sockets else (_LOCAL, _INTERNET, _INTERNET_6)
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
    for name in REFUSED:
        steps += _of_call(name, [_step(_ANSWER, _REFUSE)])
    # A process has every capability inside a user namespace that it makes.
    steps += _of_call("clone", [_load(0), _step(_HAS_BITS, _NEW_USER, 0, 1), _step(_ANSWER, _REFUSE)])
    for command in (_SET_LEASE, _NOTIFY):
        steps += _of_call("fcntl", [_load(1), _step(_IS_EQUAL, command, 0, 1), _step(_ANSWER, _REFUSE)])
    for name, arguments in OF_THE_CALLER.items():
        for argument in arguments:
            steps += _of_call(name, _required(argument, (0,), _REFUSE))
    # Of every other family, such as that which reaches the host of a virtual machine, a filter would know nothing.
    steps += _of_call("socket", _required(0, families, _NO_FAMILY if families else _REFUSE))
    steps += _of_call("socketpair", _required(0, (_LOCAL,), _NO_FAMILY))
    return b"".join((*steps, _step(_ANSWER, _ALLOW)))


def _of_call(name: str, steps: list[bytes]) -> list[bytes]:
    """Return steps for one call, after which the number of the call is loaded again for the next ones."""
    steps = [*steps, _step(_LOAD, _NUMBER)]
    return [_step(_IS_EQUAL, NUMBERS[name], 0, len(steps)), *steps]


def _load(argument: int) -> bytes:
    # The lower half; the kernel takes all of these arguments as numbers of 32 bits.
    return _step(_LOAD, _ARGUMENTS + argument * _ARGUMENT_SIZE)


def _required(argument: int, values: tuple[int, ...], otherwise: int) -> list[bytes]:
    """Return steps that answer unless an argument has one of the values."""
    found = [_step(_IS_EQUAL, value, len(values) - place, 0) for place, value in enumerate(values)]
    return [_load(argument), *found, _step(_ANSWER, otherwise)]


def _step(code: int, value: int, if_true: int = 0, if_false: int = 0) -> bytes:
    return struct.pack("=HBBI", code, if_true, if_false, value)
