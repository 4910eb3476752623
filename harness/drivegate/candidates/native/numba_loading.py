"""Compiling a controller whose author wrote a `NumbaController`; this belongs into a worker process.

Every operation is rounded by itself, as in Python and in C without contraction, and nothing is reordered.
"""

from __future__ import annotations

import ctypes
import inspect
import re
import sys
from functools import cache
from typing import Any, Final

import numba
import numpy as np
from numba import types
from numba.core.ccallback import CFunc
from numba.core.dispatcher import Dispatcher
from numba.np.numpy_support import carray

from drivegate.candidates.contract import HEADERS, ContractName
from drivegate.candidates.fault import Fault, bounded_reason, exception_fault
from drivegate.candidates.native.controller import RESETS, STEPS, NativeController
from drivegate.candidates.native.loading import LARGEST_STATE
from drivegate.candidates.native.numba_controller import NumbaController
from drivegate_cases.documents.wording import shown_path
from drivegate_models.compilation.calling import double_at
from drivegate_models.compilation.kernels import inlined
from drivegate_models.contract.current.records import COMMAND, NAMEPLATE, SENSE, STOP
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_NAMEPLATE, DUTY_SENSE
from drivegate_models.errors import InputError

_ARGUMENTS: Final = {"reset": ("state", "nameplate"), "step": ("state", "sense", "command")}
_RECORDS: Final = {
    "current": (NAMEPLATE, SENSE, COMMAND),
    "duty": (DUTY_NAMEPLATE, DUTY_SENSE, DUTY_COMMAND),
}
_FUNCTIONS: Final = {"reset": RESETS, "step": STEPS}
_RESET: Final = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
_COLOUR: Final = re.compile(r"\x1b\[[0-9;]*m")
_PLACE: Final = re.compile(
    r'File "(?P<file>[^"]+)", line (?P<line>\d+)|\bat (?P<at>\S+) \((?P<line_at>\d+)\)'
)
_RECORD: Final = re.compile(r"Record\(.*\)")
_USABLE: Final = "use numbers, records and functions compiled with numba.njit only"
_STATE_ADVICE: Final = (
    "give a numpy dtype with named fields of 1 byte to 64 MiB, such as np.dtype([('integral', np.float64)])"
)


@inlined
def phase_current(sense: Any, index: int) -> float:
    """Read one phase current of a sense, from code that numba compiles.

    Parameters
    ----------
    sense : record
        What `step` is given.
    index : int
        The phase, from 0 to ``sense.phase_count - 1``; it is not checked.

    Returns
    -------
    float
        The measured current at this instant (A).
    """
    current: float = double_at(sense.phase_currents, index)
    return current


class CompiledController(NativeController):
    """One instance of a numba candidate; an exception in its step is reported as that of a Python candidate."""

    def __init__(self, step: Any, reset: Any, state_size: int, contract: ContractName) -> None:
        self._functions = (step, reset)
        super().__init__(step.address, _RESET(reset.address), state_size, contract)
        _raised.watch()

    @property
    def fault(self) -> Fault | None:
        """What ended the last run: the exception that the candidate's code raised, if it did."""
        error = _raised.taken()
        if error is not None:
            self._fault = exception_fault(error, "step")
        return self._fault

    def _why_not_reset(self, status: int) -> Fault | None:
        error = _raised.taken()
        return super()._why_not_reset(status) if error is None else exception_fault(error, "reset")


class _RaisedExceptions:
    """Keeps the last exception that compiled code could not hand on, which numba reports as unraisable."""

    def __init__(self) -> None:
        self._last: BaseException | None = None
        self._others: Any = None

    def watch(self) -> None:
        if sys.unraisablehook != self._keep:
            self._others, sys.unraisablehook = sys.unraisablehook, self._keep

    def _keep(self, unraisable: Any, /) -> None:
        # numba names itself, as text, where other code gives what could not raise.
        if str(unraisable.object).startswith("<numba."):
            self._last = unraisable.exc_value
        else:
            self._others(unraisable)

    def taken(self) -> BaseException | None:
        last, self._last = self._last, None
        return last


_raised: Final = _RaisedExceptions()


def load_numba_controller(definition: NumbaController, name: str) -> CompiledController:
    """Make a new instance of a numba candidate, which is compiled once a process."""
    return CompiledController(*_callbacks(definition, name), definition.contract)


@cache
def _callbacks(definition: NumbaController, name: str) -> tuple[Any, Any, int]:
    """Return the C functions of step and reset, and the size of the state (bytes)."""
    if definition.contract not in _RECORDS:
        raise InputError(
            f"{name}: contract is {bounded_reason(repr(definition.contract))}, but must be one of {', '.join(_RECORDS)}"
        )
    functions = (definition.reset, definition.step)
    if all(isinstance(function, CFunc) for function in functions):
        return _given_callbacks(definition, name)
    for role, function in zip(_ARGUMENTS, functions, strict=True):
        _check_function(role, function, name)
    layout = _layout(definition.state, name)
    nameplate, sense, command = map(numba.from_dtype, _RECORDS[definition.contract])
    state = numba.from_dtype(layout)
    step = _compiled("step", definition.step, (state, sense, command), name)
    reset = _compiled("reset", definition.reset, (state, nameplate), name)
    return (
        _step_callback(step, (state, sense, command)),
        _reset_callback(reset, (state, nameplate)),
        layout.itemsize,
    )


