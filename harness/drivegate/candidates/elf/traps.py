"""What the processor traps and the emulator does not: accesses that are not aligned, and divisions by zero.

The emulator calls a compiled function before instructions, which looks up the rule of each. Encodings are those of the
Armv6-M and Armv7-M Architecture Reference Manuals, chapter A5 and the sections of the instructions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache
from typing import Any, Final, NamedTuple

import numpy as np
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from drivegate.candidates.elf.emulator import arm_const, called_by_emulator, read_register, stop
from drivegate.candidates.elf.image import Image, halfwords_of
from drivegate_models.compilation.calling import copy_bytes
from drivegate_models.compilation.kernels import inlined

CONTROL_REGISTER: Final = 0xE000_ED14
"""Address of the register CCR, which enables the trap of divisions."""
_DIVISION_TRAPS: Final = 1 << 4

PLACE, OPERAND, MASK = range(3)
"""Words of what has ended a call: address of the instruction, the address that it accesses, and the bits of that which
must be zero, 0 for a division; all are 0 where nothing has. The last word may also be one of the two below."""
ENDLESS, WILD_POINTER = -1, -2
"""In the place of the bits: a call that does not come to its end; a stub that fills what a wild pointer points to,
whose row of the program is the operand."""

# Words that the compiled function gets. After them, it has for each halfword of the code the place of a row or 0, and
# then the rows.
_CONTROL, _TRAPPED, _OWN, _SCRATCH, _BEGIN, _TABLE = range(3, 9)
_FIRST, _SECOND, _ROW_MASK, _CONDITION = range(4)
_ROW_WORDS: Final = 4

_ALWAYS: Final = 14
_NONE: Final = -1
_SP, _PC = 13, 15
_LOWEST_MASKS: Final = (3, 1, 0, 0, 3, 1, 0, 1)
"""Masks of STR, STRH, STRB, LDRSB, LDR, LDRH, LDRB and LDRSH with a register as the offset."""

Rule = tuple[int, int, int]
"""The mask, the register of the address or divisor, and the register that is added to it or -1."""


class Trap(NamedTuple):
    place: int
    """Its address."""
    rule: Rule
    condition: int
    """Condition under which it is executed, as the instruction IT encodes it."""

    @property
    def is_division(self) -> bool:
        """Return True for a division, which traps only where the target enables that."""
        return self.rule[0] == 0


def traps_of(image: Image) -> tuple[Trap, ...]:
    """List the instructions of an image's functions that may trap on its processor."""
    found = (
        trap for name, start in image.functions.items() for trap in _within(image, start, image.sizes[name])
    )
    # Two names of one function list its instructions twice.
    return tuple(dict.fromkeys(found))


def _within(image: Image, start: int, size: int) -> Iterator[Trap]:
    code: list[int] = next(
        (
            np.frombuffer(each.content[start - each.address :][: size & ~1], "<u2").tolist()
            for each in image.segments
            if each.address <= start and start + size <= each.address + len(each.content)
        ),
        [],
    )
    place, conditions = 0, list[int]()
    while place < len(code):
        first, second = code[place], (*code[place + 1 : place + 2], 0)[0]
        length = halfwords_of(first)
        condition = conditions.pop(0) if conditions else _ALWAYS
        conditions = conditions or _conditions(first)
        rule = (
            _rule_of_long(first, second) if length == 2 else _rule_of_short(first, image.core == "CORTEX_M0")
        )
        if rule is not None and rule[1] not in (_SP, _PC):
            yield Trap(start + 2 * place, rule, condition)
        place += length


def _conditions(half: int) -> list[int]:
    """Return the conditions of the instructions that follow an instruction IT; none for any other one."""
    first, pattern = half >> 4 & 0xF, half & 0xF
    if half >> 8 != 0xBF or not pattern:
        return []
    further = 4 - (pattern & -pattern).bit_length()
    return [first, *((first & 0xE) | (pattern >> (3 - number) & 1) for number in range(further))]


def _rule_of_short(half: int, is_strict: bool) -> Rule | None:
    """Return the rule of an instruction of 16 bits; Armv6-M permits no access that is not aligned."""
    base = half >> 3 & 7
    if half >> 12 == 0b1100:
        return 3, half >> 8 & 7, _NONE
    if not is_strict:
        return None
    if half >> 12 == 0b0101:
        mask = _LOWEST_MASKS[half >> 9 & 7]
        return (mask, base, half >> 6 & 7) if mask else None
    # The offset is a multiple of the size.
    masks = {0b0110: 3, 0b1000: 1}
    return (masks[half >> 12], base, _NONE) if half >> 12 in masks else None


