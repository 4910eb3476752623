"""What FMUs log while they run, kept for the moment in which one of them fails."""

import ctypes
from collections import deque
from functools import cache
from typing import Any, Final

LONGEST_LOG: Final = 5
"""Messages that are kept."""

_LONGEST_MESSAGE: Final = 400

_messages: deque[str] = deque(maxlen=LONGEST_LOG)


def forget_messages() -> None:
    _messages.clear()


def with_messages(sentence: str) -> str:
    return f"{sentence}: {'; '.join(_messages)}" if _messages else sentence


def log_3(_environment: int | None, status: int, _category: bytes | None, message: bytes | None) -> None:
    """Keep a message: the callback of FMI 3.0."""
    _keep(status, message)


@cache
def callbacks_2() -> Any:
    """Make the callbacks of FMI 2.0, once: fmpy's formatter of messages passes them on to one place only."""
    import fmpy
    from fmpy import fmi2

    def log(
        _environment: int | None,
        _name: bytes | None,
        status: int,
        _category: bytes | None,
        message: bytes | None,
    ) -> None:
        _keep(status, message)

    callbacks = fmi2.fmi2CallbackFunctions()
    callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(log)
    callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(fmpy.calloc)
    callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(fmpy.free)
    try:
        from fmpy.logging import addLoggerProxy
    except Exception:
        # Without it, which is so on some platforms, messages keep their places for values.
        return callbacks
    addLoggerProxy(ctypes.byref(callbacks))
    return callbacks


def _keep(status: int, message: bytes | None) -> None:
    if status > 0 and message:
        _messages.append(message[:_LONGEST_MESSAGE].decode(errors="replace").strip())
