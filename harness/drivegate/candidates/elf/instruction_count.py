"""Counting the instructions of an emulated target, by a C function that the emulator calls before each block."""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numba
import numpy as np
from numba import types
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from drivegate.candidates.elf.image import Image

COUNT, SEGMENTS = range(2)
"""Words of the counter: the instructions so far, and the number of pieces of code."""
_FIRST_PIECE: Final = 2
_WORDS_PER_PIECE: Final = 3
_LARGEST_CODE: Final = 2**22


def counter(image: Image) -> NDArray[np.int64]:
    """Return the memory of `counting_function`, which gets its address.

    Parameters
    ----------
    image : Image
        What runs on the target.

    Returns
    -------
    ndarray, shape (n,)
        The count, the pieces of code (first address, address after the last, place of the table), and for each
        halfword of their code the number of instructions from there to the end of the piece.
    """
    code = [each for each in image.segments if each.is_executable and each.size <= _LARGEST_CODE]
    tables = [_instructions_to_the_end(each.content) for each in code]
    begin = _FIRST_PIECE + len(code) * _WORDS_PER_PIECE
    head = np.zeros(begin, np.int64)
    head[SEGMENTS] = len(code)
    for number, (segment, table) in enumerate(zip(code, tables, strict=True)):
        first = _FIRST_PIECE + number * _WORDS_PER_PIECE
        head[first : first + _WORDS_PER_PIECE] = (
            segment.address,
            segment.address + 2 * (table.size - 1),
            begin,
        )
        begin += table.size
    return np.concatenate((head, *tables))


@cache
def _instructions_to_the_end(code: bytes) -> NDArray[np.int64]:
    """Return for each halfword how many instructions follow if one begins there, shape (halfwords + 1,)."""
    halfwords = np.frombuffer(code[: len(code) & ~1], "<u2")
    # An instruction of 32 bits begins with 11101, 11110 or 11111 (Armv7-M Architecture Reference Manual, A5.1).
    lengths = np.where(halfwords >> 11 >= 0b11101, 2, 1).tolist()
    following = [0] * (len(lengths) + 2)
    for place in range(len(lengths) - 1, -1, -1):
        following[place] = 1 + following[place + lengths[place]]
    return np.array(following[:-1])


@cache
def counting_function() -> Any:
    """Compile the C function that the emulator calls before each block of instructions."""

    def count_block(_engine: int, address: int, size: int, state: Any) -> None:
        # The emulator calls with the length of a block; the shape of the array is not used for bounds.
        words = carray(state, 2**40)
        for piece in range(words[SEGMENTS]):
            place = _FIRST_PIECE + piece * _WORDS_PER_PIECE
            if words[place] <= address and address + size <= words[place + 1]:
                # From each of its instructions on, the same ones follow up to the end of the piece.
                halfword = words[place + 2] + (address - words[place]) // 2
                words[COUNT] += words[halfword] - words[halfword + size // 2]
                return

    pointer: Any = types.CPointer
    signature = types.void(types.intp, types.int64, types.int32, pointer(types.int64))
    return numba.cfunc(signature)(count_block)
