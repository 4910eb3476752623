"""Attacks on the machine that checks a candidate, each carried out for real by code in the candidate's process.

``python -m tests.harness.containment.attacks`` prints the table of docs/containment.md, as root: an attack is prevented
if neither root's candidate nor an ordinary user's does it. ``--json LEVEL`` prints what is done as this user.
"""

from __future__ import annotations

import json
import os
import re
import resource
import select
import signal
import socket
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from textwrap import dedent, indent

import psutil
from tests.harness.candidates.native.linker_plugin import with_plugin

from drivegate.candidates.fault import Fault
from drivegate.candidates.native.bounded_command import Bounds, run_bounded
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.candidate_isolation import own_places
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.isolation.layers import Layer, Places, available_layers, isolated_command
from drivegate.isolation.system_calls import NUMBERS, SYSTEM
from drivegate_models.compilation import cache_lock
from drivegate_models.compilation.kernels import required_cache_folder
from drivegate_models.errors import InputError

LEVELS: dict[str, tuple[Layer, ...]] = {
    "all layers": tuple(Layer),
    "without namespaces": (Layer.LANDLOCK, Layer.REFUSED_CALLS),
    "none": (),
}
"""Each level of isolation in the table, and its layers."""
ORDINARY = "none, ordinary user"
"""The last column: what an ordinary user's candidate does without isolation, where that of root does all."""

_SECRET = "the-secret-of-this-machine"

# Each attack runs in a process of its own, which ends with this status if it has reached its aim.
_PRELUDE = """
import ctypes, fcntl, json, mmap, os, resource, signal, socket, struct, subprocess, sys, time
from pathlib import Path
scene = json.loads({scene!r})
victim, folder, secret = scene["victim"], Path(scene["folder"]), scene["secret"]
system = ctypes.CDLL(None, use_errno=True)
def call(result):
    if result < 0:
        raise OSError(ctypes.get_errno(), os.strerror(ctypes.get_errno()))
    return result
def syscall(number, *arguments):
    return call(system.syscall(ctypes.c_long(number), *map(ctypes.c_long, arguments)))
def aim(is_reached=True):
    if is_reached:
        os._exit(7)
reached = []
"""
_EACH = """
child = os.fork()
if child == 0:
    try:
        signal.alarm(5)
{code}
    except BaseException:
        pass
    os._exit(0)
if os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]) == 7:
    reached.append({number})
"""
_CANDIDATE = """
raise RuntimeError("reached " + " ".join(map(str, reached)))
class Mine:
    pass
"""


@dataclass(frozen=True)
class Scene:
    """The machine, as the attacks find it."""

    victim: subprocess.Popen[bytes]
    """A process of the user, such as the harness, with a secret in its environment."""
    folder: Path
    """A folder of the user's, with the file `result.json`."""
    candidate: Path
    """The folder of the candidate."""
    kernels: Path
    """The folder of compiled kernels."""
    sockets: dict[str, socket.socket]
    """A socket of each kind, at which somebody could be heard."""
    terminal: str
    """A terminal of the user's, at which somebody types."""

    def state_of_victim(self) -> str:
        """Return the state that the system reports of the victim, a letter; empty if it is gone."""
        with suppress(OSError):
            return (
                Path(f"/proc/{self.victim.pid}/stat")
                .read_text(encoding="ascii")
                .rpartition(")")[2]
                .split()[0]
            )
        return ""


@dataclass(frozen=True)
class Attack:
    """One attack."""

    name: str
    """What the candidate does."""
    code: str
    """The code that does it; it calls `aim` when it has seen that it reached its aim."""
    is_done: Callable[[Scene], bool] = lambda scene: False
    """Returns True if the machine shows that it was done."""


def _changed(name: str) -> Callable[[Scene], bool]:
    """Return a predicate: a file of the user's is there and is not as it was."""
    return lambda scene: (scene.folder / name).exists() and (scene.folder / name).read_text() != "mine"


def _heard(name: str) -> Callable[[Scene], bool]:
    """Return a predicate: somebody has reached a socket."""
    return lambda scene: bool(select.select([scene.sockets[name]], [], [], 0)[0])


