"""Loading a correct controller of another design than the reference."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.builtin.design_candidates import DESIGN_PREFIX
from drivegate.candidates.fault import Fault
from drivegate_models.contract.outer_loop.records import nameplate_record
from drivegate_models.contract.outer_loop.signals import Nameplate
from drivegate_models.half_bridge.designs.controllers import (
    DESIGNS,
    design_reset_function,
    design_step_function,
)
from drivegate_models.half_bridge.designs.state import DESIGN_STATE


class DesignController:
    """One instance of a design: its state, and the compiled functions that it shares.

    Attributes
    ----------
    step_address : int
        Address of the compiled `drivegate_step`.
    state_address : int
        Address of the state; valid as long as this object lives.
    state_size : int
        Size of that state (bytes).
    fault : None
        Always None: a design answers every step.
    """

    def __init__(self, name: str) -> None:
        self._design = DESIGNS[name.removeprefix(DESIGN_PREFIX)]
        self._step = design_step_function()
        self._state: NDArray[Any] = np.zeros(1, DESIGN_STATE)
        self.step_address: int = self._step.address
        self.state_address: int = self._state.ctypes.data
        self.state_size: int = self._state.nbytes
        self.fault: Fault | None = None

    def reset(self, nameplate: Nameplate) -> None:
        """Write the constants and forget everything else."""
        design_reset_function()(self._state, nameplate_record(nameplate), self._design)
