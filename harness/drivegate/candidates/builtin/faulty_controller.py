"""Loading a faulty controller, or one near a limit."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.builtin.faults.catalogue import MUTATIONS
from drivegate.candidates.builtin.faults.mutation import Mutation
from drivegate.candidates.builtin.near import NEAR_DESIGNS
from drivegate.candidates.fault import Fault
from drivegate_models.contract.outer_loop.records import nameplate_record
from drivegate_models.contract.outer_loop.signals import Nameplate
from drivegate_models.half_bridge.controllers.builtin import SEARCHES, reset_function
from drivegate_models.half_bridge.controllers.state import CONTROLLER_STATE
from drivegate_models.half_bridge.faults.controllers import faulty_step_function
from drivegate_models.half_bridge.faults.state import FAULTY_STATE

_CONTROLLER_KEYS: Final = frozenset(CONTROLLER_STATE.names or ())

_shared: Final[dict[str, NDArray[Any]]] = {}
"""The state that all instances of a controller have in common, by its name, where sharing it is the fault."""


def load_faulty_controller(name: str) -> FaultyController:
    """Make a new instance of a faulty controller."""
    return FaultyController(MUTATIONS[name])


def load_near_design(name: str) -> FaultyController:
    """Make a new instance of a controller near a limit."""
    return FaultyController(NEAR_DESIGNS[name])


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
        if mutation.shares:
            self._state = _shared.setdefault(mutation.name, self._state)
        self.step_address: int = self._step.address
        self.state_address: int = self._state.ctypes.data
        self.fault: Fault | None = None

    def reset(self, nameplate: Nameplate) -> None:
        """Write the constants, change those that the fault changes, and forget what the fault lets it forget."""
        mutation = self._mutation
        state: NDArray[Any] = np.zeros(1, FAULTY_STATE)
        # A field of a record array is a view.
        controller: NDArray[Any] = np.zeros(1, CONTROLLER_STATE)
        believed = Nameplate(**{**nameplate._asdict(), **dict(mutation.believes)})
        reset_function()(controller, nameplate_record(believed), SEARCHES[mutation.base])
        for name, factor in mutation.factors:
            controller[name] = controller[name] * factor
        state["controller"] = controller
        state["fault"] = mutation.fault
        state["size"] = mutation.size
        # Before its first run there is nothing to keep.
        if self._state["controller"]["control_period"][0] > 0.0:
            for name in mutation.keeps:
                old, new = (
                    (self._state["controller"], state["controller"])
                    if name in _CONTROLLER_KEYS
                    else (self._state, state)
                )
                new[name] = old[name]
        self._state[:] = state
