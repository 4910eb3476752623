"""Loading the controllers that come with drivegate, which are compiled code behind the native interface."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import Fault
from drivegate.candidates.kinds import DESIGN_PREFIX, FAULTY_PREFIX, NEAR_PREFIX
from drivegate_models.contract.outer_loop.records import nameplate_record
from drivegate_models.contract.outer_loop.signals import Nameplate
from drivegate_models.half_bridge.controllers.builtin import SEARCHES, reset_function, step_function
from drivegate_models.half_bridge.controllers.state import CONTROLLER_STATE


@dataclass(frozen=True)
class ControllerCode:
    """Compiled code that several controllers share; each is chosen by a number.

    Attributes
    ----------
    layout : dtype
        The state.
    step : callable
        Returns the compiled `drivegate_step`.
    reset : callable
        Returns the compiled function that takes the state, a nameplate's record and the controller's number.
    """

    layout: np.dtype[Any]
    step: Callable[[], Any]
    reset: Callable[[], Any]


SEARCHING: Final = ControllerCode(CONTROLLER_STATE, step_function, reset_function)
"""The code of `SEARCHES`."""


def load_controller(candidate: Candidate) -> Controller:
    """Make a new instance of a built-in controller."""
    if candidate.entry.startswith(FAULTY_PREFIX):
        from drivegate.candidates.builtin.faulty_controller import load_faulty_controller

        return load_faulty_controller(candidate.entry.removeprefix(FAULTY_PREFIX))
    if candidate.entry.startswith(NEAR_PREFIX):
        from drivegate.candidates.builtin.faulty_controller import load_near_design

        return load_near_design(candidate.entry.removeprefix(NEAR_PREFIX))
    if candidate.entry.startswith(DESIGN_PREFIX):
        return _design_controller(candidate.entry.removeprefix(DESIGN_PREFIX))
    return BuiltinController(SEARCHES[candidate.entry])


def _design_controller(design: str) -> "BuiltinController":
    from drivegate_models.half_bridge.designs.controllers import (
        DESIGNS,
        design_reset_function,
        design_step_function,
    )
    from drivegate_models.half_bridge.designs.state import DESIGN_STATE

    code = ControllerCode(DESIGN_STATE, design_step_function, design_reset_function)
    return BuiltinController(DESIGNS[design], code)


class BuiltinController:
    """One instance of a built-in controller: its state, and the compiled functions that it shares.

    Attributes
    ----------
    step_address : int
        Address of the compiled `drivegate_step`.
    state_address : int
        Address of the state; valid as long as this object lives.
    state_size : int
        Size of the state (bytes).
    fault : None
        Always None: these controllers report no fault of their own.
    """

    def __init__(self, number: int, code: ControllerCode = SEARCHING) -> None:
        self._number = number
        self._code = code
        self._step = code.step()
        self._state: NDArray[Any] = np.zeros(1, code.layout)
        self.step_address: int = self._step.address
        self.state_address: int = self._state.ctypes.data
        self.state_size: int = self._state.nbytes
        self.fault: Fault | None = None

    def reset(self, nameplate: Nameplate) -> None:
        """Write the constants and forget everything else."""
        self._code.reset()(self._state, nameplate_record(nameplate), self._number)
