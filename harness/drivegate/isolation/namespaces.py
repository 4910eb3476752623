"""Namespaces: a process with a file system, a process table, a network and shared memory of its own.

Without privileges, a user namespace comes first, in which the process may make the others. Many containers and some
distributions forbid that.
"""

import ctypes
import errno
import os
import signal
import socket
import struct
from collections.abc import Iterable
from contextlib import suppress
from fcntl import ioctl
from pathlib import Path
from typing import Final

from drivegate.isolation.system_calls import SYSTEM, control_process, die_with_parent, succeeded, system_call

DEVICES: Final = ("/dev/null", "/dev/zero", "/dev/full", "/dev/random", "/dev/urandom")
"""Devices that every process may use."""
SCRATCH: Final = ("/tmp", "/dev/shm")
"""Folders in memory that only processes of the namespace see."""

# Every system has this folder.
_ROOT: Final = Path("/tmp")

# Numbers of flags and options in linux/sched.h, mount.h, prctl.h, capability.h and if.h.
_MOUNTS, _IPC, _USER, _PROCESSES, _NETWORK = 0x00020000, 0x08000000, 0x10000000, 0x20000000, 0x40000000
_NO_SET_UID, _NO_DEVICES, _NO_EXECUTION, _BIND, _RECURSIVE, _PRIVATE = 2, 4, 8, 4096, 16384, 1 << 18
_DETACH: Final = 2
_AT_WORKING_FOLDER, _AT_RECURSIVE = -100, 0x8000
_SET_NO_NEW_PRIVILEGES, _DROP_BOUND = 38, 24
_CAPABILITIES_VERSION: Final = 0x20080522
# These folders are memory that belongs to no process, so that they need a limit of their own.
_SCRATCH_SIZE: Final = "size=1g,mode=1777"
_GET_FLAGS, _SET_FLAGS, _IS_UP = 0x8913, 0x8914, 1


def enter_process_namespace() -> None:
    """Make a process table for all that this process starts from now on, and start its first process.

    When the first process ends, the kernel kills every process in the table. It ends with this process.

    Raises OSError if the system forbids it.
    """
    if start_process_namespace() == 0:
        _reap_for_ever()


def start_process_namespace() -> int:
    """Make a process table, and fork its first process, which ends with this one; return as `fork` does.

    Raises OSError if the system forbids it.
    """
    _enter_user_namespace()
    succeeded(SYSTEM.unshare(_PROCESSES), "unshare")
    reader, writer = os.pipe()
    first = os.fork()
    if first == 0:
        os.close(reader)
        _end_with_parent(writer)
        return 0
    os.close(writer)
    # Waited for: if this process ended first, nothing would end the other one, which no signal but KILL can end.
    is_ready = os.read(reader, 1)
    os.close(reader)
    if not is_ready:
        raise OSError(errno.ECHILD, os.strerror(errno.ECHILD), "the first process of a table")
    return first


def _end_with_parent(ready: int) -> None:
    try:
        die_with_parent()
        # A parent that has ended before reads nothing, and its number cannot be seen from here.
        os.write(ready, b"1")
    except OSError:
        os._exit(1)
    os.close(ready)


def _enter_user_namespace() -> None:
    """Let this process make other namespaces; root needs none for that where it has all of its rights."""
    # In a container, root may lack the right. A mount namespace that nobody mounts in has no effect.
    if os.getuid() == 0 and SYSTEM.unshare(_MOUNTS) == 0:
        return
    user, group = os.getuid(), os.getgid()
    succeeded(SYSTEM.unshare(_USER), "unshare")
    # Without privileges, the kernel accepts a map of groups only after this (user_namespaces(7)).
    Path("/proc/self/setgroups").write_text("deny", encoding="ascii")
    # The same numbers inside: files keep their owner, and the process does not look like root.
    Path("/proc/self/uid_map").write_text(f"{user} {user} 1", encoding="ascii")
    Path("/proc/self/gid_map").write_text(f"{group} {group} 1", encoding="ascii")


def _reap_for_ever() -> None:
    """Be the first process of a table, and do nothing but reap what is left to it."""
    # An open end of a pipe here would hide from the harness that all others have been closed.
    os.closerange(0, os.sysconf("SC_OPEN_MAX"))
    # Blocked, the signal stays pending while nobody waits for it, so that no end is missed.
    signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGCHLD})
    while True:
        signal.sigwait({signal.SIGCHLD})
        with suppress(ChildProcessError):
            while os.waitpid(-1, os.WNOHANG)[0]:
                continue


