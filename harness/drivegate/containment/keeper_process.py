"""A keeper as a process that the harness has started: in a new Python, or as a copy of a template."""

import os
import select
import signal
import subprocess
import time
from contextlib import suppress
from typing import Final

# The template reaps at once; this only bounds the wait for a template that is stopped or dead.
_PATIENCE: Final = 1.0


class NewKeeper:
    """A keeper in a Python of its own."""

    def __init__(self, process: "subprocess.Popen[bytes]") -> None:
        self._process = process
        self.pid = process.pid

    def has_ended(self) -> bool:
        """Return True if the process has ended."""
        return self._process.poll() is not None

    def ends_within(self, seconds: float) -> bool:
        """Wait for the process to end, at most for some time, and return True if it has."""
        with suppress(subprocess.TimeoutExpired):
            self._process.wait(seconds)
        return self.has_ended()

    def send(self, number: signal.Signals) -> None:
        """Send a signal, unless the process has ended."""
        self._process.send_signal(number)


class CopiedKeeper:
    """A keeper that a template has started; its descriptor names it, whatever process gets its number later."""

    def __init__(self, pid: int, descriptor: int) -> None:
        self.pid = pid
        self._descriptor = descriptor

    def has_ended(self) -> bool:
        return self.ends_within(0.0)

    def ends_within(self, seconds: float) -> bool:
        if self._descriptor >= 0:
            poll = select.poll()
            poll.register(self._descriptor, select.POLLIN)
            # A descriptor of a process becomes readable when the process ends.
            if not poll.poll(seconds * 1000.0):
                return False
            self._wait_for_template()
            os.close(self._descriptor)
            self._descriptor = -1
        return True

    def send(self, number: signal.Signals) -> None:
        if self._descriptor >= 0:
            with suppress(ProcessLookupError):
                signal.pidfd_send_signal(self._descriptor, number)

    def _wait_for_template(self) -> None:
        """Wait a moment for the template to reap the process, which nobody should find in a list any more."""
        until = time.monotonic() + _PATIENCE
        with suppress(ProcessLookupError):
            while time.monotonic() < until:
                # Signal 0 sends nothing, and fails once the process has been reaped.
                signal.pidfd_send_signal(self._descriptor, 0)
                time.sleep(0.0005)


KeeperProcess = NewKeeper | CopiedKeeper
"""A running keeper. Its process id stays its own until it has ended."""