ATTACKS = (
    # Files of the user's.
    Attack("reads a file of yours", 'aim(secret in (folder / "secret.txt").read_text())'),
    Attack("lists a folder of yours", "aim(os.listdir(folder) != [])"),
    Attack("overwrites a file of yours", '(folder / "overwritten").write_text("x")', _changed("overwritten")),
    Attack(
        "appends to a file of yours",
        'file = open(folder / "appended", "a"); file.write("x"); file.close()',
        _changed("appended"),
    ),
    Attack("truncates a file of yours", 'os.truncate(folder / "truncated", 0)', _changed("truncated")),
    Attack("makes a file in a folder of yours", '(folder / "new").write_text("x")', _changed("new")),
    Attack(
        "deletes a file of yours",
        'os.unlink(folder / "deleted")',
        lambda scene: not (scene.folder / "deleted").exists(),
    ),
    Attack(
        "renames a file over another",
        'os.rename(folder / "moved", folder / "replaced")',
        lambda scene: not (scene.folder / "moved").exists(),
    ),
    Attack(
        "links a file of yours into its own folder, and writes there",
        'link = Path(os.environ["TMPDIR"], "link"); os.link(folder / "linked", link); link.write_text("x")',
        _changed("linked"),
    ),
    Attack(
        "writes through a symbolic link",
        'link = Path(os.environ["TMPDIR"], "soft"); link.symlink_to(folder / "soft"); link.write_text("x")',
        _changed("soft"),
    ),
    Attack(
        "changes the permissions of a file of yours",
        'os.chmod(folder / "permitted", 0o777)',
        lambda scene: (scene.folder / "permitted").stat().st_mode & 0o777 == 0o777,
    ),
    Attack(
        "changes the times of a file of yours",
        'os.utime(folder / "timed", (1, 1))',
        lambda scene: (scene.folder / "timed").stat().st_mtime == 1,
    ),
    Attack("looks whether a file of yours exists", 'aim((folder / "secret.txt").exists())'),
    Attack(
        "opens a file by its handle, past all paths",
        """
        handle = struct.pack("Ii", 128, 0) + bytes(128)
        buffer, mount = ctypes.create_string_buffer(handle), ctypes.c_int()
        name = os.fsencode(folder / "secret.txt")
        call(system.name_to_handle_at(-100, name, buffer, ctypes.byref(mount), 0))
        found = call(system.open_by_handle_at(os.open("/usr", os.O_RDONLY), buffer, os.O_RDONLY))
        aim(secret.encode() in os.read(found, 100))
        """,
    ),
    Attack(
        "watches a folder of yours",
        """
        watch = call(system.inotify_init())
        call(system.inotify_add_watch(watch, os.fsencode(folder), 0xFFF))
        aim()
        """,
    ),
    # Code that runs later.
    Attack(
        "writes into the folder of compiled kernels",
        # The folder is shared with other tests: the victim's number distinguishes the file from theirs.
        'Path(scene["kernels"], f"attack-{victim}").write_text("x")',
        lambda scene: (scene.kernels / f"attack-{scene.victim.pid}").exists(),
    ),
    Attack(
        "opens compiled kernels for writing",
        'open(next(Path(scene["kernels"]).rglob("*.nbi")), "r+b"); aim()',
    ),
    Attack(
        "writes into Python's packages",
        """
        import drivegate
        place = Path(drivegate.__file__).with_name("attack.py")
        place.write_text("x"); place.unlink(); aim()
        """,
    ),
    Attack(
        "changes its own sources",
        'Path(scene["candidate"], "attack.py").write_text("x")',
        lambda scene: (scene.candidate / "attack.py").exists(),
    ),
    # Other processes.
    Attack(
        "stops a process of yours",
        "os.kill(victim, signal.SIGSTOP)",
        lambda scene: scene.state_of_victim() == "T",
    ),
    Attack("asks whether a process of yours lives", "os.kill(victim, 0); aim()"),
    Attack(
        "reads the environment of a process", 'aim(secret in Path(f"/proc/{victim}/environ").read_text())'
    ),
    Attack(
        "reads the command line of a process", 'aim("time" in Path(f"/proc/{victim}/cmdline").read_text())'
    ),
    Attack("lists processes of yours", 'aim(str(victim) in os.listdir("/proc"))'),
    Attack("lists the open files of a process", 'aim(os.listdir(f"/proc/{victim}/fd") != [])'),
    Attack(
        "reads through the root folder of a process", 'aim(os.listdir(f"/proc/{victim}/root{folder}") != [])'
    ),
    Attack("opens the memory of a process", 'open(f"/proc/{victim}/mem", "r+b"); aim()'),
    Attack("traces a process", "call(system.ptrace(16, victim, 0, 0)); aim()"),
    Attack("seizes a process", "call(system.ptrace(0x4206, victim, 0, 0)); aim()"),
    Attack(
        "reads the memory of a process",
        """
        place = int(Path(f"/proc/{victim}/maps").read_text().split("-")[0], 16)
        room = ctypes.create_string_buffer(16)
        class Vector(ctypes.Structure):
            _fields_ = [("base", ctypes.c_void_p), ("length", ctypes.c_size_t)]
        here, there = Vector(ctypes.addressof(room), 16), Vector(place, 16)
        call(system.process_vm_readv(victim, ctypes.byref(here), 1, ctypes.byref(there), 1, 0)); aim()
        """,
    ),
    Attack("takes a descriptor of a process", "syscall(438, os.pidfd_open(victim), 0, 0); aim()"),
    Attack(
        "lowers a limit of a process",
        "resource.prlimit(victim, resource.RLIMIT_NOFILE, (60, 60))",
        lambda scene: resource.prlimit(scene.victim.pid, resource.RLIMIT_NOFILE)[0] == 60,
    ),
    Attack(
        "slows a process down",
        "os.setpriority(os.PRIO_PROCESS, victim, 15); aim(os.getpriority(os.PRIO_PROCESS, victim) == 15)",
    ),
    Attack(
        "moves a process to one processor",
        "os.sched_setaffinity(victim, {0})",
        lambda scene: len(os.sched_getaffinity(scene.victim.pid)) == 1 != psutil.cpu_count(),
    ),
    Attack(
        "slows a group of processes down",
        "os.setpriority(os.PRIO_PGRP, os.getpgid(victim), 16); aim(os.getpriority(os.PRIO_PROCESS, victim) == 16)",
    ),
    Attack(
        "changes how a process is scheduled",
        "os.sched_setscheduler(victim, os.SCHED_BATCH, os.sched_param(0))",
        lambda scene: os.sched_getscheduler(scene.victim.pid) == os.SCHED_BATCH,
    ),
    Attack(
        "puts the reading and writing of a process behind that of others",
        'syscall(scene["ioprio_set"], 1, victim, 3 << 13)',
        lambda scene: psutil.Process(scene.victim.pid).ionice().ioclass == psutil.IOPRIO_CLASS_IDLE,
    ),
    Attack(
        "reads what is typed at a terminal of yours",
        'os.open(scene["terminal"], os.O_RDONLY | os.O_NOCTTY); aim()',
    ),
    # What drivegate waits for.
    Attack(
        "takes the lock of those who compile kernels",
        """
        place = Path(scene["kernels"])
        for lock in (*place.glob("compiling"), *place.parent.glob("*.compiling")):
            # Each kernel has a byte of its own, far behind the first. Another worker of these tests may hold one.
            fcntl.lockf(open(lock), fcntl.LOCK_SH | fcntl.LOCK_NB, 1, 0); aim()
        """,
    ),
    Attack(
        "delays by a lease everybody who opens compiled kernels",
        'fcntl.fcntl(open(next(Path(scene["kernels"]).rglob("*.nbi"))), 1024, fcntl.F_RDLCK); aim()',
    ),
    # Ways out.
    Attack(
        "connects by TCP",
        'socket.create_connection(("127.0.0.1", scene["tcp"]), 2).send(b"x")',
        _heard("tcp"),
    ),
    Attack(
        "sends by UDP",
        'socket.socket(socket.AF_INET, socket.SOCK_DGRAM).sendto(b"x", ("127.0.0.1", scene["udp"]))',
        _heard("udp"),
    ),
    Attack(
        "listens at a port",
        'socket.create_server(("127.0.0.1", 0)); aim(scene["network"] == os.readlink("/proc/self/ns/net"))',
    ),
    Attack(
        "connects to a socket of yours, such as Docker's",
        'client = socket.socket(socket.AF_UNIX); client.connect(str(folder / "socket")); client.send(b"x")',
        _heard("path"),
    ),
    Attack(
        "connects to an abstract socket",
        'client = socket.socket(socket.AF_UNIX); client.connect(chr(0) + scene["abstract"]); client.send(b"x")',
        _heard("abstract"),
    ),
    Attack(
        "reaches the host of a virtual machine", "socket.socket(socket.AF_VSOCK, socket.SOCK_STREAM); aim()"
    ),
    Attack("talks to the kernel by netlink", "socket.socket(socket.AF_NETLINK, socket.SOCK_RAW); aim()"),
    Attack("opens a raw socket", "socket.socket(socket.AF_PACKET, socket.SOCK_RAW); aim()"),
    # What would stay.
    Attack(
        "leaves shared memory",
        'Path("/dev/shm", scene["left"]).write_text("x")',
        lambda scene: Path("/dev/shm", _left(scene)).exists(),
    ),
    Attack("makes System V shared memory", "call(system.shmget(scene['key'], 4096, 0o1600)); aim()"),
    Attack(
        "makes a message queue that others see",
        "call(system.msgget(scene['key'], 0o1600))",
        lambda scene: _queue_exists(_key(scene)),
    ),
    Attack(
        "makes a POSIX message queue",
        """
        queue = ctypes.create_string_buffer(scene["left"].encode())
        syscall(scene["mq_open"], ctypes.addressof(queue), os.O_CREAT | os.O_RDWR, 0o600, 0); aim()
        """,
    ),
    Attack("makes memory that no limit counts", 'os.memfd_create("attack"); aim()'),
    Attack(
        "adds a key to the kernel's keyring",
        'call(system.syscall(ctypes.c_long(scene["add_key"]), b"user", b"attack", b"x", 1, -3)); aim()',
    ),
    # The kernel.
    Attack("mounts a file system", 'call(system.mount(b"none", b"/mnt", b"tmpfs", 0, None)); aim()'),
    Attack("makes a user namespace", "call(system.unshare(0x10000000)); aim()"),
    Attack(
        "starts a process in a user namespace",
        'aim(subprocess.run(["unshare", "--user", "true"], stderr=subprocess.DEVNULL).returncode == 0)',
    ),
    Attack(
        "joins the namespaces of a process",
        'call(system.setns(os.open(f"/proc/{victim}/ns/mnt", os.O_RDONLY), 0)); aim()',
    ),
    Attack("changes the root folder", 'os.chroot("/usr"); aim()'),
    Attack(
        "makes a device", 'os.mknod(Path(os.environ["TMPDIR"], "device"), 0o20600, os.makedev(1, 1)); aim()'
    ),
    Attack(
        "reads the kernel's log",
        "room = ctypes.create_string_buffer(4096); aim(syscall(scene['syslog'], 3, ctypes.addressof(room), 4096) > 0)",
    ),
    Attack("writes into the kernel's log", 'os.open("/dev/kmsg", os.O_WRONLY); aim()'),
    Attack("opens settings of the kernel for writing", 'open("/proc/sys/kernel/core_pattern", "r+"); aim()'),
    Attack(
        "starts a ring of input and output",
        "syscall(425, 4, ctypes.addressof(ctypes.create_string_buffer(256))); aim()",
    ),
    Attack(
        "loads a program into the kernel",
        """
        attributes = ctypes.create_string_buffer(struct.pack("IIII", 1, 4, 4, 1), 72)
        syscall(scene["bpf"], 0, ctypes.addressof(attributes), 72); aim()
        """,
    ),
    Attack("handles page faults itself", "syscall(scene['userfaultfd'], 1); aim()"),
    Attack(
        "measures other processes",
        """
        attributes = ctypes.create_string_buffer(struct.pack("IIQ", 1, 112, 0), 112)
        syscall(scene["perf_event_open"], ctypes.addressof(attributes), victim, -1, -1, 0); aim()
        """,
    ),
    Attack("sets the host's name", "name = socket.gethostname(); socket.sethostname(name); aim()"),
    Attack("sets the clock", "time.clock_settime(time.CLOCK_REALTIME, time.time()); aim()"),
    Attack("becomes another user", "os.setuid(12345); aim()"),
    Attack("raises its own priority", "os.nice(-1); aim()"),
)
"""Every attack of a candidate's process, in the order of the table."""


