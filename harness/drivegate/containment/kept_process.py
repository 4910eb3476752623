"""A process of the harness or of a candidate, with its keeper, as it is started and ended."""

import os
import signal
import subprocess
import time
from contextlib import suppress
from enum import StrEnum
from pathlib import Path

import psutil

from drivegate.containment.environment import worker_environment
from drivegate.containment.temporary_folder import TemporaryFolder
from drivegate.isolation.layers import Layer, Places, python_command, written_order
from drivegate_models.compilation.kernels import choose_cache_folder

_KEEPER_PATIENCE = 20.0
_PATIENCE = 3.0


class Role(StrEnum):
    """What a kept process does."""

    JUDGE = "judge"
    CANDIDATE = "candidate"


class KeptProcess:
    """One process, from its start to when nothing of it is left.

    A candidate's gets few environment variables, and its output goes to a descriptor; a judge's is the harness's own.
    """

    def __init__(
        self,
        role: Role,
        folder: Path | None,
        descriptors: tuple[int, ...],
        *,
        output: int | None = None,
        layers: tuple[Layer, ...] = (),
        readable: tuple[str, ...] = (),
    ) -> None:
        self._owner = os.getpid()
        self._temporary = TemporaryFolder()
        self._reported = b""
        temporary = str(self._temporary.path)
        environment = None
        if role is Role.CANDIDATE:
            kernels = choose_cache_folder()
            environment = worker_environment(os.environ, self._temporary.path, kernels)
            readable = readable if kernels is None else (*readable, str(kernels))
        order = written_order(layers, Places(readable, (temporary,)))
        words = (role.value, order, temporary, *map(str, descriptors))
        try:
            self._keeper = subprocess.Popen(
                python_command("drivegate.containment.keeper", "keep", *words),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=output,
                pass_fds=descriptors,
                start_new_session=True,
                cwd=folder if folder is not None and folder.is_dir() else None,
                env=environment,
                bufsize=0,
            )
        except BaseException:
            self._temporary.remove()
            raise
        assert self._keeper.stdout is not None
        os.set_blocking(self._keeper.stdout.fileno(), False)

    @property
    def process_id(self) -> int | None:
        """Process id of the worker, which stays its own until `end`; None until the worker has been started."""
        if b"\n" not in self._reported:
            self._listen()
        return int(self._reported.split()[0]) if b"\n" in self._reported else None

    @property
    def keeper_id(self) -> int:
        """Process id of the keeper."""
        return self._keeper.pid

    def is_stopped(self) -> bool:
        """Return True if the worker or its keeper is stopped, by a signal or by a debugger."""
        stopped = (psutil.STATUS_STOPPED, psutil.STATUS_TRACING_STOP)
        with suppress(psutil.NoSuchProcess):
            numbers = (self.process_id, self._keeper.pid)
            return any(psutil.Process(number).status() in stopped for number in numbers if number is not None)
        return False

    def keeper_has_ended(self) -> bool:
        """Return True if the keeper has ended by itself, which it does when it was killed."""
        return self._keeper.poll() is not None

    def wait_for_worker(self) -> None:
        """Wait a moment for the process to end by itself."""
        until = time.monotonic() + _PATIENCE
        number = self.process_id
        while number is not None and time.monotonic() < until:
            try:
                if psutil.Process(number).status() == psutil.STATUS_ZOMBIE:
                    return
            except psutil.NoSuchProcess:
                return
            time.sleep(0.005)

    def exit_status(self) -> int:
        """Return how the worker ended, once `end` has been called."""
        numbers = self._reported.split()
        # A worker whose keeper was killed is killed by the system.
        return int(numbers[1]) if len(numbers) > 1 else -signal.SIGKILL

    def end(self) -> None:
        """Kill the worker and all that came from it; in another process than the one that started it, do nothing."""
        if os.getpid() != self._owner or self._keeper.stdin is None or self._keeper.stdin.closed:
            return
        self._keeper.stdin.close()
        # A candidate may have stopped the keeper, once or again and again.
        self._keeper.send_signal(signal.SIGCONT)
        try:
            self._keeper.wait(_KEEPER_PATIENCE)
        except subprocess.TimeoutExpired:
            self._kill_descendants()
            self._keeper.kill()
            self._keeper.wait()
        self._listen()
        if self._keeper.stdout is not None:
            self._keeper.stdout.close()
        self._temporary.remove()

    def _kill_descendants(self) -> None:
        """Kill what a keeper that does not answer keeps; all of it is below the keeper as long as that lives."""
        with suppress(psutil.NoSuchProcess):
            keeper = psutil.Process(self._keeper.pid)
            while kept := [
                each for each in keeper.children(recursive=True) if each.status() != psutil.STATUS_ZOMBIE
            ]:
                for each in kept:
                    with suppress(psutil.NoSuchProcess):
                        each.kill()

    def _listen(self) -> None:
        with suppress(OSError, ValueError):
            if self._keeper.stdout is not None:
                self._reported += self._keeper.stdout.read() or b""
