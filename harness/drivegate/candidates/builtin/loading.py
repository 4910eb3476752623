"""Loading the controllers that come with drivegate, which are compiled code behind the native interface."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.builtin.design_candidates import DESIGN_PREFIX
from drivegate.candidates.candidate import Candidate
from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import Fault
from drivegate.candidates.resolution import FAULTY_PREFIX
from drivegate_models.contract.outer_loop.records import nameplate_record
from drivegate_models.contract.outer_loop.signals import Nameplate
from drivegate_models.half_bridge.controllers.builtin import SEARCHES, reset_function, step_function
from drivegate_models.half_bridge.controllers.state import CONTROLLER_STATE


def load_builtin_controller(candidate: Candidate) -> Controller:
    """Make a new instance of a built-in controller."""
    if candidate.entry.startswith(FAULTY_PREFIX):
        from drivegate.candidates.builtin.faulty_controller import load_faulty_controller

        return load_faulty_controller(candidate.entry.removeprefix(FAULTY_PREFIX))
    if candidate.entry.startswith(DESIGN_PREFIX):
        from drivegate.candidates.builtin.design_controller import DesignController

        return DesignController(candidate.entry)
    return BuiltinController(SEARCHES[candidate.entry])


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

    def __init__(self, search: int) -> None:
        self._search = search
        self._step = step_function()
        self._state: NDArray[Any] = np.zeros(1, CONTROLLER_STATE)
        self.step_address: int = self._step.address
        self.state_address: int = self._state.ctypes.data
        self.state_size: int = self._state.nbytes
        self.fault: Fault | None = None

    def reset(self, nameplate: Nameplate) -> None:
        """Write the constants and forget everything else."""
        reset_function()(self._state, nameplate_record(nameplate), self._search)
