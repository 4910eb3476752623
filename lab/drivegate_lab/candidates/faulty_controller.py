"""Loading a faulty controller, or one near a limit."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.controller import CompiledController
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_lab.candidates.faults.catalogue import MUTATIONS
from drivegate_lab.candidates.faults.mutation import Mutation, number_on
from drivegate_lab.candidates.faults.oracle_sizes import nominal_table
from drivegate_lab.candidates.faults.tolerances import NEAR_DESIGNS
from drivegate_lab.kernels.faults.current.controllers import faulty_step_function
from drivegate_lab.kernels.faults.current.state import FAULTY_STATE, NOMINAL_TABLE
from drivegate_models.contract.current.records import nameplate_record
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.controllers.current.builtin import SEARCHES, reset_function
from drivegate_models.controllers.current.state import CONTROLLER_STATE
from drivegate_models.errors import HarnessFault

_shared: Final[dict[str, NDArray[Any]]] = {}
"""The state that all instances of a controller have in common, by its name, where sharing it is the fault."""


def load_faulty_controller(name: str) -> FaultyController:
    """Make a new instance of a faulty controller."""
    return FaultyController(MUTATIONS[name])


def load_near_design(name: str) -> FaultyController:
    """Make a new instance of a controller near a limit."""
    return FaultyController(NEAR_DESIGNS[name])


class FaultyController(CompiledController):
    """One instance of a faulty controller."""

    def __init__(self, mutation: Mutation) -> None:
        state: NDArray[Any] = np.zeros(1, FAULTY_STATE)
        if mutation.shares:
            state = _shared.setdefault(mutation.name, state)
        super().__init__(faulty_step_function(), state)
        self._mutation = mutation
        self._drive: DriveDocument | None = None

    def show_drive(self, drive: DriveDocument) -> None:
        """Take the drive that the fault is to be sized for."""
        self._drive = drive

    def reset(self, nameplate: Nameplate) -> None:
        """Write the constants, change those that the fault changes, and forget what the fault lets it forget."""
        mutation, drive = self._mutation, self._drive
        if drive is None:
            raise HarnessFault(f"the controller '{mutation.name}' runs on a drive that it has not been shown")
        state: NDArray[Any] = np.zeros(1, FAULTY_STATE)
        # A field of a record array is a view.
        controller: NDArray[Any] = np.zeros(1, CONTROLLER_STATE)
        believed = Nameplate(**{**nameplate._asdict(), **dict(mutation.believes)})
        reset_function()(controller, nameplate_record(believed), SEARCHES[mutation.base])
        mutation.scale(controller)
        for name, constant in mutation.constants:
            controller[name] = constant.number(drive)
        state["controller"] = controller
        _write_sizes(state, mutation, drive)
        # Before its first run there is nothing to keep.
        if self._state["controller"]["control_period"][0] > 0.0:
            mutation.keep(self._state["controller"], state["controller"])
            mutation.keep(self._state, state)
        self._state[:] = state


def _write_sizes(state: NDArray[Any], mutation: Mutation, drive: DriveDocument) -> None:
    state["fault"] = mutation.fault
    state["size"] = number_on(mutation.size, drive)
    state["extent"] = number_on(mutation.extent, drive)
    for name, speed in zip(("first_rpm", "last_rpm"), mutation.region, strict=False):
        state[name] = speed.of(drive)
    if mutation.fault == NOMINAL_TABLE:
        state["table_rpm"], state["table_degrees"] = zip(*nominal_table(drive), strict=True)
