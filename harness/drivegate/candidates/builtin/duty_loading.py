"""Loading the controllers of duty ratios that come with drivegate."""

from collections.abc import Callable, Sequence
from typing import Any

from numpy.typing import NDArray

from drivegate.candidates.builtin.duty_faults import DUTY_FAULTS, DutyFault
from drivegate.candidates.contract import require_nameplate_of
from drivegate.candidates.controller import CompiledController
from drivegate.candidates.kinds import FAULTY_PREFIX
from drivegate_models.contract.duty.records import duty_nameplate_record
from drivegate_models.contract.duty.signals import CURRENT_REFERENCE, DutyNameplate
from drivegate_models.controllers.duty.foc import reset_function, step_function
from drivegate_models.controllers.duty.state import foc_state
from drivegate_models.errors import InputError
from drivegate_models.faults.duty.perturbed import perturbed_state, perturbed_step_function


class DutyController(CompiledController):
    """One instance of a controller of duty ratios.

    `state_size`: size of the state (bytes).
    """

    def __init__(self, name: str = "foc", fault: DutyFault | None = None) -> None:
        super().__init__(step_function(), foc_state(name))
        self._fault = fault
        self.state_size: int = self._state.nbytes

    def reset(self, nameplate: Any) -> None:
        """Write the constants and forget everything else; a nameplate of another contract is refused."""
        require_nameplate_of("duty", nameplate)
        if nameplate.reference_kind == CURRENT_REFERENCE:
            raise InputError(
                "a built-in controller of duty ratios follows a speed or a torque, but this run gives a q current"
            )
        fault, before = self._fault, self._state.copy()
        believed = nameplate if fault is None or fault.believes is None else fault.believes(nameplate)
        reset_function()(self._state, duty_nameplate_record(believed))
        if fault is None:
            return
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


def load_duty_controller(name: str) -> DutyController | PerturbedController:
    """Make a new instance of a controller by its name."""
    if not name.startswith(FAULTY_PREFIX):
        return DutyController(name)
    fault = DUTY_FAULTS[name.removeprefix(FAULTY_PREFIX)]
    inner = DutyController(fault=fault)
    return inner if fault.perturbed is None else PerturbedController(inner, fault.perturbed, fault.keeps)
