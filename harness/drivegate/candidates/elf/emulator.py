"""The emulator as compiled code meets it: functions that it calls, and those that the emulator calls in turn.

Compiled code knows the emulator's functions by their names, since their addresses differ between processes.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from importlib import import_module
from typing import Any, Final

import numba
from llvmlite.binding import add_symbol
from numba import types

from drivegate_models.compilation.kernels import KEEPS_CACHE

# The package has types for a part of its functions only.
arm_const: Any = import_module("unicorn.arm_const")
binding: Any = import_module("unicorn.unicorn_py3.unicorn")


def _function(name: str, *arguments: Any) -> Any:
    """Return what compiled code calls as a C function of the emulator, which returns an error or 0."""
    address = ctypes.cast(getattr(binding.uclib, name), ctypes.c_void_p).value
    add_symbol(name, address)
    function: Any = types.ExternalFunction
    return function(name, types.int32(*arguments))


read_register: Final = _function("uc_reg_read", types.intp, types.int32, types.intp)
"""Copy a register to an address: the engine, the number of the register, the address."""

write_register: Final = _function("uc_reg_write", types.intp, types.int32, types.intp)
"""Set a register to what is at an address: the engine, the number of the register, the address."""

start: Final = _function("uc_emu_start", types.intp, types.uint64, types.uint64, types.uint64, types.uintp)
"""Run from an address to another one: the engine, both addresses, and two limits, which are 0 for none."""

stop: Final = _function("uc_emu_stop", types.intp)
"""Stop after the present instruction: the engine."""


def called_by_emulator(function: Callable[[int, int, int, Any], None]) -> Any:
    """Compile what the emulator calls: with the engine, an address, a size, and a pointer to words of its own."""
    pointer: Any = types.CPointer
    signature = types.void(types.intp, types.int64, types.int32, pointer(types.int64))
    return numba.cfunc(signature, cache=KEEPS_CACHE)(function)
