"""Landlock: a process gives up rights on files, sockets and other processes; no privilege is needed.

A process in a Landlock domain can trace and inspect only processes of its own domain, whoever its user is.
Source: the kernel's documentation, ``userspace-api/landlock``.
"""

import os
import stat
import struct
import sys
from collections.abc import Iterable
from typing import Final

from drivegate.isolation.system_calls import system_call

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


def landlock_version() -> int:
    """Return the version of the kernel's Landlock; 0 if there is none."""
    if not sys.platform.startswith("linux"):
        return 0
    try:
        return system_call("landlock_create_ruleset", None, 0, _VERSION)
    except OSError:
        return 0


def restrict_to(readable: Iterable[str], writable: Iterable[str], *, without_tcp: bool) -> None:
    """Restrict this process, for good and with all that it starts.

    `readable`, `writable`: files and folders that may be read and executed, and those that may also be changed. What
    does not exist is left out. `without_tcp`: true to deny TCP connections. Raises OSError if the kernel has no
    Landlock, or `no_new_privs` is not set.
    """
    version = landlock_version()
    everything = (1 << _FILE_RIGHTS[min(max(version, 1), 5)]) - 1
    attributes = struct.pack(
        "=QQQ",
        everything,
        _TCP if without_tcp and version >= 4 else 0,
        _ABSTRACT_SOCKETS_AND_SIGNALS if version >= 6 else 0,
    )
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
        allowed = rights if stat.S_ISDIR(os.fstat(place).st_mode) else rights & _OF_FILES
        system_call("landlock_add_rule", rules, _PATH_BENEATH, struct.pack("=Qi", allowed, place), 0)
    finally:
        os.close(place)