def _named(lines: str) -> Callable[[Scene], bool]:
    """Return an attack by a manifest: True if drivegate opens what it names."""

    def is_opened(scene: Scene) -> bool:
        own, secret = scene.candidate, scene.folder / "secret.txt"
        (own / "own.c").touch()
        for name, target in (("link", secret), ("folder", scene.folder)):
            if not (own / name).is_symlink():
                (own / name).symlink_to(target)
        manifest = own / "candidate.toml"
        filled = lines.format(secret=secret, folder=scene.folder, dots=os.path.relpath(secret, own.resolve()))
        manifest.write_text(f'schema = 1\nname = "mine"\n{filled}\n', encoding="utf-8")
        try:
            resolve_candidate(str(manifest))
        except InputError as error:
            # What is refused later has been opened before.
            return "leads out of the manifest's folder" not in str(error)
        return True

    return is_opened


def _linked(scene: Scene) -> bool:
    """Return True if a candidate's library is a file of the user's, to which the linker has put a link."""
    secret = scene.folder / "secret.txt"
    (scene.candidate / "mine.c").write_text(_CONTROLLER, encoding="utf-8")
    try:
        candidate = resolve_candidate(with_plugin(scene.candidate, "library.so", secret))
    except InputError:
        return False
    return any(Path(place).resolve() == secret.resolve() for place in own_places(candidate))


