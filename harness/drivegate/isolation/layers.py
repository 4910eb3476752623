"""What isolates a candidate's process from the machine: layers, each of which the kernel enforces.

The strongest that the machine has are used. A result states which.
"""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from functools import cache
from pathlib import Path
from typing import Final, NoReturn

from drivegate.isolation.descendants import adopt_orphans, kill_descendants
from drivegate.isolation.namespaces import (
    DEVICES,
    SCRATCH,
    drop_privileges,
    enter_file_system,
    start_process_namespace,
)
from drivegate.isolation.rights import refuse_calls, restrict_to
from drivegate.isolation.system_calls import control_process, end_with_parent
from drivegate_cases.documents.wording import shown
from drivegate_models.errors import InputError

ISOLATION_VARIABLE: Final = "DRIVEGATE_ISOLATION"
"""Environment variable with the requested isolation; the option ``--isolation`` sets it."""
READ_VARIABLE: Final = "DRIVEGATE_READ"
"""Environment variable with further files and folders that candidates may consist of and read, separated by colons;
the option ``--root`` adds to it."""

# What programs need of the system: libraries, interpreters, time zones and certificates.
_SYSTEM: Final = (
    "/usr",
    "/bin",
    "/sbin",
    "/lib",
    "/lib32",
    "/lib64",
    "/libx32",
    "/opt",
    "/nix",
    "/gnu",
    "/etc/alternatives",
    "/etc/fonts",
    "/etc/group",
    "/etc/hosts",
    "/etc/ld.so.cache",
    "/etc/ld.so.conf",
    "/etc/ld.so.conf.d",
    "/etc/localtime",
    "/etc/nsswitch.conf",
    "/etc/passwd",
    "/etc/ssl/certs",
    "/etc/timezone",
    "/sys/devices/system/cpu",
)


class Isolation(StrEnum):
    AUTO = "auto"
    STRICT = "strict"
    NONE = "none"


class Layer(StrEnum):
    LANDLOCK = "Landlock"
    NAMESPACES = "namespaces"
    REFUSED_CALLS = "seccomp"


# A try starts a new Python, which takes seconds on a busy machine.
_PATIENCE: Final = 20.0
# Number of the option in linux/prctl.h.
_SET_DUMPABLE: Final = 4


@dataclass(frozen=True)
class Places:
    """The files and folders that a process can use."""

    readable: tuple[str, ...]
    """Those that it may read and execute."""
    writable: tuple[str, ...]
    """Those that it may also change."""


def system_places() -> tuple[str, ...]:
    """Return what every program may read, with this Python and its packages."""
    finders = [vars(sys.modules[name]).get("MAPPING") for name in list(sys.modules) if "__editable__" in name]
    packages = [place for mapping in finders if isinstance(mapping, dict) for place in mapping.values()]
    python = (sys.prefix, sys.base_prefix, sys.exec_prefix, sys.base_exec_prefix, *_search_path(), *packages)
    return (*_SYSTEM, *(str(Path(place).absolute()) for place in python if place), *named_roots())


def named_roots() -> tuple[str, ...]:
    """Return the files and folders besides its own that the user lets a candidate consist of, and read."""
    places = os.environ.get(READ_VARIABLE, "").split(os.pathsep)
    return tuple(str(Path(place).absolute()) for place in places if place)


@contextmanager
def roots_named(folders: Sequence[str]) -> Iterator[None]:
    """Name further roots for as long as the context lasts, in this process and in those that it starts."""
    before = os.environ.get(READ_VARIABLE, "")
    with _environment_set(READ_VARIABLE, os.pathsep.join(filter(None, (before, *folders)))):
        yield


def _search_path() -> Iterator[str]:
    """Yield where Python finds packages, without the present folder, which `python -m` puts there."""
    stated = {
        os.path.realpath(place) for place in os.environ.get("PYTHONPATH", "").split(os.pathsep) if place
    }
    needed = {*stated, *(os.path.realpath(Path(file).parents[1]) for file in _own_files())}
    here = str(Path.cwd())
    for place in sys.path:
        if os.path.realpath(place) != here or here in needed:
            yield place


def _own_files() -> Iterator[str]:
    """Yield a file of each of drivegate's packages that a candidate's process imports."""
    for name in ("drivegate", "drivegate_cases", "drivegate_models"):
        file = sys.modules[name].__file__
        assert file is not None, "it is a package with an __init__.py"
        yield file


@contextmanager
def isolation_requested(value: str) -> Iterator[None]:
    """Request an isolation for as long as the context lasts, in this process and in those that it starts."""
    with _environment_set(ISOLATION_VARIABLE, value):
        yield


@contextmanager
def _environment_set(name: str, value: str) -> Iterator[None]:
    before = os.environ.get(name)
    os.environ[name] = value
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(name, None)
        else:
            os.environ[name] = before


def requested_layers() -> tuple[Layer, ...]:
    """Return the layers that isolate candidates: all that this machine has, unless the user wants none.

    Raises InputError if ``strict`` is requested, and the machine lacks a layer.
    """
    requested = os.environ.get(ISOLATION_VARIABLE, Isolation.AUTO)
    if requested not in set(Isolation):
        raise InputError(
            f"the environment variable {ISOLATION_VARIABLE} is {shown(requested)}, but must be "
            "auto, strict or none"
        )
    if requested == Isolation.NONE:
        return ()
    available = available_layers()
    missing = [layer for layer in Layer if layer not in available]
    if requested == Isolation.STRICT and missing:
        raise InputError(
            f"--isolation strict needs {' and '.join(missing)}, which this machine does not allow; on Ubuntu 24.04 "
            "and on GitHub's runners run 'sudo sysctl -w kernel.apparmor_restrict_unprivileged_userns=0', in Docker "
            "add the options --security-opt seccomp=unconfined --security-opt apparmor=unconfined --security-opt "
            "systempaths=unconfined, or take --isolation auto"
        )
    return available


