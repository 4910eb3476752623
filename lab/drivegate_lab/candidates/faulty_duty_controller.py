"""Loading a faulty controller of duty ratios: field-oriented control with other constants, Senses or commands."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from numpy.typing import NDArray

from drivegate.candidates.builtin.duty_loading import DutyController
from drivegate.candidates.controller import CompiledController
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS, DutyFault
from drivegate_lab.kernels.faults.duty.perturbed import perturbed_state, perturbed_step_function
from drivegate_models.contract.duty.signals import DutyNameplate


class FaultyDutyController(DutyController):
    """A controller whose nameplate or constants a fault changes."""

    def __init__(self, fault: DutyFault) -> None:
        super().__init__()
        self._fault = fault

    def reset(self, nameplate: Any) -> None:
        """Reset the controller with what the fault makes of the nameplate, and leave what it does not reset."""
        fault, before = self._fault, self._state.copy()
        super().reset(nameplate if fault.believes is None else fault.believes(nameplate))
        if fault.alter is not None:
            fault.alter(self._state)
        _leave(fault.keeps, before, self._state)


class PerturbedController(CompiledController):
    """A controller with perturbed Senses and commands."""

    def __init__(
        self,
        inner: DutyController,
        perturbed: Callable[[DutyNameplate], dict[str, float]],
        keeps: Sequence[str] = (),
    ) -> None:
        super().__init__(
            perturbed_step_function(), perturbed_state(inner.step_address, inner.state_address, {})
        )
        self._inner = inner
        self._perturbed = perturbed
        self._keeps = keeps
        self.state_size: int = inner.state_size

    def reset(self, nameplate: Any) -> None:
        """Reset the controller itself, and forget what it was shown."""
        self._inner.reset(nameplate)
        fresh = perturbed_state(
            self._inner.step_address, self._inner.state_address, self._perturbed(nameplate)
        )
        _leave(self._keeps, self._state, fresh)
        for name in fresh.dtype.names or ():
            # Addresses are those of this state, which stays in its place.
            if not name.endswith("_address"):
                self._state[name] = fresh[name]


def _leave(keeps: Sequence[str], before: NDArray[Any], state: NDArray[Any]) -> None:
    """Copy what a reset is not to change from the state before it; zeros at first."""
    for name in keeps:
        if name in (state.dtype.names or ()):
            state[name] = before[name]


def load_faulty_duty_controller(name: str) -> FaultyDutyController | PerturbedController:
    """Make a new instance of a faulty controller."""
    fault = DUTY_FAULTS[name]
    inner = FaultyDutyController(fault)
    return inner if fault.perturbed is None else PerturbedController(inner, fault.perturbed, fault.keeps)
