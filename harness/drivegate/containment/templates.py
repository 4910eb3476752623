"""Templates as the harness has them: one process for each role, from which keepers are started cheaply."""

import json
import os
import signal
import socket
import subprocess
import sys
import threading
import weakref
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Final, NamedTuple

from drivegate.containment.keeper_process import CopiedKeeper
from drivegate.isolation.layers import python_command

# The first copy waits for all imports of the template, which takes many seconds on a busy machine. After that time a
# new process is started instead.
_PATIENCE: Final = 60.0
# By then its copies have been ended, so that it ends at once unless something holds it.
_END_PATIENCE: Final = 5.0
# What a process inherits, as far as Linux states it: a copy has it from its template, not from the harness.
_INHERITED: Final = (
    *("Umask:", "Uid:", "Gid:", "Groups:", "SigBlk:", "SigIgn:", "Cap", "NoNewPrivs:", "Seccomp"),
    *("Cpus_allowed:", "Mems_allowed:"),
)


class Preparation(NamedTuple):
    """What a template computes once for all of its copies: a function of drivegate, which runs nobody else's code."""

    module: str
    function: str
    argument: str


class KeeperOrder(NamedTuple):
    """What a keeper gets that is started as a copy."""

    words: Sequence[str]
    """Role, order and temporary folder of `keep`."""
    descriptors: Sequence[int]
    """Standard input, output and error, then those of the worker."""
    environment: Mapping[str, str]
    modules: Sequence[str]
    """What this copy and all later ones have imported."""


class Template:
    """One process that offers copies of itself, until this object hangs up or its process ends."""

    def __init__(self, role: str, environment: Mapping[str, str]) -> None:
        # Packets keep each order together with the connection that comes with it.
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        ours.settimeout(_PATIENCE)
        self._requests = ours
        with theirs:
            # The third word shows in a list of processes whose template it is.
            words = (role, str(theirs.fileno()), str(os.getpid()))
            self._process = subprocess.Popen(
                python_command("drivegate.containment.copying", "offer_copies", *words),
                stdin=subprocess.DEVNULL,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=(theirs.fileno(),),
                # Ctrl-C in a terminal reaches the harness alone, which ends its processes in order.
                start_new_session=True,
                env=environment,
            )
        self.pid: Final = self._process.pid
        self.end = weakref.finalize(self, _end, os.getpid(), self._process, ours)

    def keeper(self, order: KeeperOrder, folder: int) -> CopiedKeeper | None:
        """Start a keeper as a copy, in the folder of a descriptor; None if the template does not answer."""
        ours, theirs = socket.socketpair()
        with ours:
            ours.settimeout(_PATIENCE)
            try:
                with theirs:
                    socket.send_fds(self._requests, [json.dumps(order.modules).encode()], [theirs.fileno()])
                number, received, _, _ = socket.recv_fds(ours, 32, 1)
            except OSError:
                return None
            if not received:
                return None
            os.set_inheritable(received[0], False)
            # A copy that has answered is ended by what ends any keeper, also if it dies before it is ordered.
            with suppress(OSError):
                written = json.dumps([order.words, dict(order.environment)]).encode()
                # Descriptors need a byte to go with.
                socket.send_fds(ours, [written[:1]], [folder, *order.descriptors])
                ours.sendall(written[1:])
        return CopiedKeeper(int(number), received[0])

    def prepare(self, preparation: Preparation) -> None:
        with suppress(OSError):
            self._requests.send(json.dumps(preparation).encode())

    def hang_up(self) -> None:
        """Have the template end by itself, once its copies have ended."""
        self._requests.close()

    @property
    def descriptor(self) -> int:
        """Descriptor of the connection to the process; negative once it serves no more."""
        return self._requests.fileno()

    def has_ended(self) -> bool:
        return self._process.poll() is not None


