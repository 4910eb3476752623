"""Loading the built-in controllers of duty ratios."""

from typing import Any, Final

import numpy as np

from drivegate.candidates.contract import require_nameplate_of
from drivegate.candidates.controller import CompiledController
from drivegate_models.contract.duty.records import duty_nameplate_record
from drivegate_models.contract.duty.signals import CURRENT_REFERENCE, NO_POSITION
from drivegate_models.controllers.duty import foc, foc_sensorless, load_observer
from drivegate_models.controllers.duty.load_observer import LOAD_OBSERVER_STATE
from drivegate_models.controllers.duty.sensorless_state import SENSORLESS_STATE
from drivegate_models.controllers.duty.state import foc_state
from drivegate_models.errors import InputError

SENSORLESS: Final = "foc-sensorless"
"""The built-in controller that needs no position sensor."""


class DutyController(CompiledController):
    """One instance of a controller of duty ratios.

    `state_size`: size of the state (bytes).
    """

    def __init__(self, name: str = "foc") -> None:
        self._module: Any
        self._name = name
        self._needs_angle = name != SENSORLESS
        if name == "load-observer":
            self._module, state = load_observer, np.zeros(1, LOAD_OBSERVER_STATE)
        elif name == SENSORLESS:
            self._module, state = foc_sensorless, np.zeros(1, SENSORLESS_STATE)
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
        if nameplate.position == NO_POSITION and self._needs_angle:
            raise InputError(
                f"the built-in controller '{self._name}' needs the shaft's angle, but this drive has no position "
                f"sensor; '{SENSORLESS}' needs none"
            )
        self._module.reset_function()(self._state, duty_nameplate_record(nameplate))