def _waits(scene: Scene) -> bool:
    """Return True if drivegate waits for whoever writes into a FIFO that a manifest names."""
    os.mkfifo(scene.candidate / "fifo")
    manifest = scene.candidate / "waits.toml"
    lines = 'schema = 1\nname = "mine"\nkind = "exec"\nentry = "true"\nsources = ["fifo"]\n'
    manifest.write_text(lines, encoding="utf-8")
    before = signal.signal(signal.SIGALRM, _raise_timeout)
    signal.alarm(10)
    try:
        resolve_candidate(str(manifest))
    except InputError:
        return False
    except TimeoutError:
        return True
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)
    return True


def _raise_timeout(*_: object) -> None:
    raise TimeoutError


def _stays(scene: Scene, layers: tuple[Layer, ...]) -> bool:
    """Return True if a process of a build is left."""
    mark = f"6{scene.victim.pid}.5"
    words = isolated_command(["setsid", "--fork", "sleep", mark], layers, Places((), ()))
    run_bounded(words, folder=scene.candidate, environment={}, bounds=Bounds(20.0))
    left = [
        process for process in psutil.process_iter(["cmdline"]) if process.info["cmdline"] == ["sleep", mark]
    ]
    for process in left:
        process.kill()
    return left != []


# Enough for a library of the contract of duty ratios, which nobody runs.
_CONTROLLER = """
long drivegate_abi_version(void) { return 0; }
long drivegate_state_size(void) { return 0; }
int drivegate_duty_reset(void) { return 0; }
void drivegate_duty_step(void) {}
"""
_OF = "names a file of yours in its manifest: "
_EXEC = 'kind = "exec"\nentry = "true"\n'
BY_MANIFEST: dict[str, Callable[[Scene], bool]] = {
    _OF + "by its path": _named(_EXEC + 'sources = ["{secret}"]'),
    _OF + "with dots": _named(_EXEC + 'sources = ["{dots}"]'),
    _OF + "by a symbolic link": _named(_EXEC + 'sources = ["link"]'),
    _OF + "through a linked folder": _named(_EXEC + 'sources = ["folder/secret.txt"]'),
    _OF + "by a pattern through a link": _named(_EXEC + 'sources = ["folder/*.txt"]'),
    _OF + "as a word of its command": _named('kind = "exec"\nentry = "true {secret}"'),
    _OF + "as its program": _named('kind = "exec"\nentry = "{folder}/bin/tool"'),
    "names a folder of yours in its manifest": _named('kind = "c"\nentry = "own.c"\ninclude = ["{folder}"]'),
    _OF + "as its drive": _named('kind = "builtin"\nentry = "reference"\ndrive = "{folder}/drive.toml"'),
    _OF + "to be copied into its build": _named(
        'kind = "so"\nentry = "own.so"\nsources = ["{secret}"]\nbuild = ["true"]'
    ),
    "has the linker put a link to a file of yours in place of its library": _linked,
    "makes drivegate wait for a FIFO": _waits,
}
"""Every attack by a manifest, which drivegate itself reads, in the order of the table."""
BY_BUILD = {"leaves a process behind in its build": _stays}
NAMES = (*(attack.name for attack in ATTACKS), *BY_MANIFEST, *BY_BUILD)
"""Names of all attacks, in the order of the table."""


