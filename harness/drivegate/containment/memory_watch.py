"""The memory of a candidate and of all that it starts: what no limit of a single process counts."""

import os
from contextlib import suppress
from pathlib import Path
from typing import Final

WATCHED_EVERY: Final = 0.25
"""Time between two looks at the memory of a candidate's processes (s)."""

_PAGE: Final = os.sysconf("SC_PAGE_SIZE")


class MemoryWatch:
    """Follows the memory of a candidate's processes beyond what they had at the start."""

    def __init__(self, allowed: int, at_start: int) -> None:
        self._allowed = allowed
        self._at_start = at_start
        self._next = 0.0

    def is_due(self, now: float) -> bool:
        """Return True if it is time to measure again."""
        if now < self._next:
            return False
        self._next = now + WATCHED_EVERY
        return True

    def excess(self, used: int) -> str | None:
        """Describe a use of more memory than is allowed; None if it is not."""
        if used - self._at_start <= self._allowed:
            return None
        return f"the candidate's processes used more than {self._allowed / 2**30:g} GiB of memory"


def memory_of_descendants(ancestor: int) -> int:
    """Measure the memory of all processes that came from one, each shared page in parts (bytes).

    Adding up what each process has in memory takes no time, but counts shared pages several times. Only where that is
    a lot are the parts worth their time.
    """
    processes = _descendants(ancestor)
    resident = sum(map(_resident, processes))
    if resident < _LITTLE:
        return resident
    return sum(map(_proportional, processes))


_LITTLE: Final = 2**30


def _descendants(ancestor: int) -> list[int]:
    """List the processes that came from one."""
    found = [ancestor]
    for process in found:
        with suppress(OSError, ValueError):
            for children in Path(f"/proc/{process}/task").glob("*/children"):
                found.extend(map(int, children.read_text(encoding="ascii").split()))
    return found[1:]


def _resident(process: int) -> int:
    with suppress(OSError, ValueError, IndexError):
        return int(Path(f"/proc/{process}/statm").read_text(encoding="ascii").split()[1]) * _PAGE
    return 0


def _proportional(process: int) -> int:
    """Measure the memory of a process, each shared page divided by the number of its users."""
    with suppress(OSError, ValueError, IndexError):
        for line in Path(f"/proc/{process}/smaps_rollup").read_text(encoding="ascii").splitlines():
            if line.startswith("Pss:"):
                return int(line.split()[1]) * 1024
    return _resident(process)
