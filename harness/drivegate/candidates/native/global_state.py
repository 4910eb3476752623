"""The global and static variables of a loaded library, put back to what they were after loading."""

from __future__ import annotations

import ctypes
import mmap
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

_LOADED: Final = 1
_RELOCATED_ONCE: Final = 0x6474E552
_WRITABLE: Final = 2


class _Segment(ctypes.Structure):
    """A program header (System V ABI, "Program Header", for 64 bits)."""

    _fields_ = (
        ("kind", ctypes.c_uint32),
        ("flags", ctypes.c_uint32),
        ("offset", ctypes.c_uint64),
        ("address", ctypes.c_uint64),
        ("physical", ctypes.c_uint64),
        ("size_in_file", ctypes.c_uint64),
        ("size", ctypes.c_uint64),
        ("alignment", ctypes.c_uint64),
    )


class _Loaded(ctypes.Structure):
    """What the dynamic linker says of a loaded object, `dl_phdr_info` of its manual."""

    _fields_ = (
        ("base", ctypes.c_uint64),
        ("name", ctypes.c_char_p),
        ("segments", ctypes.POINTER(_Segment)),
        ("count", ctypes.c_uint16),
    )


class GlobalState:
    """A copy of a library's variables, as its loading has left them.

    A controller whose state is in globals starts from it at every reset, as firmware does at power-on, where start-up
    code writes `.data` and `.bss` before `main`. Memory that the library allocates is not part of it, and a system
    whose dynamic linker does not list its objects has none.
    """

    def __init__(self, library: Path) -> None:
        ranges = _variables(library)
        self.size = sum(end - begin for begin, end in ranges)
        """Size of the variables (bytes)."""
        self._memory = tuple(_view(begin, end) for begin, end in ranges)
        # Nothing is copied before the first reset, since a size that is refused may be too large for a copy.
        self._copies: tuple[NDArray[np.uint8], ...] | None = None

    def restore(self) -> None:
        """Store the variables at the first call, and write them back at each later one."""
        if self._copies is None:
            self._copies = tuple(view.copy() for view in self._memory)
        for view, copy in zip(self._memory, self._copies, strict=True):
            view[:] = copy


def _view(begin: int, end: int) -> NDArray[np.uint8]:
    """Return the bytes of this process from one address to another, shape (end - begin,)."""
    return np.ctypeslib.as_array((ctypes.c_uint8 * (end - begin)).from_address(begin))


def _variables(library: Path) -> list[tuple[int, int]]:
    """Return the ranges of addresses that hold a loaded library's variables."""
    found: list[tuple[int, int]] = []

    def visit(loaded: Any, _size: int, _data: Any) -> int:
        if (loaded.contents.name or b"").decode(errors="surrogateescape") == str(library):
            found.extend(_writable(loaded.contents))
        return 0

    iterate = getattr(ctypes.CDLL(None), "dl_iterate_phdr", None)
    if iterate is not None:
        visitor = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(_Loaded), ctypes.c_size_t, ctypes.c_void_p)
        iterate(visitor(visit), None)
    return found


def _writable(loaded: Any) -> list[tuple[int, int]]:
    segments = [loaded.segments[place] for place in range(loaded.count)]
    # The dynamic linker makes whole pages of these read-only once it has filled them in.
    fixed_until = max(
        (
            _whole_pages(loaded.base + segment.address + segment.size)
            for segment in segments
            if segment.kind == _RELOCATED_ONCE
        ),
        default=0,
    )
    ranges = [
        (max(loaded.base + segment.address, fixed_until), loaded.base + segment.address + segment.size)
        for segment in segments
        if segment.kind == _LOADED and segment.flags & _WRITABLE
    ]
    return [(begin, end) for begin, end in ranges if begin < end]


def _whole_pages(address: int) -> int:
    return address - address % mmap.PAGESIZE
