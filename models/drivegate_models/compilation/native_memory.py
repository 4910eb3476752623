"""Reading numbers behind an address from compiled code, as a Sense gives the address of its phase currents."""

from __future__ import annotations

import ctypes
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import config
from numba.core.typing.templates import Signature
from numba.extending import intrinsic

_SIZE = ctypes.sizeof(ctypes.c_double)


def _double_at_interpreted(address: int, index: int) -> float:
    """Read from the interpreter, where compilation is switched off."""
    return ctypes.c_double.from_address(int(address) + _SIZE * int(index)).value


@intrinsic
def _double_at_compiled(typingctx: Any, address: Any, index: Any) -> tuple[Signature, Any]:
    """Emit a load through an address."""

    def codegen(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        pointer = builder.inttoptr(arguments[0], ir.DoubleType().as_pointer())
        return builder.load(builder.gep(pointer, [arguments[1]]))

    return types.float64(types.uintp, types.intp), codegen


_INTERPRETED = bool(vars(config)["DISABLE_JIT"])

double_at: Any = _double_at_interpreted if _INTERPRETED else _double_at_compiled
"""Read the double number `index` behind `address`; both are integers."""
