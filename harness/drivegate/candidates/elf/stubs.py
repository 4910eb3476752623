"""Functions of a target that do not run: what they return, and what they write, follows from expressions.

Arguments are where a call has them (Procedure Call Standard for the Arm Architecture, sections 6.4 and 6.5).
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from drivegate.candidates.elf.debug_information import (
    POINTER_SIZE,
    Typed,
    name_of,
    parameters_of,
    size_of,
    type_of,
)
from drivegate.candidates.elf.emulator import (
    arm_const,
    called_by_emulator,
    read_register,
    stop,
    write_register,
)
from drivegate.candidates.elf.evaluation import run_program
from drivegate.candidates.elf.expression import DEEPEST
from drivegate.candidates.elf.traps import MASK, OPERAND, PLACE, WILD_POINTER
from drivegate.candidates.elf.variables import FLOAT, Number, Variables
from drivegate_models.compilation.calling import copy_bytes

# Words of a function that is answered. The answering function also reads the link register into the word after the
# value, so that the value, of up to 64 bits, remains.
_OWN, _REGISTERS, _VALUE, _UPPER, _PROGRAM, _AREAS, _ENDED, _TAKES = range(8)
_STACK_POINTER, _CORE = 8, 9
_FLOATING: Final = _CORE + 2
_STACK: Final = _FLOATING + 8
WORDS: Final = _STACK + DEEPEST
R0, R0_R1, S0, D0 = range(4)
"""Registers that a function returns its value in."""
_CORE_WORDS, _FLOATING_WORDS = 4, 16
_COMPOSITE: Final = ("DW_TAG_structure_type", "DW_TAG_class_type", "DW_TAG_union_type")


@dataclass(frozen=True)
class Parameter:
    typed: Typed
    where: Number
    """Where it is while the function is answered: in the words, or beyond a stack pointer that is there."""


class Answer:
    """The words of a function that is answered, which must live as long as the emulator."""

    def __init__(self, areas: NDArray[np.float64], ended: NDArray[np.int64]) -> None:
        self.words = np.zeros(WORDS, np.int64)
        self.words[_OWN] = self.words.ctypes.data
        self.words[_AREAS], self.words[_ENDED] = areas.ctypes.data, ended.ctypes.data
        self._program: NDArray[np.float64] | None = None

    def value(self, form: int, size: int, in_floating: bool) -> Number:
        """Return where its value is stored, and note the registers for it."""
        is_float = form == FLOAT and in_floating
        self.words[_REGISTERS] = (D0 if size == 8 else S0) if is_float else R0_R1 if size == 8 else R0
        # A narrow integer fills its register.
        return Number(self._address(_VALUE), form, max(size, 4))

    def run(self, program: NDArray[np.float64], *, takes: bool) -> None:
        """Run a program at each call; `takes`: whether it needs what is passed."""
        self._program = program
        self.words[_PROGRAM], self.words[_TAKES] = program.ctypes.data, int(takes)

    def parameters(self, function: str, variables: Variables) -> dict[str, Parameter]:
        """Find the parameters of the function by their names, those after a structure apart."""
        described = variables.function(function)
        in_floating = variables.passes_floats_in_registers
        answered = type_of(described, variables.types)
        is_composite = answered is not None and answered.described.tag in _COMPOSITE
        # A large structure is returned in memory, whose address is passed before all parameters.
        has_hidden = is_composite and size_of(answered) > POINTER_SIZE
        places = _places(int(has_hidden), in_floating)
        next(places)
        found = {}
        for each in parameters_of(described):
            typed = type_of(each, variables.types)
            if typed is None or typed.lengths or typed.described.tag in _COMPOSITE:
                break
            size = size_of(typed)
            encoding = typed.described.attributes.get("DW_AT_encoding")
            is_float = encoding is not None and encoding.value == 4
            kind, place = places.send((size, is_float))
            found[name_of(each)] = Parameter(typed, self._where(kind, place))
        return found

    def _where(self, kind: str, place: int) -> Number:
        if kind == "stack":
            return Number(self._address(_STACK_POINTER), 0, 0, (place,))
        return Number(self._address(_CORE if kind == "core" else _FLOATING) + 4 * place, 0, 0)

    def _address(self, word: int) -> int:
        return int(self.words.ctypes.data) + 8 * word


def _places(core: int, in_floating: bool) -> Generator[tuple[str, int], tuple[int, bool], None]:
    """Take size and kind of one parameter after the other, and return where it is passed: a kind and a place."""
    free = list(range(_FLOATING_WORDS)) if in_floating else []
    stack, place = 0, ("core", 0)
    while True:
        size, is_float = yield place
        words = max(1, -(-size // 4))
        if is_float and in_floating:
            begins = [each for each in free if each % words == 0 and each + words - 1 in free]
            if begins:
                place = ("floating", begins[0])
                free = [each for each in free if not begins[0] <= each < begins[0] + words]
                continue
            free = []
        else:
            core += core % 2 if words == 2 else 0
            if core + words <= _CORE_WORDS:
                place = ("core", core)
                core += words
                continue
            core = _CORE_WORDS
        stack += stack % 8 if words == 2 else 0
        place = ("stack", stack)
        stack += 4 * words


@cache
def answering_function() -> Any:
    """Compile the C function that the emulator calls in the place of a function of the target."""
    low, high, third, fourth = (getattr(arm_const, f"UC_ARM_REG_R{number}") for number in range(4))
    single, double = arm_const.UC_ARM_REG_S0, arm_const.UC_ARM_REG_D0
    link, counter, pointer = arm_const.UC_ARM_REG_LR, arm_const.UC_ARM_REG_PC, arm_const.UC_ARM_REG_SP

    def answer(engine: int, address: int, _size: int, state: Any) -> None:
        words = carray(state, WORDS)
        own = words[_OWN]
        value, registers = own + 8 * _VALUE, words[_REGISTERS]
        if words[_TAKES] != 0:
            words[_STACK_POINTER] = 0
            read_register(engine, pointer, own + 8 * _STACK_POINTER)
            read_register(engine, low, own + 8 * _CORE)
            read_register(engine, high, own + 8 * _CORE + 4)
            read_register(engine, third, own + 8 * _CORE + 8)
            read_register(engine, fourth, own + 8 * _CORE + 12)
            for number in range(_FLOATING_WORDS):
                read_register(engine, single + number, own + 8 * _FLOATING + 4 * number)
        if words[_PROGRAM] != 0:
            row = run_program(words[_PROGRAM], words[_STACK:], own + 8 * _STACK, words[_AREAS], True)
            if row != 0:
                # In the words of the stack, which are no longer needed.
                words[_STACK + PLACE], words[_STACK + OPERAND], words[_STACK + MASK] = (
                    address,
                    row,
                    WILD_POINTER,
                )
                copy_bytes(own + 8 * _STACK, words[_ENDED], 8 * (MASK + 1))
                stop(engine)
                return
        write_register(engine, double if registers == D0 else single if registers == S0 else low, value)
        if registers == R0_R1:
            write_register(engine, high, value + 4)
        words[_UPPER] = 0
        # Return at once: execution goes on at the address in the link register.
        read_register(engine, link, value + 8)
        write_register(engine, counter, value + 8)

    return called_by_emulator(answer)