def layers_in_words(layers: Sequence[str]) -> str:
    *others, last = layers or [""]
    listed = " and ".join(filter(None, (", ".join(others), last)))
    return f"isolated by {listed}" if layers else "not isolated"


@cache
def available_layers() -> tuple[Layer, ...]:
    """Find the layers that this machine allows, by trying them in processes that end at once."""
    if not sys.platform.startswith("linux"):
        return ()
    # Most machines allow all of them, and each process delays the first run of a candidate.
    every = tuple(Layer)
    return every if _work(every) else tuple(layer for layer in every if _work((layer,)))


def _work(layers: tuple[Layer, ...]) -> bool:
    words = isolated_command(["true"], layers, Places((), ()))
    try:
        ended = subprocess.run(
            words, stdin=subprocess.DEVNULL, capture_output=True, timeout=_PATIENCE, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return False
    return ended.returncode == 0


def isolated_command(words: Sequence[str], layers: Sequence[Layer], places: Places) -> list[str]:
    """Return the command that runs the given one, isolated, and leaves no process of it.

    `words`: the program, found along ``PATH``, and its arguments. `layers`: what isolates it. It runs in a child of the
    command, which ends as the program does. All of it ends with this process, which has to start it, and at SIGTERM.
    """
    return python_command(
        "drivegate.isolation.layers",
        "become_isolated",
        written_order(layers, places),
        str(os.getpid()),
        *words,
    )


def python_command(module: str, function: str, *words: str) -> list[str]:
    """Return the command that calls a function with words, in a Python with the import path of this one."""
    call = (
        "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
        f"from {module} import {function}; {function}(*sys.argv[2:])"
    )
    # The import path is that of this process, whatever the folder holds in which the other one starts.
    paths = json.dumps([str(Path(place).absolute()) for place in sys.path])
    return [sys.executable, "-P", "-c", call, paths, *words]


def written_order(layers: Sequence[Layer], places: Places) -> str:
    """Write what isolates a process, and what it can use next to what every program may read."""
    readable = (*system_places(), *places.readable) if layers else ()
    return json.dumps([list(layers), readable, places.writable])


def read_order(order: str) -> tuple[tuple[Layer, ...], Places]:
    """Read what `written_order` wrote."""
    layers, readable, writable = json.loads(order)
    return tuple(map(Layer, layers)), Places(tuple(readable), tuple(writable))


def become_isolated(order: str, parent: str, *words: str) -> None:
    """Execute a program in a child that isolates itself; this is the inside of `isolated_command`."""
    adopt_orphans()
    # Killed at once, this process could not end what has left the process group, as `setsid` does.
    signal.signal(signal.SIGTERM, _end_all)
    end_with_parent(int(parent), signal.SIGTERM)
    layers, places = read_order(order)
    keeper = os.getpid()
    has_own_table = Layer.NAMESPACES in layers
    child = start_process_namespace() if has_own_table else os.fork()
    if child:
        _end_as(child, _end_all)
    if has_own_table:
        # The first process is the parent of the program: the kernel waits in its end for all to be reaped, and a
        # container often has nobody who would reap a program that lost another parent.
        program = os.fork()
        if program:
            _end_as(program)
    else:
        end_with_parent(keeper)
    isolate(layers, places)
    # Python handles or ignores these, and the program would too.
    for handled in (signal.SIGPIPE, signal.SIGXFSZ, signal.SIGTERM):
        signal.signal(handled, signal.SIG_DFL)
    os.execvp(words[0], words)


def _end_all(status: int, _frame: object = None) -> NoReturn:
    kill_descendants()
    os._exit(status)


def _end_as(process: int, end: Callable[[int], NoReturn] = os._exit) -> NoReturn:
    """Wait for a child, reap all others, and end as it did."""
    ended, status = 0, 0
    while ended != process:
        ended, status = os.waitpid(-1, 0)
    code = os.waitstatus_to_exitcode(status)
    # A shell reports the end by a signal in the same way.
    end(code if code >= 0 else 128 - code)


def refuse_inspection() -> None:
    """Let no other process without privileges trace this one, or read its memory and environment, where Linux can."""
    if sys.platform.startswith("linux"):
        control_process(_SET_DUMPABLE, 0)


def isolate(layers: Sequence[Layer], places: Places) -> None:
    """Isolate this process, for good and with all that it starts.

    `layers`: what isolates it; nothing is done without any. Raises OSError if the machine does not allow a layer.
    """
    if not layers:
        return
    # The order matters: mounting needs capabilities, which are dropped next. Landlock and seccomp require
    # `no_new_privs`, which `drop_privileges` sets. Seccomp refuses calls that the others make, so it comes last.
    has_own_system = Layer.NAMESPACES in layers
    if has_own_system:
        enter_file_system(places.readable, places.writable)
    drop_privileges()
    if Layer.LANDLOCK in layers:
        scratch = SCRATCH if has_own_system else ()
        # In the namespace, /dev has what is listed alone; elsewhere it has the terminals too, and what is typed there.
        devices = ("/dev",) if has_own_system else ()
        restrict_to(
            (*places.readable, "/proc", *devices),
            (*places.writable, *DEVICES, *scratch),
            # A network namespace has no way out already, and its loopback device is to stay usable.
            without_tcp=not has_own_system,
        )
    if Layer.REFUSED_CALLS in layers:
        refuse_calls(without_sockets=not has_own_system)
