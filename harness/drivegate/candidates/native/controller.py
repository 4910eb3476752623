"""A controller in compiled code behind the functions of `drivegate.h` or `drivegate_duty.h`, stepped by address."""

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from ctypes.util import find_library
from typing import Any, Final, Protocol

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.contract import AnyNameplate, ContractName, require_nameplate_of
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind
from drivegate.candidates.native.global_state import GlobalState
from drivegate_models.contract.current.records import STATE_ALIGNMENT, nameplate_record
from drivegate_models.contract.duty.records import duty_nameplate_record
from drivegate_models.contract.duty.signals import DutyNameplate

RESETS: Final[dict[ContractName, str]] = {"current": "drivegate_reset", "duty": "drivegate_duty_reset"}
"""Name of the function that resets a controller of each contract."""
STEPS: Final[dict[ContractName, str]] = {"current": "drivegate_step", "duty": "drivegate_duty_step"}
"""Name of the function that steps it."""

_mathematics: Final = ctypes.CDLL(find_library("m"))
# The largest floating-point environment that a C library has is well below this.
_ENVIRONMENT_BYTES: Final = 512
_environment: Final = ctypes.create_string_buffer(_ENVIRONMENT_BYTES)
_mathematics.fegetenv(_environment)


class ResetFunction(Protocol):
    """Calls a candidate's `drivegate_reset`."""

    def __call__(self, state: int, nameplate: int) -> int:
        """Take the addresses of state and nameplate; return 0 for success."""


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

    `state_address`: address of the state, aligned as the header says; 0 for none. Valid as long as this object lives.
    """

    def __init__(
        self,
        step_address: int,
        reset: ResetFunction,
        state_size: int,
        contract: ContractName = "current",
        variables: GlobalState | None = None,
    ) -> None:
        self.contract = contract
        self._variables = variables
        self.step_address = step_address
        self.state_size = state_size
        self._fault: Fault | None = None
        self._reset = reset
        self._memory: NDArray[np.uint8] = np.zeros(state_size + STATE_ALIGNMENT, np.uint8)
        begin = self._memory.ctypes.data
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
    """Return the fault of a controller whose reset returned another status than 0."""
    message = f"{RESETS[contract]} returned {status}, which refuses the run; 0 is success"
    return Fault(FaultKind.EXCEPTION, message, "reset")
