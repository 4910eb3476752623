"""A worker process that ends when the process that started it has ended, however that came about."""

from __future__ import annotations

import os
import sys

from drivegate.isolation.system_calls import die_with_parent


def end_with_parent(parent: int) -> None:
    """Ask Linux to kill this process when its parent dies, also from within an endless loop.

    Elsewhere the process ends when it next waits for a message.
    """
    if sys.platform.startswith("linux"):
        die_with_parent()
    # A parent outside of this process's table has the number 0.
    if os.getppid() not in (parent, 0):
        os._exit(1)