def enter_file_system(readable: Iterable[str], writable: Iterable[str]) -> None:
    """Give this process a file system that has only what is listed, and a network without a way out.

    `readable`, `writable`: files and folders that can be read and executed, and those that can also be changed. What
    does not exist is left out. Raises OSError if the system forbids it.
    """
    here = Path.cwd()
    succeeded(SYSTEM.unshare(_MOUNTS | _IPC | _NETWORK), "unshare")
    # Most systems share their mounts with new namespaces, where what follows would show as well.
    _mount(None, "/", None, _RECURSIVE | _PRIVATE)
    # A descriptor shows its file wherever something else is mounted later. A folder comes before what is inside it.
    readable = sorted(_existing(readable), key=lambda path: len(Path(path).parts))
    shown = [(path, os.open(path, os.O_PATH), False) for path in readable]
    # Writable places come last, so that one inside a readable folder covers it.
    shown += [(path, os.open(path, os.O_PATH), True) for path in (*_existing(writable), *DEVICES)]
    _mount("tmpfs", str(_ROOT), "tmpfs", _NO_SET_UID | _NO_DEVICES, "mode=755")
    for place in SCRATCH:
        _below_root(place).mkdir(parents=True, exist_ok=True)
        _mount("tmpfs", str(_below_root(place)), "tmpfs", _NO_SET_UID | _NO_DEVICES, _SCRATCH_SIZE)
    _below_root("/proc").mkdir()
    _mount("proc", str(_below_root("/proc")), "proc", _NO_SET_UID | _NO_DEVICES | _NO_EXECUTION)
    for path, descriptor, is_writable in shown:
        _show(path, descriptor, is_writable=is_writable)
        os.close(descriptor)
    for name, target in (("fd", "fd"), ("stdin", "fd/0"), ("stdout", "fd/1"), ("stderr", "fd/2")):
        _below_root(f"/dev/{name}").symlink_to(f"/proc/self/{target}")
    # Only the root itself: the writable places below are mounts of their own, and stay writable.
    _make_read_only(_ROOT, recursive=False)
    os.chdir(_ROOT)
    # This puts the old root on top of the new one, from where it is detached: "pivot_root(".", ".")" in pivot_root(2).
    system_call("pivot_root", b".", b".")
    succeeded(SYSTEM.umount2(b".", _DETACH), "umount2")
    os.chdir(here if here.is_dir() else "/")
    _start_loopback()


def drop_privileges() -> None:
    """Give up every capability of this process, and the means to get one back."""
    control_process(_SET_NO_NEW_PRIVILEGES, 1)
    # More than any kernel has; the kernel refuses the numbers that it does not know.
    for capability in range(64):
        with suppress(OSError):
            control_process(_DROP_BOUND, capability)
    header = struct.pack("=Ii", _CAPABILITIES_VERSION, 0)
    # Twice the three sets of 32 capabilities each that this version has.
    succeeded(SYSTEM.capset(header, bytes(24)), "capset")


def _existing(paths: Iterable[str]) -> list[str]:
    """Return the paths that exist, each as it is written and as it is without symbolic links."""
    both = [form for path in paths if Path(path).exists() for form in (path, os.path.realpath(path))]
    return list(dict.fromkeys(form for form in both if form != "/"))


def _below_root(path: str) -> Path:
    """Return where a path of the new file system is as long as the old one is there."""
    return _ROOT / path[1:]


def _show(path: str, descriptor: int, *, is_writable: bool) -> None:
    """Mount an open file or folder at its own path in the new file system."""
    target = _below_root(path)
    if Path(f"/proc/self/fd/{descriptor}").is_dir():
        target.mkdir(parents=True, exist_ok=True)
    elif not target.exists():
        target.parent.mkdir(parents=True, exist_ok=True)
        target.touch()
    _mount(f"/proc/self/fd/{descriptor}", str(target), None, _BIND | _RECURSIVE)
    # The kernel ignores this flag in the call that binds.
    if not is_writable:
        _make_read_only(target, recursive=True)


def _make_read_only(target: Path, *, recursive: bool) -> None:
    attributes = struct.pack("=QQQQ", 1 | _NO_SET_UID | (_NO_DEVICES if recursive else 0), 0, 0, 0)
    flags = _AT_RECURSIVE if recursive else 0
    system_call("mount_setattr", _AT_WORKING_FOLDER, os.fsencode(target), flags, attributes, len(attributes))


def _mount(source: str | None, target: str, kind: str | None, flags: int, options: str | None = None) -> None:
    given = [None if text is None else os.fsencode(text) for text in (source, target, kind)]
    data = None if options is None else options.encode()
    succeeded(SYSTEM.mount(*given, ctypes.c_ulong(flags), data), f"mount {target}")


def _start_loopback() -> None:
    """Let the processes of the namespace reach each other at 127.0.0.1."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket, suppress(OSError):
        request = struct.pack("16sH14x", b"lo", 0)
        flags = struct.unpack("16sH14x", ioctl(any_socket, _GET_FLAGS, request))[1]
        ioctl(any_socket, _SET_FLAGS, struct.pack("16sH14x", b"lo", flags | _IS_UP))
