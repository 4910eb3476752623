"""A worker process as its parent holds it: started, heard, measured and ended for certain."""

import json
import os
import signal
import subprocess
import sys
import time
import weakref
from contextlib import suppress
from io import FileIO
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

import psutil

from drivegate.fault import LONGEST_TRACEBACK
from drivegate.shared_progress import SharedProgress
from drivegate.worker_messages import Job, Reply, Setup
from drivegate.worker_process import STACK_SIGNAL

_BOOTSTRAP = (
    "import json, sys; sys.path[:] = json.loads(sys.argv[1]); "
    "from drivegate.worker_process import main; main(*map(int, sys.argv[2:]))"
)
_MOST_READS = 16
_PATIENCE = 2.0
_STACK_PATIENCE = 0.5


class WorkerHandle:
    """One running worker process, in a process group of its own.

    Parameters
    ----------
    setup : Setup
        The candidate to load, and how.

    Attributes
    ----------
    progress : SharedProgress
        Memory shared with the process.
    """

    def __init__(self, setup: Setup) -> None:
        self.progress = SharedProgress.create()
        ours, theirs = Pipe()
        reader, writer = os.pipe()
        self._connection: Connection[Any, Any] = ours
        self._output = FileIO(reader)
        self._output_ended = False
        self._tail = b""
        os.set_blocking(reader, False)
        try:
            self._process = _started(theirs.fileno(), self.progress.descriptor, writer)
        finally:
            theirs.close()
            os.close(writer)
            self.progress.close()
        self._measured = psutil.Process(self._process.pid)
        self.end = weakref.finalize(self, _end, os.getpid(), self._process, ours, self._output)
        self.send(setup)

    @property
    def waitables(self) -> list[Any]:
        """What becomes readable when the process has something to tell."""
        return [self._connection] if self._output_ended else [self._connection, self._output]

    def send(self, message: Setup | Job[Any]) -> None:
        """Send a message; a process that has died meanwhile is noticed later.

        Parameters
        ----------
        message : Setup or Job
            The message.
        """
        with suppress(BrokenPipeError, ConnectionResetError):
            self._connection.send(message)

    def receive(self) -> Reply | None:
        """Take the next message, without waiting for one.

        Returns
        -------
        Reply or None
            None when there is none.
        """
        try:
            if self._connection.poll():
                reply: Reply = self._connection.recv()
                return reply
        except (EOFError, ConnectionResetError):
            return None
        return None

    def has_ended(self) -> bool:
        """Tell whether the process has died by itself; it is not reaped yet, so its id is still its own.

        Returns
        -------
        bool
            Whether it is dead.
        """
        return self._measured.status() in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)

    def processor_seconds(self) -> float:
        """Measure the processor time that the process has used.

        Returns
        -------
        float
            User and system time of all its threads (s).
        """
        times = self._measured.cpu_times()
        return float(times.user + times.system)

    def drain_output(self) -> None:
        """Read what the process has printed, so that it never waits for a reader; only the end is kept."""
        for _ in range(_MOST_READS):
            block = self._output.read(65536)
            if block is None:
                return
            self._output_ended = block == b""
            self._tail = (self._tail + block)[-LONGEST_TRACEBACK:]

    def last_output(self) -> str:
        """Give the end of what the process has printed.

        Returns
        -------
        str
            At most `LONGEST_TRACEBACK` characters.
        """
        self.drain_output()
        return self._tail.decode(errors="replace")

    def stack(self) -> str:
        """Ask the process where it is, then give what it printed.

        Returns
        -------
        str
            The Python stack of its threads, when it could still tell.
        """
        self.drain_output()
        self._tail = b""
        os.kill(self._process.pid, STACK_SIGNAL)
        deadline = time.monotonic() + _STACK_PATIENCE
        quiet = 0
        while quiet < 3 and time.monotonic() < deadline:
            time.sleep(0.02)
            before = self._tail
            self.drain_output()
            quiet = quiet + 1 if before and before == self._tail else 0
        return self.last_output()

    def exit_status(self) -> int:
        """End the process if it still lives, and tell how it ended.

        Returns
        -------
        int
            Its exit status; negative for a signal.
        """
        self.end()
        return self._process.returncode

    def hang_up(self) -> None:
        """Tell the process that no more messages come, on which it ends by itself."""
        self._connection.close()

    def end_in_peace(self) -> None:
        """Give the process a moment to end by itself, then end it."""
        self.hang_up()
        deadline = time.monotonic() + _PATIENCE
        while not self.has_ended() and time.monotonic() < deadline:
            self.drain_output()
            time.sleep(0.005)
        self.end()


def _started(connection: int, progress: int, output: int) -> subprocess.Popen[bytes]:
    """Start the interpreter with this one's import path, whatever the working folder holds."""
    arguments = [
        json.dumps([str(place) for place in sys.path]),
        str(connection),
        str(progress),
        str(os.getpid()),
    ]
    return subprocess.Popen(
        [sys.executable, "-P", "-c", _BOOTSTRAP, *arguments],
        stdin=subprocess.DEVNULL,
        stdout=output,
        stderr=output,
        pass_fds=(connection, progress),
        start_new_session=True,
        env={"PYTHONHASHSEED": "0", **os.environ},
    )


def _end(
    owner: int, process: subprocess.Popen[bytes], connection: "Connection[Any, Any]", output: FileIO
) -> None:
    """Kill the whole process group while its leader's id is still its own, then reap the leader."""
    if os.getpid() != owner:
        return
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    connection.close()
    output.close()
