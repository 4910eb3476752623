"""Loading a faulty controller of duty ratios with a fault from the field."""

from __future__ import annotations

from typing import Any

from drivegate.candidates.builtin.duty_loading import DutyController
from drivegate.candidates.controller import CompiledController
from drivegate_lab.candidates.field_faults import FieldFault
from drivegate_lab.kernels.faults.duty.field.controllers import field_step_function
from drivegate_lab.kernels.faults.duty.field.state import field_state


class _Correct(DutyController):
    """The controller without the fault."""

    @property
    def constants(self) -> Any:
        """Its state after a reset."""
        return self._state[0]


class FieldController(CompiledController):
    """One instance of field-oriented control with a field fault."""

    def __init__(self, fault: FieldFault) -> None:
        self._fault, self._correct = fault, _Correct()
        super().__init__(field_step_function(), field_state(self._correct.step_address))
        self.state_size: int = self._state.nbytes

    def reset(self, nameplate: Any) -> None:
        """Reset the controller without the fault, and take over its state and what the fault needs."""
        self._correct.reset(nameplate)
        state, fresh = self._state, field_state(self._correct.step_address)
        for name in fresh.dtype.names or ():
            # Addresses are those of this state, which stays in its place.
            if not name.endswith("_address"):
                state[name] = fresh[name]
        state["controller"] = self._correct.constants
        state["fault"] = self._fault.fault
        state["size"], state["extent"] = self._fault.sizes_on(nameplate)
        state["acts"] = self._fault.under in (None, nameplate.reference_kind)
        for name in ("base_speed", "control_period", "pole_pairs"):
            state[name] = getattr(nameplate, name)
