"""Loading a variation of the controller without a position sensor: a faulty one, or another design."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from drivegate.candidates.builtin.duty_loading import SENSORLESS, DutyController
from drivegate.candidates.controller import CompiledController
from drivegate_lab.kernels.faults.duty.sensorless import VARIED_SENSORLESS_STATE, varied_sensorless_step


class Variation(Protocol):
    """What differs from the controller."""

    @property
    def variation(self) -> int:
        """What its steps do otherwise, from `drivegate_lab.kernels.faults.duty.sensorless`; 0 for nothing."""

    @property
    def alter(self) -> Callable[[Any], None] | None:
        """Changes the record of its state, just reset."""


class _Plain(DutyController):
    """The controller without a variation."""

    def __init__(self) -> None:
        super().__init__(SENSORLESS)

    @property
    def record(self) -> Any:
        """Its state after a reset."""
        return self._state[0]


class SensorlessController(CompiledController):
    """One instance of field-oriented control without a sensor, with a fault or of another design."""

    def __init__(self, variation: Variation) -> None:
        self._variation, self._plain = variation, _Plain()
        super().__init__(varied_sensorless_step(), np.zeros(1, VARIED_SENSORLESS_STATE))

    def reset(self, nameplate: Any) -> None:
        """Reset the controller itself, and take over its state with the variation."""
        self._plain.reset(nameplate)
        state = self._state[0]
        state["controller"] = self._plain.record
        state["variation"] = self._variation.variation
        state["starting"] = 0
        state["still_gain"] = state["controller"]["still_gain"]
        if self._variation.alter is not None:
            self._variation.alter(state["controller"])