def _end(owner: int, process: "subprocess.Popen[bytes]", requests: socket.socket) -> None:
    """End a template; in another process than the one that started it, do nothing."""
    if os.getpid() != owner:
        return
    requests.close()
    with suppress(subprocess.TimeoutExpired):
        # A candidate without isolation may have stopped it.
        process.send_signal(signal.SIGCONT)
        process.wait(_END_PATIENCE)
        return
    process.kill()
    process.wait()


class Templates:
    """The templates of this process; each serves for as long as keepers are started under the same conditions.

    The first keeper under other conditions is a new process: many a process starts no second one.
    """

    def __init__(self) -> None:
        self._owner = os.getpid()
        self._lock = threading.Lock()
        self._conditions: dict[str, object] = {}
        self._templates: dict[str, Template | None] = {}
        self._retired: list[Template] = []

    def keeper(
        self, order: KeeperOrder, folder: Path | None, inherited: Mapping[str, str], *, is_one_of_many: bool
    ) -> CopiedKeeper | None:
        """Start a keeper as a copy of a template; None if it has to be a new process.

        `inherited`: what of its environment does not differ from one keeper to the next.
        `is_one_of_many`: true if others follow for certain, so that even the first one is a copy.
        """
        role = order.words[0]
        if not self._makes_copies():
            return None
        with self._lock:
            template = self._template(role, inherited, is_one_of_many=is_one_of_many)
            if template is None:
                return None
            try:
                place = os.open("." if folder is None else folder, os.O_PATH | os.O_DIRECTORY)
            except OSError:
                return None
            try:
                keeper = template.keeper(order, place)
            finally:
                os.close(place)
            if keeper is None:
                # It is not tried again under these conditions: each try may take the whole patience.
                self._templates[role] = None
                template.end()
            return keeper

    def prepare(
        self, role: str, inherited: Mapping[str, str], preparation: Preparation, *, is_one_of_many: bool
    ) -> None:
        """Prepare later copies, unless the next keeper of the role has to be a new process.

        The arguments are those of `keeper`. What is prepared has to be trusted when this is called.
        """
        if not self._makes_copies():
            return
        with self._lock, suppress(OSError):
            if is_one_of_many or self._conditions.get(role) == _conditions(inherited):
                template = self._template(role, inherited, is_one_of_many=is_one_of_many)
                if template is not None:
                    template.prepare(preparation)

    def _makes_copies(self) -> bool:
        """Return True if this system and this process can start copies."""
        return hasattr(os, "pidfd_open") and os.getpid() == self._owner

    def _template(
        self, role: str, environment: Mapping[str, str], *, is_one_of_many: bool
    ) -> Template | None:
        """Return the template of a role under the present conditions, which may have to be started."""
        try:
            conditions = _conditions(environment)
        except OSError:
            return None
        if self._conditions.get(role) != conditions:
            self._conditions[role] = conditions
            self._retire(role)
            if not is_one_of_many:
                return None
        if role not in self._templates:
            self._templates[role] = Template(role, environment)
        return self._templates[role]

    def _retire(self, role: str) -> None:
        """Let a template end; what it has started may go on."""
        template = self._templates.pop(role, None)
        if template is not None:
            template.hang_up()
            self._retired.append(template)
        self._retired = [each for each in self._retired if not each.has_ended()]

    def started(self) -> tuple[Template, ...]:
        """Return all templates that may run, also those that serve no more."""
        return tuple(each for each in (*self._templates.values(), *self._retired) if each is not None)


def _conditions(environment: Mapping[str, str]) -> tuple[object, ...]:
    """Return what this process would pass on to a new one."""
    status = Path("/proc/thread-self/status").read_text(encoding="utf-8", errors="replace")
    limits = Path("/proc/self/limits").read_bytes()
    killing = Path("/proc/self/oom_score_adj").read_bytes()
    stated = [line for line in status.splitlines() if line.startswith(_INHERITED)]
    return dict(environment), list(sys.path), stated, limits, killing, os.getpriority(os.PRIO_PROCESS, 0)


TEMPLATES: Final = Templates()