def _given_callbacks(definition: NumbaController, name: str) -> tuple[Any, Any, int]:
    size = definition.state
    if not isinstance(size, int) or isinstance(size, bool):
        size = _layout(definition.state, name).itemsize
    if not 0 < size <= LARGEST_STATE:
        raise InputError(f"{name}: the size of the state is {size}, but must be 1 to {LARGEST_STATE} bytes")
    required = {"reset": (types.int32, 2), "step": (types.void, 3)}
    for role, function in (("reset", definition.reset), ("step", definition.step)):
        signature = vars(function)["_sig"]
        answer, count = required[role]
        if signature.return_type != answer or len(signature.args) != count:
            raise InputError(
                f"{name}: {role} has the type {bounded_reason(str(signature))}, but must return {answer} and "
                f"take {count} pointers, as {_FUNCTIONS[role][definition.contract]} in {HEADERS[definition.contract]}"
            )
    return definition.step, definition.reset, size


def _check_function(role: str, function: object, name: str) -> None:
    arguments = ", ".join(_ARGUMENTS[role])
    if isinstance(function, CFunc):
        raise InputError(
            f"{name}: {role} is a numba.cfunc, but the other one is not; make both or none of them one"
        )
    plain = function.py_func if isinstance(function, Dispatcher) else function
    if not inspect.isfunction(plain):
        raise InputError(
            f"{name}: {role} is of type {type(plain).__name__}, but must be a function {role}({arguments})"
        )
    try:
        inspect.signature(plain).bind(*_ARGUMENTS[role])
    except TypeError:
        given = ", ".join(inspect.signature(plain).parameters)
        raise InputError(f"{name}: {role} takes ({given}), but must take ({arguments})") from None


def _layout(state: Any, name: str) -> np.dtype[Any]:
    try:
        layout = np.dtype(None if isinstance(state, int) else state)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"{name}: the state is no numpy dtype: {bounded_reason(str(error))}; {_STATE_ADVICE}"
        ) from error
    if not layout.names or not 0 < layout.itemsize <= LARGEST_STATE:
        what = "a size" if isinstance(state, int) else f"the dtype {bounded_reason(str(layout))}"
        raise InputError(f"{name}: the state is {what}; {_STATE_ADVICE}")
    return layout


def _compiled(role: str, function: Any, arguments: tuple[Any, ...], name: str) -> Any:
    dispatcher = function if isinstance(function, Dispatcher) else numba.njit(error_model="numpy")(function)
    try:
        dispatcher.compile(arguments)
    except Exception as error:
        raise InputError(f"{name}: {_why_not_compiled(role, error)}") from error
    return dispatcher


def _why_not_compiled(role: str, error: Exception) -> str:
    text = _COLOUR.sub("", str(error))
    if isinstance(error, KeyError):
        field = bounded_reason(text)
        return f"{role} does not compile: a record has no field {field}; the fields are those of the contract"
    lines = (line.strip() for line in text.splitlines())
    reasons = [line for line in lines if line and not line.startswith(("Failed in", "During", "File "))]
    place = _PLACE.search(text)
    where = ""
    if place is not None:
        where = f" ({shown_path(place['file'] or place['at'])}, line {place['line'] or place['line_at']})"
    message = bounded_reason(_RECORD.sub("record", reasons[0])) if reasons else type(error).__name__
    return f"{role} does not compile: {message}{where}; {_USABLE}"


def _pointer(record: Any) -> Any:
    pointer: Any = types.CPointer
    return pointer(record)


def _step_callback(step: Any, records: tuple[Any, ...]) -> Any:
    """Put a step behind a C function that stops the loop when the step does not return."""

    def drivegate_step(state: Any, sense: Any, command: Any) -> None:
        answer = carray(command, 1)[0]
        size = answer.struct_size
        answer.struct_size = STOP
        step(carray(state, 1)[0], carray(sense, 1)[0], answer)
        answer.struct_size = size

    return numba.cfunc(types.void(*map(_pointer, records)))(drivegate_step)


def _reset_callback(reset: Any, records: tuple[Any, ...]) -> Any:
    """Put a reset behind a C function; it returns 0, since an exception shows that it failed."""

    def drivegate_reset(state: Any, nameplate: Any) -> int:
        reset(carray(state, 1)[0], carray(nameplate, 1)[0])
        return 0

    return numba.cfunc(types.int32(*map(_pointer, records)))(drivegate_reset)
