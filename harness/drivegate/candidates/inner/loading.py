"""Loading a candidate behind the loop of currents.

This runs the candidate's code, so it belongs into a worker process.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from drivegate.candidates.candidate import Candidate, OuterLoop
from drivegate.candidates.contract import AnyNameplate, require_nameplate_of
from drivegate.candidates.controller import CompiledController, Controller
from drivegate.candidates.fault import Fault
from drivegate.candidates.kinds import KINDS
from drivegate_models.contract.duty.records import DUTY_NAMEPLATE, duty_nameplate_record
from drivegate_models.contract.duty.signals import TORQUE_REFERENCE, DutyNameplate
from drivegate_models.controllers.duty.inner_loop import (
    inner_reset_function,
    inner_state,
    inner_step_function,
)
from drivegate_models.errors import HarnessFault, InputError
from drivegate_models.pm_ac.outer_nameplate import outer_nameplate

OUTER_PERIOD_S: Final = 500e-6
"""Time from one step of the controller to the next, that of the paper's drive, as whole control periods allow (s)."""


class InnerController(CompiledController):
    def __init__(self, outer: Controller) -> None:
        super().__init__(inner_step_function(), inner_state(0, 0, 1))
        self._outer = outer

    @property
    def fault(self) -> Fault | None:
        return self._outer.fault

    @property
    def refusal(self) -> InputError | None:
        """What ended it, where that is no fault."""
        return getattr(self._outer, "refusal", None)

    def reset(self, nameplate: AnyNameplate) -> None:
        """Reset the controller, with a nameplate of its own contract, and the loop."""
        require_nameplate_of("duty", nameplate)
        assert isinstance(nameplate, DutyNameplate), "of this contract"
        if nameplate.reference_kind == TORQUE_REFERENCE:
            raise InputError(
                "a controller of current references follows a speed, but this run gives a torque reference; choose a "
                "run whose load is no dynamometer"
            )
        if nameplate.highest_speed <= nameplate.base_speed:
            raise InputError(
                "a controller of current references advances its angle between base speed and the highest speed, but "
                "the drive is stated without field weakening; choose a drive whose highest speed is above base speed"
            )
        periods = max(round(OUTER_PERIOD_S / nameplate.control_period), 1)
        self._outer.reset(outer_nameplate(nameplate, periods))
        self._state["step_address"] = self._outer.step_address
        self._state["state_address"] = self._outer.state_address
        self._state["periods"] = periods
        inner_reset_function()(self._state, duty_nameplate_record(nameplate))


def compile_own_code(candidate: Candidate) -> None:
    """Compile the loop of currents, and what the candidate behind it needs."""
    inner_step_function()
    inner_reset_function()(inner_state(0, 0, 1), np.zeros(1, DUTY_NAMEPLATE))
    outer = _outer(candidate)
    KINDS[outer.kind].compile_own_code(outer)


def load_controller(candidate: Candidate) -> InnerController:
    outer = _outer(candidate)
    return InnerController(KINDS[outer.kind].load_controller(outer))


def _outer(candidate: Candidate) -> Candidate:
    if not isinstance(candidate.details, OuterLoop):
        raise HarnessFault(f"the candidate {candidate.name} of kind {candidate.kind} has no controller")
    return candidate.details.outer
