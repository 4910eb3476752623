"""Memory of a target: pages, each of which is mapped once, and what is laid into them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

PAGE: Final = 4096
"""Size of a page (bytes)."""
ADDRESSES: Final = 2**32
"""Number of addresses."""


class Stretch(NamedTuple):
    """Addresses with the same rights."""

    address: int
    size: int
    is_writable: bool
    is_executable: bool


@dataclass(frozen=True)
class Area:
    """Neighboring pages, which are one array of this machine."""

    address: int
    content: NDArray[np.uint8]
    """Shape (bytes,)."""
    stretches: tuple[Stretch, ...]
    """The pages, those of equal rights together."""

    def has(self, address: int, size: int) -> bool:
        return self.address <= address and address + size <= self.address + self.content.size


def areas_of(stretches: Iterable[Stretch]) -> tuple[Area, ...]:
    """Make the pages that stretches need, with the rights of all stretches that are in a page."""
    areas: list[list[Stretch]] = []
    for stretch in _in_pages(stretches):
        if areas and areas[-1][-1].address + areas[-1][-1].size == stretch.address:
            areas[-1].append(stretch)
        else:
            areas.append([stretch])
    return tuple(_area(area) for area in areas)


def _in_pages(stretches: Iterable[Stretch]) -> Iterator[Stretch]:
    """Sweep over the addresses, and return runs of whole pages that differ in their rights."""
    changes: dict[int, NDArray[np.int64]] = {}
    for each in stretches:
        rights = np.array((1, each.is_writable, each.is_executable), np.int64)
        begin, end = each.address & -PAGE, -(-(each.address + each.size) // PAGE) * PAGE
        for place, sign in ((begin, 1), (end, -1)):
            changes[place] = changes.get(place, np.zeros(3, np.int64)) + sign * rights
    present = np.zeros(3, np.int64)
    last: Stretch | None = None
    for begin, end in pairwise(sorted(changes)):
        present = present + changes[begin]
        has_memory, is_writable, is_executable = (present > 0).tolist()
        run = Stretch(begin, end - begin, is_writable, is_executable)
        if not has_memory:
            continue
        if last is not None and last.address + last.size == begin and last[2:] == run[2:]:
            last = last._replace(size=last.size + run.size)
            continue
        if last is not None:
            yield last
        last = run
    if last is not None:
        yield last


def _area(stretches: list[Stretch]) -> Area:
    begin, end = stretches[0].address, stretches[-1].address + stretches[-1].size
    # The emulator maps only memory that begins at a page, which numpy does not promise.
    memory = np.zeros(end - begin + PAGE, np.uint8)
    return Area(begin, memory[-memory.ctypes.data % PAGE :][: end - begin], tuple(stretches))


def memory_at(areas: Iterable[Area], address: int, size: int) -> NDArray[np.uint8]:
    """Return memory of the target, which changes with it; raises KeyError where there is none."""
    for area in areas:
        if area.has(address, size):
            return area.content[address - area.address :][:size]
    raise KeyError(address)
