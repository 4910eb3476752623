"""A controller in compiled code behind the functions of `drivegate.h` or `drivegate_duty.h`, and its global state."""

from __future__ import annotations

import ctypes
import mmap
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from ctypes.util import find_library
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.contract import AnyNameplate, ContractName, require_nameplate_of
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind
from drivegate.candidates.native.exact_memory import ExactMemory
from drivegate_models.contract.current.records import STATE_ALIGNMENT, nameplate_record
from drivegate_models.contract.duty.records import duty_nameplate_record
from drivegate_models.contract.duty.signals import DutyNameplate

_LOADED: Final = 1
_RELOCATED_ONCE: Final = 0x6474E552
_WRITABLE: Final = 2
RESETS: Final[dict[ContractName, str]] = {"current": "drivegate_reset", "duty": "drivegate_duty_reset"}
"""Name of the function that resets a controller of each contract."""
STEPS: Final[dict[ContractName, str]] = {"current": "drivegate_step", "duty": "drivegate_duty_step"}

_NOTHING: Final = np.uint8(0)
_mathematics: Final = ctypes.CDLL(find_library("m"))
# The largest floating-point environment that a C library has is well below this.
_ENVIRONMENT_BYTES: Final = 512
_environment: Final = ctypes.create_string_buffer(_ENVIRONMENT_BYTES)


class _Segment(ctypes.Structure):
    """A program header (System V ABI, "Program Header", for 64 bits)."""

    _fields_ = (
        ("kind", ctypes.c_uint32),
        ("flags", ctypes.c_uint32),
        ("offset", ctypes.c_uint64),
        ("address", ctypes.c_uint64),
        ("physical", ctypes.c_uint64),
        ("size_in_file", ctypes.c_uint64),
        ("size", ctypes.c_uint64),
        ("alignment", ctypes.c_uint64),
    )


class _Loaded(ctypes.Structure):
    """What the dynamic linker says of a loaded object, `dl_phdr_info` of its manual."""

    _fields_ = (
        ("base", ctypes.c_uint64),
        ("name", ctypes.c_char_p),
        ("segments", ctypes.POINTER(_Segment)),
        ("count", ctypes.c_uint16),
    )


class GlobalState:
    """A copy of a library's variables, as its loading has left them.

    A controller whose state is in globals starts from it at every reset, as firmware does at power-on, where start-up
    code writes `.data` and `.bss` before `main`. Memory that the library allocates is not part of it, and a system
    whose dynamic linker does not list its objects has none.
    """

    def __init__(self, library: Path) -> None:
        ranges = _variables(library)
        self.size = sum(end - begin for begin, end in ranges)
        """Size of the variables (bytes)."""
        self._memory = tuple(
            np.ctypeslib.as_array((ctypes.c_uint8 * (end - begin)).from_address(begin))
            for begin, end in ranges
        )
        # Nothing is copied before the first reset, since a size that is refused may be too large for a copy.
        self._copies: tuple[NDArray[np.uint8], ...] | None = None

    def restore(self) -> None:
        """Store the variables at the first call, and write them back at each later one."""
        if self._copies is None:
            self._copies = tuple(np.bitwise_or(view, _NOTHING) for view in self._memory)
        # No copies to numpy: the address sanitizer looks into those, and keeps places between variables that nobody
        # may touch.
        for view, copy in zip(self._memory, self._copies, strict=True):
            np.bitwise_or(copy, _NOTHING, out=view)


def _variables(library: Path) -> list[tuple[int, int]]:
    """Return the ranges of addresses that hold a loaded library's variables."""
    found: list[tuple[int, int]] = []

    def visit(loaded: Any, _size: int, _data: Any) -> int:
        if (loaded.contents.name or b"").decode(errors="surrogateescape") == str(library):
            found.extend(_writable(loaded.contents))
        return 0

    iterate = getattr(ctypes.CDLL(None), "dl_iterate_phdr", None)
    if iterate is not None:
        visitor = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(_Loaded), ctypes.c_size_t, ctypes.c_void_p)
        iterate(visitor(visit), None)
    return found


def _writable(loaded: Any) -> list[tuple[int, int]]:
    segments = [loaded.segments[place] for place in range(loaded.count)]
    fixed = [segment for segment in segments if segment.kind == _RELOCATED_ONCE]
    ends = [loaded.base + segment.address + segment.size for segment in fixed]
    # The dynamic linker makes whole pages of these read-only once it has filled them in.
    fixed_until = max((end - end % mmap.PAGESIZE for end in ends), default=0)
    ranges = [
        (max(loaded.base + segment.address, fixed_until), loaded.base + segment.address + segment.size)
        for segment in segments
        if segment.kind == _LOADED and segment.flags & _WRITABLE
    ]
    return [(begin, end) for begin, end in ranges if begin < end]


# Saved here, before the library of a candidate is loaded, which may change it.
_mathematics.fegetenv(_environment)


@contextmanager
def same_arithmetic() -> Iterator[None]:
    """Undo what a candidate's code does to the rounding of the process in which the plant is computed.

    A library that is linked with `-ffast-math` makes all small numbers zero as soon as it is loaded.
    """
    try:
        yield
    finally:
        _mathematics.fesetenv(_environment)


class NativeController:
    """One instance of a native candidate: its state, and the functions that it shares.

    The state is zeroed once, here; forgetting an earlier run is for the candidate's reset. A candidate without a
    state has it in global variables, which are put back to their initial values before each reset.

    `reset`: calls `drivegate_reset` with the addresses of state and nameplate, and returns 0 for success.
    `state_address`: address of the state, aligned as the header says; 0 for none. Valid as long as this object lives.
    `state`: memory to be used for the state.
    """

    def __init__(
        self,
        step_address: int,
        reset: Callable[[int, int], int],
        state_size: int,
        contract: ContractName = "current",
        variables: GlobalState | None = None,
        state: ExactMemory | None = None,
    ) -> None:
        self.contract = contract
        self._variables = variables
        self.step_address = step_address
        self.state_size = state_size
        self._fault: Fault | None = None
        self._reset = reset
        self._exact = state
        # numpy does not align to as many bytes as the header promises, so there are some to spare.
        self._memory: NDArray[np.uint8] = np.zeros(state_size + STATE_ALIGNMENT, np.uint8)
        begin = self._memory.ctypes.data if state is None else state.address
        self.state_address = begin + -begin % STATE_ALIGNMENT if state_size else 0

    @property
    def fault(self) -> Fault | None:
        """What ended the last run, where that was the reset."""
        return self._fault

    def reset(self, nameplate: AnyNameplate) -> None:
        """Have the candidate prepare for a run; a nameplate of another contract is refused."""
        require_nameplate_of(self.contract, nameplate)
        record = record_of(nameplate)
        if self._variables is not None:
            self._variables.restore()
        with same_arithmetic():
            status = self._reset(self.state_address, record.ctypes.data)
        self._fault = self._why_not_reset(status)
        if self._fault is not None:
            raise CandidateFault(self._fault)

    def _why_not_reset(self, status: int) -> Fault | None:
        return None if status == 0 else refused_by_reset(self.contract, status)


def record_of(nameplate: AnyNameplate) -> NDArray[Any]:
    """Return a nameplate as the record of its contract, shape (1,)."""
    if isinstance(nameplate, DutyNameplate):
        return duty_nameplate_record(nameplate)
    return nameplate_record(nameplate)


def refused_by_reset(contract: ContractName, status: int) -> Fault:
    message = f"{RESETS[contract]} returned {status}, which refuses the run; 0 is success"
    return Fault(FaultKind.EXCEPTION, message, "reset")
