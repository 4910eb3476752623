"""Shared memory and semaphores of a candidate's own, which go with its last process, where Linux allows it."""

import ctypes
import os
import sys
from contextlib import suppress
from pathlib import Path

_NEW_MOUNTS, _NEW_IPC, _NEW_USER = 0x00020000, 0x08000000, 0x10000000
_PRIVATE_FROM_ROOT = 0x40000 | 0x4000
_PLACE = b"/dev/shm"
_SIZE = b"size=1g,mode=1777"


def keep_shared_memory_private() -> bool:
    """Give this process and those that come from it a `/dev/shm` of their own; tell whether that could be done."""
    if not sys.platform.startswith("linux"):
        return False
    system = ctypes.CDLL(None, use_errno=True)
    user, group = os.getuid(), os.getgid()
    if system.unshare(_NEW_MOUNTS | _NEW_IPC) != 0:
        if system.unshare(_NEW_USER | _NEW_MOUNTS | _NEW_IPC) != 0:
            return False
        with suppress(OSError):
            Path("/proc/self/setgroups").write_text("deny", encoding="ascii")
            Path("/proc/self/uid_map").write_text(f"{user} {user} 1", encoding="ascii")
            Path("/proc/self/gid_map").write_text(f"{group} {group} 1", encoding="ascii")
    if system.mount(b"none", b"/", None, ctypes.c_ulong(_PRIVATE_FROM_ROOT), None) != 0:
        return False
    return bool(system.mount(b"tmpfs", _PLACE, b"tmpfs", ctypes.c_ulong(0), _SIZE) == 0)