def _left(scene: Scene) -> str:
    return f"attack-{scene.victim.pid}"


def _key(scene: Scene) -> int:
    return 0x0D000000 + scene.victim.pid


def _queue_exists(key: int) -> bool:
    lines = Path("/proc/sysvipc/msg").read_text(encoding="ascii").splitlines()[1:]
    return any(int(line.split()[0]) == key for line in lines)


def outcomes(layers: tuple[Layer, ...]) -> dict[str, bool]:
    """Carry out every attack under some layers, and return for each whether it was done."""
    with _scene() as scene:
        reached = _attacked(scene, layers)
        done = {
            attack.name: number in reached or attack.is_done(scene) for number, attack in enumerate(ATTACKS)
        }
        done |= {name: is_done(scene) for name, is_done in BY_MANIFEST.items()}
        return done | {name: is_done(scene, layers) for name, is_done in BY_BUILD.items()}


def _attacked(scene: Scene, layers: tuple[Layer, ...]) -> set[int]:
    """Run the attacks in a candidate's process, and return the numbers of those that saw their success."""
    described = {
        "victim": scene.victim.pid,
        "folder": str(scene.folder),
        "candidate": str(scene.candidate),
        "kernels": str(scene.kernels),
        "secret": _SECRET,
        **{name: scene.sockets[name].getsockname()[1] for name in ("tcp", "udp")},
        "network": str(Path("/proc/self/ns/net").readlink()),
        "abstract": _left(scene),
        "left": _left(scene),
        "key": _key(scene),
        "terminal": scene.terminal,
        **{name: NUMBERS[name] for name in _CALLS},
    }
    steps = [
        _EACH.format(code=indent(dedent(attack.code).strip(), " " * 8), number=number)
        for number, attack in enumerate(ATTACKS)
    ]
    file = scene.candidate / "attacker.py"
    file.write_text(
        _PRELUDE.format(scene=json.dumps(described)) + "".join(steps) + _CANDIDATE, encoding="utf-8"
    )
    with Judge(resolve_candidate(f"{file}:Mine"), layers=layers) as judge:
        ending = judge.once(Job(_loaded, None))
    assert isinstance(ending, Fault), "the candidate reports by an exception"
    report = re.search(r"reached ([\d ]*)", ending.message)
    assert report, f"the attacks did not come to their end: {ending}"
    return set(map(int, report[1].split()))


