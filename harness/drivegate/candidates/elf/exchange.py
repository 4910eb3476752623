"""What a manifest writes into the variables of an image before a step, and reads from them after it.

Expressions become a program for a stack of numbers, which the compiled step runs: their values are those of 64-bit
floating-point arithmetic. A program is an array of doubles, in which addresses of this machine are exact.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Final

import numpy as np
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from drivegate.candidates.contract import ContractName
from drivegate.candidates.elf.emulator import arm_const, called_by_emulator, read_register, write_register
from drivegate.candidates.elf.expression import Place, Step
from drivegate.candidates.elf.image import hexadecimal
from drivegate.candidates.elf.variables import FLOAT, SIGNED, UNSIGNED, Number, Variables
from drivegate_cases.documents.wording import nearest, short_line
from drivegate_models.compilation.calling import copy_bytes, double_at
from drivegate_models.compilation.kernels import unallocating
from drivegate_models.contract.current.records import NAMEPLATE
from drivegate_models.contract.current.signals import Command
from drivegate_models.contract.duty.records import DUTY_NAMEPLATE
from drivegate_models.contract.duty.signals import DutyCommand
from drivegate_models.contract.layout import CURRENT, DUTY, Layout
from drivegate_models.errors import InputError

_CONSTANT, _LOAD, _ADD, _SUBTRACT, _MULTIPLY, _DIVIDE, _REMAINDER, _MINIMUM, _MAXIMUM = range(9)
_NEGATE, _ABSOLUTE, _FLOOR, _ROUND, _STORE = range(9, 14)
_OPERATIONS: Final = {
    "+": _ADD,
    "-": _SUBTRACT,
    "*": _MULTIPLY,
    "/": _DIVIDE,
    "%": _REMAINDER,
    "min": _MINIMUM,
    "max": _MAXIMUM,
    "negated": _NEGATE,
    "abs": _ABSOLUTE,
    "floor": _FLOOR,
    "round": _ROUND,
}
_COLUMNS: Final = 6
"""Operation; then a value or an address; form and size; least and greatest value of an integer."""

# Words of a function that is answered: the registers of its value, the value, a word after it, and the
# address of the value. The answering function also reads the link register into that word.
_REGISTERS, _VALUE, _UPPER, _VALUE_AT = range(4)
_STUB_WORDS: Final = 4
_R0, _R0_R1, _S0, _D0 = range(4)


REQUIRED_OUTPUTS: Final[Mapping[ContractName, tuple[str, ...]]] = {
    "current": ("current_reference", "advance_angle"),
    "duty": ("duty_ratios[0]", "duty_ratios[1]", "duty_ratios[2]"),
}
"""Fields that each Command has, by contract."""
LAYOUTS: Final = {"current": (CURRENT, NAMEPLATE), "duty": (DUTY, DUTY_NAMEPLATE)}
"""Records of a step, and that of the nameplate, by contract."""
MOST_PHASES: Final = 64
"""Number of phase currents that the memory of a step has space for."""
_ANSWERS: Final[Mapping[ContractName, tuple[type[Command | DutyCommand], tuple[str, ...]]]] = {
    "current": (Command, ()),
    "duty": (DutyCommand, ("duty_ratios", "legs")),
}
"""What a controller in Python answers, with the fields that have a number for each leg."""


@dataclass(frozen=True)
class Records:
    """The records of a step in the memory of this machine."""

    signals: Mapping[str, Number]
    """What expressions of writes may name: fields of the Sense, and of the nameplate as ``nameplate.resistance``."""
    outputs: Mapping[str, Number]
    """What is read: fields of the Command."""


def records_in(mail: int, places: Sequence[int], contract: ContractName) -> Records:
    """Find the fields of the records that are exchanged.

    `mail`: address of the memory that they are in. `places`: where nameplate, Sense, Command and currents begin.
    """
    layout, nameplate = LAYOUTS[contract]
    signals = {f"nameplate.{name}": number for name, number in _fields(mail + places[0], nameplate)}
    signals |= dict(_fields(mail + places[1], layout.sense))
    signals.pop("phase_currents")
    signals |= {
        f"phase_currents[{phase}]": Number(mail + places[3] + 8 * phase, FLOAT, 8)
        for phase in range(MOST_PHASES)
    }
    named = _names_of_outputs(contract, layout)
    fields = dict(_fields(mail + places[2], layout.command))
    return Records(signals, {name: fields[field] for name, field in named.items()})


def _fields(begin: int, record: np.dtype[Any]) -> Iterator[tuple[str, Number]]:
    """List the numbers of a record, those of an array one by one."""
    fields: Any = record.fields
    for name in (record.names or ())[1:]:
        kind, offset = fields[name][:2]
        form = FLOAT if kind.base.kind == "f" else SIGNED
        for index in range(kind.shape[0] if kind.shape else 1):
            text = f"{name}[{index}]" if kind.shape else name
            yield text, Number(begin + offset + 8 * index, form, 8)


def _names_of_outputs(contract: ContractName, layout: Layout) -> dict[str, str]:
    """Name the fields of a Command as a controller in Python does, with those of the record."""
    answer, by_leg = _ANSWERS[contract]
    names = [
        text
        for name in answer._fields
        for text in ([f"{name}[{leg}]" for leg in range(3)] if name in by_leg else [name])
    ]
    return dict(zip(names, layout.outputs, strict=True))


class Programs:
    def __init__(
        self,
        variables: Variables,
        peripherals: Mapping[str, Place],
        records: Records,
        memory: Callable[[int, int], NDArray[np.uint8]],
    ) -> None:
        self._variables = variables
        self._peripherals = peripherals
        self._records = records
        self._memory = memory

    def write(self, place: Place, value: tuple[Step, ...]) -> Iterator[tuple[float, ...]]:
        """Evaluate what follows from signals, and store it in a variable of the target."""
        yield from self._evaluated(value, self._signal)
        yield _stored(self._target(place))

    def read(self, output: str, value: tuple[Step, ...]) -> Iterator[tuple[float, ...]]:
        """Evaluate what follows from variables of the target, and store it in the Command."""
        if output not in self._records.outputs:
            known = self._records.outputs
            raise InputError(f"a Command has no '{short_line(output)}'; it has {', '.join(known)}")
        yield from self._evaluated(value, self._target)
        yield _stored(self._records.outputs[output])

    def stub(
        self, function: str, value: tuple[Step, ...]
    ) -> tuple[NDArray[np.int64], list[tuple[float, ...]]]:
        """Evaluate what follows from signals, and store it where the function's answer is taken from.

        Return the words of `answering_function`, and the program.
        """
        words = np.zeros(_STUB_WORDS, np.int64)
        words[_VALUE_AT] = words[_VALUE:].ctypes.data
        returned = self._variables.returned(function)
        if returned is None:
            return words, []
        form, size = returned
        is_float = form == FLOAT and self._variables.passes_floats_in_registers
        words[_REGISTERS] = (_D0 if size == 8 else _S0) if is_float else _R0_R1 if size == 8 else _R0
        least, greatest = _range(form, size)
        # A narrow integer fills its register.
        stored = Number(int(words[_VALUE_AT]), form, max(size, 4))
        return words, [
            *self._evaluated(value, self._signal),
            (*_stored(stored)[:4], least, greatest),
        ]

    def _evaluated(
        self, steps: tuple[Step, ...], found: Callable[[Place], Number]
    ) -> Iterator[tuple[float, ...]]:
        for step in steps:
            if isinstance(step, Place):
                number = found(step)
                yield (_LOAD, number.address, number.form, number.size, 0.0, 0.0)
            elif isinstance(step, str):
                yield (_OPERATIONS[step], 0.0, 0.0, 0.0, 0.0, 0.0)
            else:
                yield (_CONSTANT, step, 0.0, 0.0, 0.0, 0.0)

    def _signal(self, place: Place) -> Number:
        if place.text not in self._records.signals:
            known = list(self._records.signals)
            raise InputError(
                f"there is no signal '{place.text}', the nearest one is '{nearest(place.text, known)}'"
            )
        return self._records.signals[place.text]

    def _target(self, place: Place) -> Number:
        alias = self._peripherals.get(place.root) if place.address is None else None
        whole = place if alias is None else alias._replace(path=(*alias.path, *place.path))
        number = self._variables.number(whole)
        try:
            memory = self._memory(number.address, number.size)
        except KeyError:
            raise InputError(
                f"'{place.text}' is at {hexadecimal(number.address)}, where the target has no memory; add it to 'ram'"
            ) from None
        return number._replace(address=int(memory.ctypes.data))


def program_of(rows: list[tuple[float, ...]]) -> NDArray[np.float64]:
    """Return a program as the compiled step takes it: the number of its rows, then the rows, shape (n,)."""
    return np.concatenate(([len(rows)], *rows)).astype(np.float64)


@cache
def answering_function() -> Any:
    """Compile the C function that the emulator calls in the place of a function of the target."""
    low, high = arm_const.UC_ARM_REG_R0, arm_const.UC_ARM_REG_R1
    single, double = arm_const.UC_ARM_REG_S0, arm_const.UC_ARM_REG_D0
    link, counter = arm_const.UC_ARM_REG_LR, arm_const.UC_ARM_REG_PC

    def answer(engine: int, _address: int, _size: int, state: Any) -> None:
        words = carray(state, _STUB_WORDS)
        value, registers = words[_VALUE_AT], words[_REGISTERS]
        write_register(engine, double if registers == _D0 else single if registers == _S0 else low, value)
        if registers == _R0_R1:
            write_register(engine, high, value + 4)
        words[_UPPER] = 0
        # Return at once: execution goes on at the address in the link register.
        read_register(engine, link, value + 8)
        write_register(engine, counter, value + 8)

    return called_by_emulator(answer)


def _stored(number: Number) -> tuple[float, ...]:
    return (_STORE, number.address, number.form, number.size, *_range(number.form, number.size))


def _range(form: int, size: int) -> tuple[float, float]:
    """Return the least and the greatest double that an integer has a value for."""
    if form == FLOAT:
        return -math.inf, math.inf
    bits = 8 * size - (form == SIGNED)
    # From 54 bits on, the greatest integer is no double, and would be rounded up to one that is out of range.
    greatest = math.nextafter(2.0**bits, 0.0) if bits > 53 else 2.0**bits - 1.0
    return (0.0 if form == UNSIGNED else -(2.0**bits)), greatest


@unallocating
def run_program(address: int, stack: NDArray[Any], scratch: int) -> None:
    """Run a program.

    `address`: that of the program. `stack`, shape (n,): words for numbers. `scratch`: address of its first word.
    """
    top = 0
    for row in range(int(double_at(address, 0))):
        place = 1 + row * _COLUMNS
        operation = int(double_at(address, place))
        if operation == _CONSTANT:
            stack[top] = np.float64(double_at(address, place + 1)).view(np.int64)
            top += 1
        elif operation == _LOAD:
            stack[top] = 0
            _load(address, place, stack, top, scratch + 8 * top)
            top += 1
        elif operation == _STORE:
            top -= 1
            _store(address, place, stack, top, scratch + 8 * top)
        elif operation >= _NEGATE:
            value = np.int64(stack[top - 1]).view(np.float64)
            stack[top - 1] = np.float64(_of_one(operation, value)).view(np.int64)
        else:
            first, second = (
                np.int64(stack[top - 2]).view(np.float64),
                np.int64(stack[top - 1]).view(np.float64),
            )
            stack[top - 2] = np.float64(_of_two(operation, first, second)).view(np.int64)
            top -= 1


@unallocating
def _load(address: int, place: int, stack: NDArray[Any], top: int, scratch: int) -> None:
    form, size = int(double_at(address, place + 2)), int(double_at(address, place + 3))
    copy_bytes(int(double_at(address, place + 1)), scratch, size)
    word = stack[top]
    if form == FLOAT:
        value = np.int64(word).view(np.float64) if size == 8 else np.float64(np.int32(word).view(np.float32))
    elif form == SIGNED:
        unused = 64 - 8 * size
        value = np.float64((word << unused) >> unused)
    else:
        value = np.float64(np.int64(word).view(np.uint64))
    stack[top] = np.float64(value).view(np.int64)


@unallocating
def _store(address: int, place: int, stack: NDArray[Any], top: int, scratch: int) -> None:
    form, size = int(double_at(address, place + 2)), int(double_at(address, place + 3))
    value = np.int64(stack[top]).view(np.float64)
    if form == FLOAT:
        if size == 4:
            stack[top] = np.int64(np.float32(value).view(np.int32))
    else:
        # As a converter does: to the nearest integer, and no further than its range.
        limited = min(max(np.rint(value), double_at(address, place + 4)), double_at(address, place + 5))
        if np.isnan(value):
            stack[top] = 0
        elif limited >= 2.0**63:
            stack[top] = np.uint64(limited).view(np.int64)
        else:
            stack[top] = np.int64(limited)
    copy_bytes(scratch, int(double_at(address, place + 1)), size)


@unallocating
def _of_one(operation: int, value: float) -> float:
    if operation == _NEGATE:
        return -value
    if operation == _ABSOLUTE:
        return abs(value)
    return float(np.floor(value) if operation == _FLOOR else np.rint(value))


@unallocating
def _of_two(operation: int, first: float, second: float) -> float:
    if operation == _ADD:
        return first + second
    if operation == _SUBTRACT:
        return first - second
    if operation == _MULTIPLY:
        return first * second
    if operation == _DIVIDE:
        return first / second
    if operation == _REMAINDER:
        return float(first - np.floor(first / second) * second)
    if operation == _MINIMUM:
        return min(first, second)
    return max(first, second)
