"""Instructions that wait for an interrupt or an event: the emulated target has neither, and goes on at once.

The emulator would end there. Encodings are those of the Armv7-M Architecture Reference Manual, chapter A5.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numpy as np
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from drivegate.candidates.elf.emulator import (
    arm_const,
    called_by_emulator,
    read_register,
    stop,
    write_register,
)
from drivegate.candidates.elf.image import Image
from drivegate_models.compilation.calling import copy_bytes

# YIELD, WFE and WFI of 16 bits, and the second halfwords of those of 32 bits.
_SHORT: Final = (0xBF10, 0xBF20, 0xBF30)
_LONG_FIRST: Final = 0xF3AF
_LONG: Final = (0x8001, 0x8002, 0x8003)
_WAIT_FOR_INTERRUPT: Final = (0xBF30, 0x8003)
_MOST: Final = 1000
"""Greatest number of places: more are no code."""

_OWN, _SIZE, _PAUSED_AT, _NEXT = range(4)
_WORDS: Final = 4


def waiting_at(image: Image) -> list[tuple[int, int, bool]]:
    """List the places that may be such an instruction: address, size (bytes), and whether it waits for an interrupt.

    Constants among the code look the same, which does not matter: they are not executed.
    """
    found: list[tuple[int, int, bool]] = []
    for segment in image.segments:
        if not segment.is_executable:
            continue
        halves = np.frombuffer(segment.content[: len(segment.content) & ~1], "<u2")
        before = np.concatenate(([0], halves[:-1]))
        short = np.isin(halves, _SHORT)
        long = np.isin(halves, _LONG) & (before == _LONG_FIRST)
        for place in np.flatnonzero(short | long).tolist():
            size = 4 if long[place] else 2
            address = segment.address + 2 * (place + 1) - size
            found.append((address, size, int(halves[place]) in _WAIT_FOR_INTERRUPT))
    return found[:_MOST]


def words_of(size: int, paused_at: NDArray[np.int64] | None) -> NDArray[np.int64]:
    """Return the words of one place.

    `size`: that of the instruction (bytes), 0 for a function, which is left. `paused_at`: shape (1,); where a step ends
    here, the address at which the next one goes on is written to it.
    """
    words = np.zeros(_WORDS, np.int64)
    words[_OWN], words[_SIZE] = words.ctypes.data, size
    words[_PAUSED_AT] = 0 if paused_at is None else paused_at.ctypes.data
    return words


@cache
def passing_function() -> Any:
    """Compile the C function that the emulator calls in the place of such an instruction."""
    link, counter = arm_const.UC_ARM_REG_LR, arm_const.UC_ARM_REG_PC

    def pass_instruction(engine: int, address: int, _size: int, state: Any) -> None:
        words = carray(state, _WORDS)
        following = words[_OWN] + 8 * _NEXT
        # The lowest bit selects the Thumb instruction set.
        words[_NEXT] = (address + words[_SIZE]) | 1
        if words[_SIZE] == 0:
            words[_NEXT] = 0
            read_register(engine, link, following)
        write_register(engine, counter, following)
        if words[_PAUSED_AT] != 0:
            copy_bytes(following, words[_PAUSED_AT], 8)
            stop(engine)

    return called_by_emulator(pass_instruction)
