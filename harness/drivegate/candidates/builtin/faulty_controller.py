"""Loading a faulty controller."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.builtin.faults import MUTATIONS, Mutation
from drivegate.candidates.fault import Fault
from drivegate_models.contract.outer_loop.records import nameplate_record
from drivegate_models.contract.outer_loop.signals import Nameplate
from drivegate_models.half_bridge.controllers.builtin import SEARCHES, reset_function
from drivegate_models.half_bridge.controllers.state import CONTROLLER_STATE
from drivegate_models.half_bridge.faults.controllers import faulty_step_function
from drivegate_models.half_bridge.faults.state import FAULTY_STATE


def load_faulty_controller(name: str) -> FaultyController:
    """Make a new instance of a faulty controller."""
    return FaultyController(MUTATIONS[name])


class FaultyController:
    """One instance of a faulty controller: its state, and the compiled functions that it shares.

    Attributes
    ----------
    step_address : int
        Address of the compiled `drivegate_step`.
    state_address : int
        Address of the state; valid as long as this object lives.
    fault : None
        Always None: a faulty controller answers every step.
    """

    def __init__(self, mutation: Mutation) -> None:
        self._mutation = mutation
        self._step = faulty_step_function()
        self._state: NDArray[Any] = np.zeros(1, FAULTY_STATE)
        self.step_address: int = self._step.address
        self.state_address: int = self._state.ctypes.data
        self.fault: Fault | None = None

    def reset(self, nameplate: Nameplate) -> None:
        """Write the constants, change those that the fault changes, and forget what the fault lets it forget."""
        mutation = self._mutation
        integral = float(self._state["controller"]["integral"][0])
        controller: NDArray[Any] = np.zeros(1, CONTROLLER_STATE)
        reset_function()(controller, nameplate_record(nameplate), SEARCHES[mutation.base])
        for name, factor in mutation.factors:
            controller[name] = controller[name] * factor
        if not mutation.forgets:
            controller["integral"] = integral
        self._state[:] = np.zeros(1, FAULTY_STATE)
        self._state["controller"] = controller
        self._state["fault"] = mutation.fault
        self._state["size"] = mutation.size
