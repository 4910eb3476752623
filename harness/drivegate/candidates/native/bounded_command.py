"""Running a tool of the system on files that may be hostile: within bounds of time, memory and output."""

import os
import signal
import subprocess
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from math import ceil
from multiprocessing.connection import wait
from pathlib import Path
from typing import Final

KEPT_OUTPUT: Final = 64 * 1024
"""Bytes that are kept of the beginning and of the end of what a tool prints; it may print more."""

# To end processes takes some milliseconds each; a tool that is not isolated may ignore the request.
_PATIENCE: Final = 5.0

# The shell sets the limits before the tool starts, which no other process can do in time. Sizes are in KiB and in
# blocks of 512 bytes; not every system can limit the memory.
_LIMITED: Final = (
    'ulimit -t "$1"; ulimit -v "$2" 2>/dev/null; ulimit -f "$3"; ulimit -c 0; shift 3; exec "$@"'
)

# What decides where a compiler finds its parts, headers and libraries; no secret of a CI job is among them.
_PASSED: Final = frozenset(
    (
        "PATH",
        "HOME",
        "CPATH",
        "C_INCLUDE_PATH",
        "LIBRARY_PATH",
        "LD_LIBRARY_PATH",
        "COMPILER_PATH",
        "SDKROOT",
        "CARGO_HOME",
        "RUSTUP_HOME",
        "RUSTUP_TOOLCHAIN",
    )
)


@dataclass(frozen=True)
class Bounds:
    seconds: float = 60.0
    """Time, and processor time of each of its processes (s)."""
    memory_bytes: int = 2 * 2**30
    """Memory of each of its processes."""
    file_bytes: int = 64 * 2**20
    """Size of each file that it writes."""

    def in_words(self) -> str:
        memory, file = self.memory_bytes / 2**30, self.file_bytes / 2**20
        return f"{self.seconds:g} s, {memory:g} GiB of memory and files of {file:g} MiB"


COMPILATION: Final = Bounds()
_QUESTION: Final = Bounds(20.0)


@dataclass(frozen=True)
class Ended:
    status: int | None
    """Exit status, negative for a signal; None when it was stopped because its time was up."""
    output: str
    """The beginning and the end of what it printed."""


def run_bounded(
    words: Sequence[str], *, folder: Path, environment: Mapping[str, str], bounds: Bounds
) -> Ended:
    """Run a tool to its end, or to that of its time."""
    # The processor time is for what escapes from the process group.
    processor = ceil(bounds.seconds) + 1
    limits = (str(processor), str(bounds.memory_bytes // 1024), str(bounds.file_bytes // 512))
    deadline = time.monotonic() + bounds.seconds
    process = subprocess.Popen(
        ["/bin/sh", "-c", _LIMITED, "sh", *limits, *words],
        cwd=folder,
        env={
            **{name: value for name, value in os.environ.items() if name in _PASSED},
            **environment,
        },
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        # One signal to its group ends what does not end by itself.
        start_new_session=True,
    )
    with process:
        try:
            output = _output_of(process, deadline)
            with suppress(subprocess.TimeoutExpired):
                process.wait(max(deadline - time.monotonic(), 0.0))
            status = process.returncode
        finally:
            _end(process)
            # Also after its end: it may have left processes in its group.
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(process.pid, signal.SIGKILL)
    return Ended(status, output.decode(errors="replace"))


def asked(words: Sequence[str], folder: Path | None = None) -> Ended:
    """Run a tool that states something of itself, such as its version, in a folder or here."""
    return run_bounded(words, folder=folder or Path.cwd(), environment={"LC_ALL": "C"}, bounds=_QUESTION)


def _end(process: "subprocess.Popen[bytes]") -> None:
    """Have an isolated tool end all that came from it, also what has left its group."""
    if process.poll() is None:
        process.terminate()
        with suppress(subprocess.TimeoutExpired):
            process.wait(_PATIENCE)


def _output_of(process: "subprocess.Popen[bytes]", deadline: float) -> bytes:
    """Read to the end, so that the tool never waits for a reader, but keep only what is bounded."""
    if process.stdout is None:
        return b""
    descriptor = process.stdout.fileno()
    beginning = end = b""
    while wait([descriptor], max(deadline - time.monotonic(), 0.0)):
        block = os.read(descriptor, 65536)
        if not block:
            break
        left = KEPT_OUTPUT - len(beginning)
        beginning, end = beginning + block[:left], (end + block[left:])[-KEPT_OUTPUT:]
    return beginning + end
