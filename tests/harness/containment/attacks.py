"""Attacks on the machine that checks a candidate, each carried out for real by code in the candidate's process.

``python tests/harness/containment/attacks.py`` prints the table of docs/containment.md.
"""

from __future__ import annotations

import json
import os
import re
import resource
import select
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

from drivegate.candidates.fault import Fault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.isolation.layers import Layer
from drivegate.isolation.system_calls import NUMBERS
from drivegate_models.compilation.kernels import required_cache_folder

LEVELS: dict[str, tuple[Layer, ...]] = {
    "all layers": tuple(Layer),
    "without namespaces": (Layer.LANDLOCK, Layer.REFUSED_CALLS),
    "none": (),
}
"""Each level of isolation in the table, and its layers."""

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
        "os.setpriority(os.PRIO_PROCESS, victim, 15)",
        lambda scene: os.getpriority(os.PRIO_PROCESS, scene.victim.pid) == 15,
    ),
    Attack(
        "moves a process to one processor",
        "os.sched_setaffinity(victim, {0})",
        lambda scene: len(os.sched_getaffinity(scene.victim.pid)) == 1 != psutil.cpu_count(),
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
"""Every attack, in the order of the table."""


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
        return {
            attack.name: number in reached or attack.is_done(scene) for number, attack in enumerate(ATTACKS)
        }


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
        **{name: NUMBERS[name] for name in ("add_key", "bpf", "userfaultfd", "perf_event_open")},
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
        ) as victim,
    ):
        sockets = _sockets(stack, Path(mine), f"attack-{victim.pid}")
        scene = Scene(victim, Path(mine), Path(candidate), required_cache_folder(), sockets)
        try:
            assert victim.stdout is not None
            victim.stdout.readline()
            (scene.folder / "secret.txt").write_text(_SECRET)
            for name in _FILES:
                (scene.folder / name).write_text("mine")
                (scene.folder / name).chmod(0o600)
            yield scene
        finally:
            victim.kill()
            (scene.kernels / f"attack-{scene.victim.pid}").unlink(missing_ok=True)
            Path("/dev/shm", _left(scene)).unlink(missing_ok=True)
            _remove_queue(_key(scene))


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


def read_table(page: str) -> dict[str, dict[str, str]]:
    """Read the table of docs/containment.md: what is stated of each attack at each level."""
    rows = [line.strip("| ").split(" | ") for line in page.splitlines() if line.startswith("| ")]
    names = {attack.name for attack in ATTACKS}
    return {row[0]: dict(zip(LEVELS, row[1:], strict=True)) for row in rows if row[0] in names}


def table() -> str:
    """Write the table of docs/containment.md."""
    found = {level: outcomes(layers) for level, layers in LEVELS.items()}
    lines = [f"| a candidate | {' | '.join(LEVELS)} |", "|---|" + "---|" * len(LEVELS)]
    for attack in ATTACKS:
        cells = ["neither" if found[level][attack.name] else "prevented" for level in LEVELS]
        lines.append(f"| {attack.name} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    sys.stdout.write(table())
