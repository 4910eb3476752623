"""The program of an expression for a stack of numbers, and its compiled evaluation.

Values are those of 64-bit floating-point arithmetic. A program is an array of doubles, in which addresses of this
machine are exact. It leads through pointers of the target, which are known only while it runs.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.elf.memory import Area
from drivegate.candidates.elf.variables import FLOAT, SIGNED, UNSIGNED, Number
from drivegate_models.compilation.calling import copy_bytes, double_at
from drivegate_models.compilation.kernels import unallocating

_CONSTANT, _LOAD, _STORE, _POINT, _POINT_ON, _LOAD_THERE, _STORE_THERE = range(7)
_ADD, _SUBTRACT, _MULTIPLY, _DIVIDE, _REMAINDER, _MINIMUM, _MAXIMUM = range(7, 14)
_AND, _OR, _EXCLUSIVE_OR, _SHIFT_LEFT, _SHIFT_RIGHT = range(14, 19)
_NEGATE, _ABSOLUTE, _FLOOR, _ROUND, _INVERT = range(19, 24)
_OPERATIONS: Final = {
    "+": _ADD,
    "-": _SUBTRACT,
    "*": _MULTIPLY,
    "/": _DIVIDE,
    "%": _REMAINDER,
    "min": _MINIMUM,
    "max": _MAXIMUM,
    "&": _AND,
    "|": _OR,
    "^": _EXCLUSIVE_OR,
    "<<": _SHIFT_LEFT,
    ">>": _SHIFT_RIGHT,
    "negated": _NEGATE,
    "abs": _ABSOLUTE,
    "floor": _FLOOR,
    "round": _ROUND,
    "~": _INVERT,
}
_COLUMNS: Final = 8
"""Operation; then a value or an address; form and size; least and greatest value of an integer; bits of a bit field."""
_NO_BITS: Final = (0.0, 0.0, 0.0, 0.0)
_GREATEST_WHOLE: Final = math.nextafter(2.0**63, 0.0)
_POINTER_BYTES: Final = 4

Row = tuple[float, ...]


def constant(value: float) -> Row:
    return (_CONSTANT, value, 0.0, 0.0, *_NO_BITS)


def operation(name: str) -> Row:
    return (_OPERATIONS[name], 0.0, 0.0, 0.0, *_NO_BITS)


def loaded(number: Number) -> list[Row]:
    """Put a number on the stack."""
    there = _LOAD_THERE if number.offsets else _LOAD
    row = (there, number.address, number.form, number.size, 0.0, 0.0, number.shift, number.width)
    return [*_pointed(number), row]


def stored(number: Number, limits: tuple[float, float] | None = None) -> list[Row]:
    """Store what is on top of the stack; an integer is rounded and limited to its range or to the given limits."""
    there = _STORE_THERE if number.offsets else _STORE
    if limits is None:
        limits = _range_of_bits(number.form, number.width or 8 * number.size)
    row = (there, number.address, number.form, number.size, *limits, number.shift, number.width)
    return [*_pointed(number), row]


def _pointed(number: Number) -> list[Row]:
    return [
        (_POINT_ON if place else _POINT, number.address, offset, 0.0, *_NO_BITS)
        for place, offset in enumerate(number.offsets)
    ]


def range_of(form: int, size: int) -> tuple[float, float]:
    """Return the least and the greatest double that an integer has a value for."""
    return _range_of_bits(form, 8 * size)


def _range_of_bits(form: int, width: int) -> tuple[float, float]:
    if form == FLOAT:
        return -math.inf, math.inf
    bits = width - (form == SIGNED)
    # From 54 bits on, the greatest integer is no double, and would be rounded up to one that is out of range.
    greatest = math.nextafter(2.0**bits, 0.0) if bits > 53 else 2.0**bits - 1.0
    return (0.0 if form == UNSIGNED else -(2.0**bits)), greatest


def program_of(rows: Sequence[Row]) -> NDArray[np.float64]:
    """Return a program as the compiled step takes it: the number of its rows, then the rows, shape (n,)."""
    return np.concatenate(([len(rows)], *rows)).astype(np.float64)


def table_of(areas: Iterable[Area]) -> NDArray[np.float64]:
    """Return where the memory of a target is in this machine, as programs need it, shape (n,).

    It has the number of areas; then for each its first address, the address after its last, and its place.
    """
    rows = [(area.address, area.address + area.content.size, area.content.ctypes.data) for area in areas]
    return np.array([len(rows), *(value for row in rows for value in row)], np.float64)


@unallocating
def run_program(address: int, stack: NDArray[Any], scratch: int, areas: int, is_strict: bool) -> int:
    """Run a program; return 0, or the number of the row, from 1 on, whose pointer points to no memory.

    `address`: that of the program. `stack`, shape (n,): words for numbers. `scratch`: address of its first word.
    `areas`: address of a table of `table_of`. `is_strict`: whether a pointer outside of them ends the program;
    otherwise what it leads to is 0 and remains as it is.
    """
    top = 0
    there = 0.0
    for row in range(int(double_at(address, 0))):
        place = 1 + row * _COLUMNS
        step = int(double_at(address, place))
        if step == _CONSTANT:
            stack[top] = np.float64(double_at(address, place + 1)).view(np.int64)
            top += 1
        elif step <= _STORE_THERE:
            size = _POINTER_BYTES
            if step in (_LOAD, _STORE, _LOAD_THERE, _STORE_THERE):
                size = int(double_at(address, place + 3))
            host = double_at(address, place + 1)
            if step in (_POINT_ON, _LOAD_THERE, _STORE_THERE):
                host = _host_of(areas, there, size)
                if host == 0.0 and is_strict:
                    return row + 1
            if step in (_POINT, _POINT_ON):
                there = _pointed_to(int(host), double_at(address, place + 2), stack, top, scratch + 8 * top)
            elif step in (_LOAD, _LOAD_THERE):
                stack[top] = 0
                if host != 0.0:
                    copy_bytes(int(host), scratch + 8 * top, size)
                    _load(address, place, stack, top)
                top += 1
            else:
                top -= 1
                if host != 0.0:
                    _store(int(host), address, place, stack, top, scratch + 8 * top)
        elif step >= _NEGATE:
            value = np.int64(stack[top - 1]).view(np.float64)
            stack[top - 1] = np.float64(_of_one(step, value)).view(np.int64)
        else:
            first, second = (
                np.int64(stack[top - 2]).view(np.float64),
                np.int64(stack[top - 1]).view(np.float64),
            )
            result = _of_bits(step, first, second) if step >= _AND else _of_two(step, first, second)
            stack[top - 2] = np.float64(result).view(np.int64)
            top -= 1
    return 0


@unallocating
def _host_of(areas: int, address: float, size: int) -> float:
    """Return where memory of the target is in this machine; 0 where the target has none."""
    for number in range(int(double_at(areas, 0))):
        begin = double_at(areas, 1 + 3 * number)
        if begin <= address and address + size <= double_at(areas, 2 + 3 * number):
            return float(double_at(areas, 3 + 3 * number) + address - begin)
    return 0.0


@unallocating
def _pointed_to(host: int, offset: float, stack: NDArray[Any], top: int, scratch: int) -> float:
    """Return an offset from what a pointer points to; for a null pointer, an address that no target has."""
    stack[top] = 0
    if host != 0:
        copy_bytes(host, scratch, _POINTER_BYTES)
    return float(stack[top]) + offset if stack[top] != 0 else -1.0


@unallocating
def _load(address: int, place: int, stack: NDArray[Any], top: int) -> None:
    """Make a double of the bytes that are on top of the stack."""
    form, size = int(double_at(address, place + 2)), int(double_at(address, place + 3))
    shift, width = int(double_at(address, place + 6)), int(double_at(address, place + 7))
    word = stack[top]
    if width != 0:
        aligned = word << (64 - shift - width)
        value = (
            np.float64(aligned >> (64 - width))
            if form == SIGNED
            else np.float64((word >> shift) & _mask(width))
        )
    elif form == FLOAT:
        value = np.int64(word).view(np.float64) if size == 8 else np.float64(np.int32(word).view(np.float32))
    elif form == SIGNED:
        unused = 64 - 8 * size
        value = np.float64((word << unused) >> unused)
    else:
        value = np.float64(np.int64(word).view(np.uint64))
    stack[top] = np.float64(value).view(np.int64)


@unallocating
def _store(host: int, address: int, place: int, stack: NDArray[Any], top: int, scratch: int) -> None:
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
        width = int(double_at(address, place + 7))
        if width != 0:
            shift, written = int(double_at(address, place + 6)), stack[top] & _mask(width)
            stack[top] = 0
            copy_bytes(host, scratch, size)
            stack[top] = (stack[top] & ~(_mask(width) << shift)) | (written << shift)
    copy_bytes(scratch, host, size)


@unallocating
def _mask(width: int) -> Any:
    """Return a word whose lowest bits are set."""
    return ~(np.int64(-1) << np.int64(width)) if width < 64 else np.int64(-1)


@unallocating
def _whole(value: float) -> Any:
    """Round to the nearest integer, as a store does; bits are those of 64-bit integers."""
    if np.isnan(value):
        return np.int64(0)
    return np.int64(min(max(np.rint(value), -(2.0**63)), _GREATEST_WHOLE))


@unallocating
def _of_one(step: int, value: float) -> float:
    if step == _NEGATE:
        return -value
    if step == _ABSOLUTE:
        return abs(value)
    if step == _INVERT:
        return float(~_whole(value))
    return float(np.floor(value) if step == _FLOOR else np.rint(value))


@unallocating
def _of_bits(step: int, first: float, second: float) -> float:
    left, right = _whole(first), _whole(second)
    if step == _AND:
        return float(left & right)
    if step == _OR:
        return float(left | right)
    if step == _EXCLUSIVE_OR:
        return float(left ^ right)
    # A shift by more than a word is one by all its bits; a processor does nothing of use there.
    count = min(max(right, 0), 63)
    if step == _SHIFT_RIGHT:
        return float(left >> count)
    return float(left << count)


@unallocating
def _of_two(step: int, first: float, second: float) -> float:
    if step == _ADD:
        return first + second
    if step == _SUBTRACT:
        return first - second
    if step == _MULTIPLY:
        return first * second
    if step == _DIVIDE:
        return first / second
    if step == _REMAINDER:
        return float(first - np.floor(first / second) * second)
    if step == _MINIMUM:
        return min(first, second)
    return max(first, second)
