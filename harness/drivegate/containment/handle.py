"""A worker process as its parent holds it: started, heard, measured and ended for certain."""

import os
import pickle
import time
import weakref
from contextlib import suppress
from io import FileIO
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from typing import Any

import psutil

from drivegate.candidates.fault import LONGEST_TRACEBACK
from drivegate.containment.kept_process import KeptProcess
from drivegate.containment.messages import Job, Reply, Setup
from drivegate.containment.process import STACK_SIGNAL
from drivegate.containment.shared_progress import SharedProgress

_LONGEST_REPLY = 2**28
_MOST_READS = 16
_PATIENCE = 2.0
_STACK_PATIENCE = 0.5


class UnreadableReply(Exception):
    """What came from a worker process is no message of the harness."""


class WorkerHandle:
    """One running worker process, with a keeper that lets nothing outlive it.

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
            self._kept = KeptProcess(
                setup.candidate.folder, theirs.fileno(), self.progress.descriptor, writer
            )
        finally:
            theirs.close()
            os.close(writer)
            self.progress.close()
        self._measured: psutil.Process | None = None
        self.end = weakref.finalize(self, _end, self._kept, ours, self._output)
        self.send(setup)

    @property
    def waitables(self) -> list[Any]:
        """What becomes readable when the process has something to tell."""
        return [self._connection] if self._output_ended else [self._connection, self._output]

    def send(self, message: Setup | Job[Any]) -> None:
        """Send a message; a process that has died meanwhile is noticed later."""
        with suppress(BrokenPipeError, ConnectionResetError):
            self._connection.send(message)

    def receive(self) -> Reply | None:
        """Take the next message, without waiting for one."""
        try:
            if not self._connection.poll():
                return None
            message = self._connection.recv_bytes(_LONGEST_REPLY)
        except (EOFError, ConnectionResetError):
            return None
        except OSError as error:
            raise UnreadableReply from error
        try:
            reply = pickle.loads(message)
        except Exception as error:
            raise UnreadableReply from error
        if not isinstance(reply, Reply):
            raise UnreadableReply
        return reply

    def has_ended(self) -> bool:
        """Tell whether the process has died by itself; it is not reaped yet, so its id is still its own."""
        if self._kept.keeper_has_ended():
            return True
        process = self._process()
        try:
            return process is not None and process.status() in (psutil.STATUS_ZOMBIE, psutil.STATUS_DEAD)
        except psutil.NoSuchProcess:
            return True

    def _process(self) -> psutil.Process | None:
        """Return the process as the system knows it; None until it has been started, or where it is gone."""
        if self._measured is None and (number := self._kept.process_id) is not None:
            with suppress(psutil.NoSuchProcess):
                self._measured = psutil.Process(number)
        return self._measured

    def processor_seconds(self) -> float:
        """Measure the processor time that the process has used."""
        process = self._process()
        if process is None:
            return 0.0
        try:
            times = process.cpu_times()
        except psutil.NoSuchProcess:
            return 0.0
        return float(times.user + times.system)

    def drain_output(self) -> None:
        """Read what the process has printed, so that it never waits for a reader; only the end is kept."""
        for _ in range(_MOST_READS):
            block = self._output.read(65536)
            if block is None:
                return
            self._output_ended = block == b""
            self._tail = (self._tail + block)[-LONGEST_TRACEBACK:]

    def forget_output(self) -> None:
        """Leave out of `last_output` what the process has printed so far."""
        self.drain_output()
        self._tail = b""

    def last_output(self) -> str:
        """Give the end of what the process has printed."""
        self.drain_output()
        return self._tail.decode(errors="replace")

    def stack(self) -> str:
        """Ask the process where it is, then give what it printed."""
        self.forget_output()
        process = self._process()
        if process is None or self.has_ended():
            return ""
        process.send_signal(STACK_SIGNAL)
        deadline = time.monotonic() + _STACK_PATIENCE
        quiet = 0
        while quiet < 3 and time.monotonic() < deadline:
            time.sleep(0.02)
            before = self._tail
            self.drain_output()
            quiet = quiet + 1 if before and before == self._tail else 0
        return self.last_output()

    def exit_status(self) -> int:
        """End the process if it still lives, and tell how it ended."""
        self.end()
        return self._kept.exit_status()

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


def _end(kept: KeptProcess, connection: "Connection[Any, Any]", output: FileIO) -> None:
    kept.end()
    connection.close()
    output.close()
