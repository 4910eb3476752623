"""Kernels that are compiled before anything runs, and a line that says so, since it takes a while."""

from __future__ import annotations

import sys

from drivegate.gate.warm_up import compile_kernels, missing_marker
from drivegate.output.streams import write_to


def with_compiled_kernels() -> None:
    """Compile the kernels unless they are kept from before.

    A process that compiles a kernel itself may round otherwise, in the last digit, than one that loads it.
    """
    marker = missing_marker()
    if marker is not None:
        write_to(sys.stderr, "compiling the kernels, which is done once and takes about half a minute\n")
        compile_kernels(marker)
