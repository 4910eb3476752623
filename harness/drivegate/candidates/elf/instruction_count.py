"""Counting instructions and cycles of an emulated target, by a C function that the emulator calls before each block.

It also ends a call that has executed more than any step needs.

The cycles are those of a Cortex-M4 with its floating-point unit, from the tables of instructions in its Technical
Reference Manual, without wait states. Where the manual has a range, such as 2 to 12 for a division, they are the
greatest of it. A load or store counts 2, although those of neighbours overlap. Encodings are those of the Armv7-M
Architecture Reference Manual, chapter A5.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numpy as np
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from drivegate.candidates.elf.emulator import called_by_emulator, stop
from drivegate.candidates.elf.image import Image, halfwords_of
from drivegate.candidates.elf.traps import ENDLESS, MASK, PLACE
from drivegate_models.compilation.calling import copy_bytes

CORE: Final = "CORTEX_M4"
"""The core, by its name in images, whose cycles these are."""
REFILL: Final = 3
"""Further cycles of a branch that is taken, which refills the pipeline."""
_DIVISION: Final = 12
_FLOATING_DIVISION: Final = 14
_FUSED: Final = 3
_ACCESS: Final = 2

COUNT, BEHIND, SPENT, BUDGET, PIECES = range(5)
"""Words of the counter: the count so far, the address after the last block, the bytes of all blocks so far and the
greatest number of them, and the number of pieces of code. The first four are set before a call.

A count has the instructions in its lower 32 bits, and the cycles above them, so that both are added at once.
"""
SET_BY_CALLER: Final = 4
"""Number of words that are set before a call."""
CYCLE: Final = 2**32
LONGEST_INSTRUCTION: Final = 4
"""Size of the longest instruction (bytes)."""
_OWN, _ENDED, _SCRATCH = 5, 6, 7
_FIRST_PIECE: Final = _SCRATCH + MASK + 1
_WORDS_PER_PIECE: Final = 3
# The table has eight bytes for each halfword, so 16 MiB for this much code.
_LARGEST_CODE: Final = 2**22


def counter(image: Image, ended: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the memory of `counting_function`, which gets its address, shape (n,).

    `ended`: words that state what has ended a call. The memory has the counts, the pieces of code (first address,
    address after the last, place of the table), and for each halfword of their code the count from there to the end of
    the piece.
    """
    code = [each for each in image.segments if each.is_executable and each.size <= _LARGEST_CODE]
    tables = [_counts_to_the_end(each.content, has_cycles(image)) for each in code]
    begin = _FIRST_PIECE + len(code) * _WORDS_PER_PIECE
    head = np.zeros(begin, np.int64)
    head[PIECES] = len(code)
    for number, (segment, table) in enumerate(zip(code, tables, strict=True)):
        first = _FIRST_PIECE + number * _WORDS_PER_PIECE
        head[first : first + _WORDS_PER_PIECE] = (
            segment.address,
            segment.address + 2 * (table.size - 1),
            begin,
        )
        begin += table.size
    words = np.concatenate((head, *tables))
    words[_OWN], words[_ENDED] = words.ctypes.data, ended.ctypes.data
    return words


def has_cycles(image: Image) -> bool:
    """Return True if the cycles of the core are known."""
    return image.core == CORE


@cache
def _counts_to_the_end(code: bytes, with_cycles: bool) -> NDArray[np.int64]:
    """Return the count of what follows if an instruction begins at a halfword, shape (halfwords + 1,)."""
    halfwords = np.frombuffer(code[: len(code) & ~1], "<u2").tolist()
    counts = [0] * (len(halfwords) + 2)
    for place in range(len(halfwords) - 1, -1, -1):
        first, second = halfwords[place], (*halfwords[place + 1 : place + 2], 0)[0]
        cycles = cycles_of(first, second) if with_cycles else 0
        counts[place] = counts[place + halfwords_of(first)] + 1 + CYCLE * cycles
    return np.array(counts[:-1])


@cache
def counting_function() -> Any:
    """Compile the C function that the emulator calls before each block of instructions."""

    def count_block(engine: int, address: int, size: int, state: Any) -> None:
        # The emulator calls with the length of a block; the shape of the array is not used for bounds.
        words = carray(state, 2**40)
        words[SPENT] += size
        if words[SPENT] > words[BUDGET]:
            words[_SCRATCH + PLACE], words[_SCRATCH + MASK] = address, ENDLESS
            copy_bytes(words[_OWN] + 8 * _SCRATCH, words[_ENDED], 8 * (MASK + 1))
            stop(engine)
            return
        # A block that does not follow on the one before has been branched to.
        refill = 0 if address == words[BEHIND] else REFILL * CYCLE
        words[BEHIND] = address + size
        for piece in range(words[PIECES]):
            place = _FIRST_PIECE + piece * _WORDS_PER_PIECE
            # Blocks in code that the image does not have, such as code that is copied to RAM, are not counted.
            if words[place] <= address and address + size <= words[place + 1]:
                # From each of its instructions on, the same ones follow up to the end of the piece.
                halfword = words[place + 2] + (address - words[place]) // 2
                words[COUNT] += words[halfword] - words[halfword + size // 2] + refill
                return

    return called_by_emulator(count_block)


def cycles_of(first: int, second: int) -> int:
    """Return the cycles of an instruction from its halfwords, without those of a refill; `second` may be another's."""
    if halfwords_of(first) == 1:
        return _of_short(first)
    if first & 0xFC00 == 0xEC00 and second & 0x0E00 == 0x0A00:
        return _of_floating(first, second)
    if first & 0xFE40 == 0xE800:
        return 1 + second.bit_count()
    if first & 0xFE40 == 0xE840:
        is_double = first & 0x0120 and first & 0xFFF0 != 0xE8D0
        return 1 + 2 if is_double else _ACCESS
    if first & 0xFE00 == 0xF800:
        return _ACCESS
    is_division = first & 0xFFD0 == 0xFB90 and second & 0xF0F0 == 0xF0F0
    return _DIVISION if is_division else 1


def _of_short(half: int) -> int:
    if half & 0xF000 == 0xC000:
        return 1 + (half & 0xFF).bit_count()
    if half & 0xF600 == 0xB400:
        return 1 + (half & 0x1FF).bit_count()
    is_access = half >> 11 == 0b01001 or half >> 12 in (0b0101, 0b0110, 0b0111, 0b1000, 0b1001)
    return _ACCESS if is_access else 1


def _of_floating(first: int, second: int) -> int:
    if first & 0xFE00 == 0xEC00:
        if first & 0xFFE0 == 0xEC40:
            return 2
        is_single = first & 0x0120 == 0x0100
        words = (2 if second & 0x0100 else 1) if is_single else second & 0xFF
        return 1 + words
    if second & 0x0010:
        return 1
    operation = first & 0x00B0
    is_root = operation == 0x00B0 and first & 0xF == 1 and second & 0x00C0 == 0x00C0
    if operation == 0x0080 or is_root:
        return _FLOATING_DIVISION
    return _FUSED if operation in (0x0000, 0x0010, 0x0090, 0x00A0) else 1