_CALLS = ("add_key", "bpf", "userfaultfd", "perf_event_open", "ioprio_set", "mq_open", "syslog")


def _loaded(loaded: JudgedCandidate, _payload: None) -> None:
    loaded.controller()


@contextmanager
def _scene() -> Iterator[Scene]:
    """Set up what the attacks are after: files, a process and sockets of the user's."""
    environment = {**os.environ, "DEPLOY_TOKEN": _SECRET}
    with (
        tempfile.TemporaryDirectory() as mine,
        tempfile.TemporaryDirectory() as candidate,
        ExitStack() as stack,
        subprocess.Popen(
            [sys.executable, "-c", "import time; print(flush=True); time.sleep(600)"],
            env=environment,
            stdout=subprocess.PIPE,
            # A group of its own, which is what an attack on a group is for.
            start_new_session=True,
        ) as victim,
        _terminal() as terminal,
    ):
        sockets = _sockets(stack, Path(mine), f"attack-{victim.pid}")
        scene = Scene(victim, Path(mine), Path(candidate), required_cache_folder(), sockets, terminal)
        with cache_lock.alone("attack", str(scene.kernels)):
            # The file of the locks is there from now on.
            pass
        kernel = scene.kernels / f"attack-{victim.pid}.nbi"
        kernel.touch()
        try:
            assert victim.stdout is not None
            victim.stdout.readline()
            (scene.folder / "secret.txt").write_text(_SECRET)
            for name in _FILES:
                (scene.folder / name).write_text("mine")
                (scene.folder / name).chmod(0o600)
            (scene.folder / "bin").mkdir()
            (scene.folder / "bin" / "tool").touch(0o700)
            (scene.folder / "drive.toml").touch()
            yield scene
        finally:
            victim.kill()
            kernel.unlink(missing_ok=True)
            _remove_message_queue(_left(scene))
            (scene.kernels / f"attack-{scene.victim.pid}").unlink(missing_ok=True)
            Path("/dev/shm", _left(scene)).unlink(missing_ok=True)
            _remove_queue(_key(scene))


