"""The emulator's functions that compiled code calls: by their names, since their addresses differ between processes."""

from __future__ import annotations

import ctypes
from importlib import import_module
from typing import Any, Final

from llvmlite.binding import add_symbol
from numba import types

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
