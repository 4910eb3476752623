"""Loading the controllers of duty ratios that come with drivegate."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.builtin.duty_faults import DUTY_FAULTS
from drivegate.candidates.fault import Fault
from drivegate.candidates.kinds import FAULTY_PREFIX
from drivegate_models.contract.duty.records import duty_nameplate_record
from drivegate_models.contract.duty.signals import DutyNameplate
from drivegate_models.duty.controllers.foc import reset_function, step_function
from drivegate_models.duty.controllers.state import FOC_STATE
from drivegate_models.errors import InputError


class DutyController:
    """One instance of a controller of duty ratios: its state, and the compiled functions that it shares.

    Attributes
    ----------
    step_address : int
        Address of the compiled step.
    state_address : int
        Address of the state; valid as long as this object lives.
    state_size : int
        Size of the state (bytes).
    fault : None
        Always None: these controllers report no fault of their own.
    """

    def __init__(self, alter: Callable[[Any], None] | None = None) -> None:
        self._alter = alter
        self._step = step_function()
        self._state: NDArray[Any] = np.zeros(1, FOC_STATE)
        self.step_address: int = self._step.address
        self.state_address: int = self._state.ctypes.data
        self.state_size: int = self._state.nbytes
        self.fault: Fault | None = None

    def reset(self, nameplate: Any) -> None:
        """Write the constants and forget everything else; a nameplate of another contract is refused."""
        if not isinstance(nameplate, DutyNameplate):
            raise InputError(
                "the controller answers with duty ratios, but the drive takes a current reference and an advance "
                "angle; name a drive of the kind 'pm-ac'"
            )
        reset_function()(self._state, duty_nameplate_record(nameplate))
        if self._alter is not None:
            self._alter(self._state)


def load_duty_controller(name: str) -> DutyController:
    """Make a new instance of a controller by its name."""
    fault = DUTY_FAULTS.get(name.removeprefix(FAULTY_PREFIX)) if name.startswith(FAULTY_PREFIX) else None
    return DutyController(None if fault is None else fault.alter)
