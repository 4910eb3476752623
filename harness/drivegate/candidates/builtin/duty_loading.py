"""Loading the built-in controllers of duty ratios."""

from typing import Any

import numpy as np

from drivegate.candidates.contract import require_nameplate_of
from drivegate.candidates.controller import CompiledController
from drivegate_models.contract.duty.records import duty_nameplate_record
from drivegate_models.contract.duty.signals import CURRENT_REFERENCE
from drivegate_models.controllers.duty import foc, load_observer
from drivegate_models.controllers.duty.load_observer import LOAD_OBSERVER_STATE
from drivegate_models.controllers.duty.state import foc_state
from drivegate_models.errors import InputError


class DutyController(CompiledController):
    """One instance of a controller of duty ratios.

    `state_size`: size of the state (bytes).
    """

    def __init__(self, name: str = "foc") -> None:
        self._module: Any
        if name == "load-observer":
            self._module, state = load_observer, np.zeros(1, LOAD_OBSERVER_STATE)
        else:
            self._module, state = foc, foc_state(name)
        super().__init__(self._module.step_function(), state)
        self.state_size: int = self._state.nbytes

    def reset(self, nameplate: Any) -> None:
        """Write the constants and forget everything else; a nameplate of another contract is refused."""
        require_nameplate_of("duty", nameplate)
        if nameplate.reference_kind == CURRENT_REFERENCE:
            raise InputError(
                "a built-in controller of duty ratios follows a speed or a torque, but this run gives a q current"
            )
        self._module.reset_function()(self._state, duty_nameplate_record(nameplate))
