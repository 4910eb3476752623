"""Cycles of instructions on a Cortex-M4 with its floating-point unit.

They are those of the tables of instructions in the Cortex-M4 Processor Technical Reference Manual, without wait states.
Where the manual has a range, such as 2 to 12 for a division, it is the greatest of it. A load or store counts 2,
although those of neighbours overlap. Encodings are those of the Armv7-M Architecture Reference Manual, chapter A5.
"""

from __future__ import annotations

from typing import Final

from drivegate.candidates.elf.image import halfwords_of

CORE: Final = "CORTEX_M4"
"""The core, by its name in images, whose cycles these are."""
REFILL: Final = 3
"""Further cycles of a branch that is taken, which refills the pipeline."""
_DIVISION: Final = 12
_FLOATING_DIVISION: Final = 14
_FUSED: Final = 3
_ACCESS: Final = 2


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
