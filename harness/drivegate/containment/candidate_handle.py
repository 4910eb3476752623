"""A candidate's process as its judge holds it: started, heard, measured and ended for certain."""

import os
import pickle
import socket
import sys
import time
import weakref
from contextlib import suppress
from io import FileIO
from typing import Any

import numpy as np
import psutil
from numpy.typing import NDArray

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import LONGEST_TRACEBACK
from drivegate.containment.candidate_isolation import own_environment, own_places, written_places
from drivegate.containment.kept_process import KeptProcess, Role
from drivegate.containment.machine_memory import free_memory_of
from drivegate.containment.protocol import (
    LONGEST_REPLY,
    PACKET,
    WORD,
    Order,
    Reply,
    UnreadableReply,
    unpacked,
)
from drivegate.containment.serving import STACK_SIGNAL
from drivegate.containment.shared_memory import SharedMemory, SharedProgress
from drivegate.containment.watches import memory_of_descendants
from drivegate.isolation.layers import Layer

# One look reads 1 MiB at most: a candidate that prints without end must not keep its judge reading.
_MOST_READS = 16
# For exit handlers and the deletion of the instance. Nothing is lost if the process is killed after that.
_PATIENCE = 2.0
# `faulthandler` prints within milliseconds, also in an endless loop. Only a stopped process prints nothing.
_STACK_PATIENCE = 0.5
# Packets arrive whole or not at all, so that half of a reply keeps nobody waiting.
_PACKETS = socket.SOCK_SEQPACKET if sys.platform.startswith("linux") else socket.SOCK_DGRAM


class CandidateHandle:
    """One running process with a candidate, and a keeper that lets nothing outlive it."""

    def __init__(self, candidate: Candidate, layers: tuple[Layer, ...], *, afresh: bool) -> None:
        self.progress = SharedProgress.create()
        self._memory: SharedMemory | None = None
        ours, theirs = socket.socketpair(socket.AF_UNIX, _PACKETS)
        ours.setblocking(False)
        reader, writer = os.pipe()
        self._channel = ours
        self._output = FileIO(reader)
        self._output_ended = False
        self._tail = b""
        os.set_blocking(reader, False)
        try:
            descriptors = (theirs.fileno(), self.progress.descriptor)
            self._kept = KeptProcess(
                Role.CANDIDATE,
                candidate.folder,
                descriptors,
                output=writer,
                layers=layers,
                readable=own_places(candidate),
                writable=written_places(candidate),
                variables=own_environment(candidate),
                afresh=afresh,
            )
        finally:
            # From here on only the process itself has its ends, so that its death closes them.
            theirs.close()
            os.close(writer)
            self.progress.close()
        self._measured: psutil.Process | None = None
        self.end = weakref.finalize(self, _end, self._kept, ours, self._output)

    @property
    def waitables(self) -> list[Any]:
        """What becomes readable when the process has something to report."""
        return [self._channel] if self._output_ended else [self._channel, self._output]

    def send(self, order: Order, space: int = 0) -> None:
        """Send an order, with space in bytes for its commands; a process that has died is noticed later."""
        written = pickle.dumps(order, pickle.HIGHEST_PROTOCOL)
        needed = max(len(written), space)
        descriptors = []
        if self._memory is None or self._memory.size < needed:
            self._memory = SharedMemory.create(needed)
            descriptors.append(self._memory.descriptor)
        self._memory.write(written)
        packet = PACKET.pack(WORD, len(written), self._memory.size)
        try:
            # Only a process that does not read has a full buffer, and that is noticed as a hang.
            with suppress(OSError):
                socket.send_fds(self._channel, [packet], descriptors)
        finally:
            if descriptors:
                self._memory.close()

    def receive(self) -> Reply | None:
        """Take the next reply, without waiting for one."""
        try:
            # One byte more than a reply can have: a longer packet, cut to the limit, would look like a valid one.
            message = self._channel.recv(LONGEST_REPLY + 1)
        except (BlockingIOError, ConnectionResetError):
            return None
        except OSError as error:
            raise UnreadableReply from error
        return unpacked(message) if message else None

    def copied_commands(self, layout: np.dtype[Any], count: int) -> NDArray[Any]:
        """Copy the first commands of the last run, as far as there is space for them; shape (n,)."""
        assert self._memory is not None, "commands follow on an order"
        # A copy, since the candidate can write into the memory at any time.
        return self._memory.commands(layout)[:count].copy()

    def has_ended(self) -> bool:
        """Return True if the process has died by itself; it is not reaped yet, so its id is still its own."""
        if self._kept.keeper.has_ended():
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
        process = self._process()
        if process is None:
            return 0.0
        with suppress(psutil.NoSuchProcess):
            times = process.cpu_times()
            return float(times.user + times.system)
        return 0.0

    def used_memory(self) -> int:
        """Measure the memory of all processes of the candidate, shared memory included (bytes)."""
        return memory_of_descendants(self._kept.keeper.pid)

    def free_memory(self) -> int:
        """Return what limits of the system leave the process to allocate (bytes)."""
        process = self._kept.process_id
        return sys.maxsize if process is None else free_memory_of(process)

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
        self.drain_output()
        return self._tail.decode(errors="replace")

    def stack(self) -> str:
        """Have the process print where it is, and return that."""
        self.forget_output()
        process = self._process()
        if process is None or self.has_ended():
            return ""
        process.send_signal(STACK_SIGNAL)
        deadline = time.monotonic() + _STACK_PATIENCE
        quiet = 0
        # Nothing marks the end of a stack: it is complete when three looks in a row bring nothing new.
        while quiet < 3 and time.monotonic() < deadline:
            time.sleep(0.02)
            before = self._tail
            self.drain_output()
            quiet = quiet + 1 if before and before == self._tail else 0
        return self.last_output()

    def exit_status(self) -> int:
        """End the process if it still lives, and return how it ended."""
        self.end()
        return self._kept.exit_status()

    def end_in_peace(self) -> None:
        """Wait a moment for the process to end by itself, then end it."""
        self._channel.close()
        deadline = time.monotonic() + _PATIENCE
        while not self.has_ended() and time.monotonic() < deadline:
            self.drain_output()
            time.sleep(0.005)
        self.end()


def _end(kept: KeptProcess, channel: socket.socket, output: FileIO) -> None:
    kept.end()
    channel.close()
    output.close()
