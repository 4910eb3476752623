"""Loading a faulty controller without a position sensor."""

from __future__ import annotations

from typing import Any

import numpy as np

from drivegate.candidates.builtin.duty_loading import SENSORLESS, DutyController
from drivegate.candidates.controller import CompiledController
from drivegate_lab.candidates.sensorless_faults import SensorlessFault
from drivegate_lab.kernels.faults.duty.sensorless import FAULTY_SENSORLESS_STATE, faulty_sensorless_step


class _Correct(DutyController):
    """The controller without the fault."""

    def __init__(self) -> None:
        super().__init__(SENSORLESS)

    @property
    def record(self) -> Any:
        """Its state after a reset."""
        return self._state[0]


class SensorlessController(CompiledController):
    """One instance of field-oriented control without a sensor, with a fault."""

    def __init__(self, fault: SensorlessFault) -> None:
        self._fault, self._correct = fault, _Correct()
        super().__init__(faulty_sensorless_step(), np.zeros(1, FAULTY_SENSORLESS_STATE))

    def reset(self, nameplate: Any) -> None:
        """Reset the controller without the fault, and take over its state with the fault."""
        self._correct.reset(nameplate)
        state = self._state[0]
        state["controller"] = self._correct.record
        state["fault"] = self._fault.fault
        state["still_gain"] = state["controller"]["still_gain"]
        if self._fault.alter is not None:
            self._fault.alter(state["controller"])