@contextmanager
def _terminal() -> Iterator[str]:
    """Open a terminal, as a window of the user's is one."""
    ends = os.openpty()
    try:
        yield os.ttyname(ends[1])
    finally:
        for end in ends:
            os.close(end)


_FILES = (
    "overwritten",
    "appended",
    "moved",
    "replaced",
    "truncated",
    "deleted",
    "linked",
    "soft",
    "permitted",
    "timed",
)


def _sockets(stack: ExitStack, folder: Path, name: str) -> dict[str, socket.socket]:
    """Bind one socket of each kind; what reaches one waits there until somebody looks."""
    tcp = stack.enter_context(socket.create_server(("127.0.0.1", 0)))
    udp = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
    udp.bind(("127.0.0.1", 0))
    found = {"tcp": tcp, "udp": udp}
    for kind, place in (("path", str(folder / "socket")), ("abstract", f"\0{name}")):
        found[kind] = stack.enter_context(socket.socket(socket.AF_UNIX))
        found[kind].bind(place)
        found[kind].listen()
    return found


def _remove_queue(key: int) -> None:
    """Remove the message queue and the shared memory of a key, if there are any."""
    for option in ("--queue-key", "--shmem-key"):
        subprocess.run(["ipcrm", option, str(key)], stderr=subprocess.DEVNULL, check=False)


def _remove_message_queue(name: str) -> None:
    with suppress(OSError):
        SYSTEM.mq_unlink(f"/{name}".encode())


def read_table(page: str) -> dict[str, dict[str, str]]:
    """Read the table of docs/containment.md: what is stated of each attack at each level."""
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| ")]
    return {row[0]: dict(zip((*LEVELS, ORDINARY), row[1:], strict=True)) for row in rows if row[0] in NAMES}


def table() -> str:
    """Write the table of docs/containment.md."""
    found = {}
    for level, layers in LEVELS.items():
        # Without layers, root's candidate does all that an ordinary user's does.
        others = (of_ordinary_user(level) if layers else None) or {}
        found[level] = {name: done or others.get(name, False) for name, done in outcomes(layers).items()}
    found[ORDINARY] = of_ordinary_user("none") or {}
    lines = [f"| a candidate | {' | '.join(found)} |", "|---|" + "---|" * len(found)]
    for name in NAMES:
        cells = ["neither" if column[name] else "prevented" for column in found.values()]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def of_ordinary_user(level: str) -> dict[str, bool] | None:
    """Carry out every attack at a level as an ordinary user, where this process is root's.

    None if an ordinary user does not have the level on this machine.
    """
    from tests.harness.containment.ordinary_user import run_as_ordinary_user

    with tempfile.TemporaryDirectory() as home:
        found: dict[str, bool] | None = json.loads(
            run_as_ordinary_user(Path(home), __file__, "--json", level)
        )
    return found


if __name__ == "__main__":
    if sys.argv[1:2] == ["--json"]:
        layers = LEVELS[sys.argv[2]]
        can_be_tried = set(layers) <= set(available_layers())
        sys.stdout.write(json.dumps(outcomes(layers) if can_be_tried else None))
    else:
        sys.stdout.write(table())
