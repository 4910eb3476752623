"""Loading a faulty controller of duty ratios: field-oriented control with other constants, Senses or commands."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from drivegate.candidates.builtin.duty_loading import DutyController
from drivegate.candidates.controller import CompiledController
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS, DutyFault
from drivegate_lab.candidates.field_controller import FieldController
from drivegate_lab.candidates.field_faults import FIELD_FAULTS
from drivegate_lab.candidates.sensorless_controller import SensorlessController
from drivegate_lab.candidates.sensorless_faults import SENSORLESS_FAULTS
from drivegate_lab.kernels.faults.duty.perturbed import perturbed_state, perturbed_step_function


class FaultyDutyController(DutyController):
    """A controller whose nameplate or constants a fault changes."""

    def __init__(self, fault: DutyFault) -> None:
        super().__init__()
        self._fault = fault

    def reset(self, nameplate: Any) -> None:
        """Reset the controller with what the fault makes of the nameplate, and leave what it does not reset."""
        fault, before = self._fault, self._state.copy()
        super().reset(fault.believed(nameplate))
        fault.scale(self._state)
        if fault.alter is not None:
            fault.alter(self._state)
        fault.keep(before, self._state)


class PerturbedController(CompiledController):
    """A controller with perturbed Senses and commands."""

    def __init__(self, fault: DutyFault) -> None:
        self._inner = FaultyDutyController(fault)
        super().__init__(perturbed_step_function(), self._fresh({}))
        self._fault = fault
        self.state_size: int = self._inner.state_size

    def reset(self, nameplate: Any) -> None:
        """Reset the controller itself, and forget what it was shown."""
        self._inner.reset(nameplate)
        fresh = self._fresh(self._fault.changed(nameplate))
        self._fault.keep(self._state, fresh)
        for name in fresh.dtype.names or ():
            # Addresses are those of this state, which stays in its place.
            if not name.endswith("_address"):
                self._state[name] = fresh[name]

    def _fresh(self, changes: dict[str, float]) -> NDArray[Any]:
        return perturbed_state(self._inner.step_address, self._inner.state_address, changes)


def load_faulty_duty_controller(
    name: str,
) -> FaultyDutyController | PerturbedController | FieldController | SensorlessController:
    """Make a new instance of a faulty controller."""
    if name in FIELD_FAULTS:
        return FieldController(FIELD_FAULTS[name])
    if name in SENSORLESS_FAULTS:
        return SensorlessController(SENSORLESS_FAULTS[name])
    fault = DUTY_FAULTS[name]
    return PerturbedController(fault) if fault.changes else FaultyDutyController(fault)
