"""Kernels that are compiled before anything runs, and a line that says so, since it takes a while."""

from __future__ import annotations

import sys
from collections.abc import Iterable

from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.gate.warm_up import compile_kernels, uncompiled_kinds
from drivegate.output.streams import write_to
from drivegate_cases.drive.drive_document import DriveDocument


def with_compiled_kernels(drives: Iterable[DriveDocument]) -> None:
    """Compile the kernels of some drives' kinds unless they are kept from before.

    A process that compiles a kernel itself may round otherwise, in the last digit, than one that loads it.
    """
    kinds = uncompiled_kinds(drives)
    if kinds:
        write_to(sys.stderr, f"{compiling_in_words(kinds)}\n")
        compile_kernels(kinds)


def compiling_in_words(kinds: Iterable[str]) -> str:
    """State what is compiled and how long it takes; kinds are compiled at the same time."""
    times = " and ".join(f"about {DRIVE_KINDS[kind].compiling_s} s for {kind} drives" for kind in kinds)
    return f"compiling the kernels, which is done once and takes {times} on 2 processors"