def _rule_of_long(first: int, second: int) -> Rule | None:
    """Return the rule of an instruction of 32 bits; offsets of those that must be aligned are multiples of 4."""
    base = first & 0xF
    if first & 0xFFD0 == 0xFB90 and second & 0xF0F0 == 0xF0F0:
        return 0, second & 0xF, _NONE
    is_double = first & 0xFE40 == 0xE840 and bool(first & 0x0120)
    is_multiple = first & 0xFE40 == 0xE800 and first >> 7 & 3 in (1, 2)
    is_floating = first & 0xFE00 == 0xEC00 and second & 0x0E00 == 0x0A00 and first & 0xFFE0 != 0xEC40
    return (3, base, _NONE) if is_double or is_multiple or is_floating else None


def rules_of(traps: Sequence[Trap], trapped: NDArray[np.int64], control: int = 0) -> NDArray[np.int64]:
    """Return what the compiled function gets, shape (words,).

    `traps`: at least one. `trapped`: words that state what has trapped. `control`: address of CCR in the memory of this
    machine, which divisions need.
    """
    places = [trap.place for trap in traps]
    begin, rows = min(places), _TABLE + (max(places) - min(places)) // 2 + 1
    words = np.zeros(rows + len(traps) * _ROW_WORDS, np.int64)
    words[_CONTROL], words[_TRAPPED], words[_OWN] = control, trapped.ctypes.data, words.ctypes.data
    words[_BEGIN] = begin
    for number, (place, rule, condition) in enumerate(traps):
        row = rows + number * _ROW_WORDS
        words[_TABLE + (place - begin) // 2] = row
        mask, words[row + _FIRST], words[row + _SECOND] = rule
        words[row + _ROW_MASK], words[row + _CONDITION] = mask, condition
    return words


@cache
def trapping_function() -> Any:
    """Compile the C function that the emulator calls before instructions, those with a rule among them."""
    first_register, flags_register = arm_const.UC_ARM_REG_R0, arm_const.UC_ARM_REG_APSR

    def check_instruction(engine: int, address: int, _size: int, state: Any) -> None:
        # The emulator calls for the range that it was given; the shape of the array is not used for bounds.
        words = carray(state, 2**40)
        row = words[_TABLE + (address - words[_BEGIN]) // 2]
        if row == 0:
            return
        scratch, mask = words[_OWN] + 8 * _SCRATCH, words[row + _ROW_MASK]
        words[_SCRATCH] = 0
        if mask == 0:
            copy_bytes(words[_CONTROL], scratch, 4)
            if words[_SCRATCH] & _DIVISION_TRAPS == 0:
                return
            words[_SCRATCH] = 0
        read_register(engine, first_register + words[row + _FIRST], scratch)
        operand = words[_SCRATCH]
        if words[row + _SECOND] != _NONE:
            words[_SCRATCH] = 0
            read_register(engine, first_register + words[row + _SECOND], scratch)
            operand = (operand + words[_SCRATCH]) & 0xFFFF_FFFF
        if (operand & mask) == 0 and (mask != 0 or operand != 0):
            return
        if words[row + _CONDITION] != _ALWAYS:
            words[_SCRATCH] = 0
            read_register(engine, flags_register, scratch)
            if not _is_met(words[row + _CONDITION], words[_SCRATCH] >> 28):
                return
        words[PLACE], words[OPERAND], words[MASK] = address, operand, mask
        copy_bytes(words[_OWN], words[_TRAPPED], 8 * (MASK + 1))
        stop(engine)

    return called_by_emulator(check_instruction)


@inlined
def _is_met(condition: int, flags: int) -> bool:
    """Return True if the flags N, Z, C and V, the lowest last, meet a condition (section "Conditional execution")."""
    negative, zero = flags >> 3 & 1 == 1, flags >> 2 & 1 == 1
    carry, overflow = flags >> 1 & 1 == 1, flags & 1 == 1
    pair = condition >> 1
    if pair == 0:
        met = zero
    elif pair == 1:
        met = carry
    elif pair == 2:
        met = negative
    elif pair == 3:
        met = overflow
    elif pair == 4:
        met = carry and not zero
    elif pair == 5:
        met = negative == overflow
    elif pair == 6:
        met = negative == overflow and not zero
    else:
        return True
    return bool(met != (condition & 1 == 1))
