"""Memory of exactly one size, so that a sanitizer finds what goes beyond it."""

from __future__ import annotations

import ctypes
import weakref


class ExactMemory:
    """Zeroed memory from the C library; numpy's may be longer than it was asked for.

    `address`: valid as long as this object lives.
    """

    def __init__(self, size: int, alignment: int = 16) -> None:
        library = ctypes.CDLL(None)
        allocate, release = library.posix_memalign, library.free
        allocate.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_size_t)
        release.argtypes, release.restype = (ctypes.c_void_p,), None
        pointer = ctypes.c_void_p()
        if allocate(ctypes.byref(pointer), alignment, size) or pointer.value is None:
            raise MemoryError
        self.address: int = pointer.value
        ctypes.memset(self.address, 0, size)
        weakref.finalize(self, release, self.address)
