"""Calls of a controller by the address of its C function, and access to memory by address, from compiled code.

The address is data, so the compiled loop is the same for every controller and remains cached. A Sense contains the
address of its phase currents.
"""

from __future__ import annotations

import ctypes
from typing import Any

from llvmlite import ir
from numba import from_dtype, types
from numba.core import config
from numba.core.cgutils import raw_memcpy
from numba.core.typing.templates import Signature
from numba.extending import intrinsic

_STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
_SIZE = ctypes.sizeof(ctypes.c_double)


def _call_step_interpreted(step: int, state: int, sense: int, command: int) -> None:
    _STEP(step)(state, sense, command)


@intrinsic
def _call_step_compiled(
    typingctx: Any, step: Any, state: Any, sense: Any, command: Any
) -> tuple[Signature, Any]:
    """Emit a call of ``void (*)(void *, void *, void *)`` at an address."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = ir.IntType(8).as_pointer()
        function = ir.FunctionType(ir.VoidType(), [pointer] * 3).as_pointer()
        target = builder.inttoptr(arguments[0], function)
        builder.call(target, [builder.inttoptr(argument, pointer) for argument in arguments[1:]])
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64, types.int64), codegen


def _double_at_interpreted(address: int, index: int) -> float:
    return ctypes.c_double.from_address(int(address) + _SIZE * int(index)).value


@intrinsic
def _double_at_compiled(typingctx: Any, address: Any, index: Any) -> tuple[Signature, Any]:
    """Emit a load through an address."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = builder.inttoptr(arguments[0], ir.DoubleType().as_pointer())
        return builder.load(builder.gep(pointer, [arguments[1]]))

    return types.float64(types.uintp, types.intp), codegen


def _copy_bytes_interpreted(source: int, target: int, count: int) -> None:
    ctypes.memmove(int(target), int(source), int(count))


@intrinsic
def _copy_bytes_compiled(typingctx: Any, source: Any, target: Any, count: Any) -> tuple[Signature, Any]:
    """Emit a copy from one address to another."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = ir.IntType(8).as_pointer()
        places = [builder.inttoptr(argument, pointer) for argument in arguments[:2]]
        copy: Any = raw_memcpy
        copy(builder, places[1], places[0], arguments[2], 1)
        return context.get_dummy_value()

    return types.void(types.int64, types.int64, types.int64), codegen


# If compilation is switched off, the interpreter runs the loop and everything that it calls.
_INTERPRETED = bool(vars(config)["DISABLE_JIT"])

call_step: Any = _call_step_interpreted if _INTERPRETED else _call_step_compiled
"""Call ``drivegate_step(state, sense, command)``; all four arguments are addresses (int64)."""

double_at: Any = _double_at_interpreted if _INTERPRETED else _double_at_compiled
"""Read element `index` of the array of doubles at `address`; both are integers."""

copy_bytes: Any = _copy_bytes_interpreted if _INTERPRETED else _copy_bytes_compiled
"""Copy `count` bytes from one address to another that does not overlap; all three are integers."""


def step_signature(state: Any, sense: Any, command: Any) -> Any:
    """Return numba's signature of a step whose three arguments point to records of these layouts."""
    pointer: Any = types.CPointer
    return types.void(*(pointer(from_dtype(layout)) for layout in (state, sense, command)))
