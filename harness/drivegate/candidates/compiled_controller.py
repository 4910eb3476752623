"""A controller whose step is compiled code."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from drivegate.candidates.fault import Fault


class CompiledController:
    """The step and the state of one instance; a subclass resets the state.

    `step_address`, `state_address`: addresses of the compiled step and of the state; valid as long as this object
    lives.
    """

    def __init__(self, step: Any, state: NDArray[Any]) -> None:
        self._step, self._state = step, state
        self.step_address: int = step.address
        self.state_address: int = state.ctypes.data

    @property
    def fault(self) -> Fault | None:
        """What ended the last run; None where the compiled code answers every step."""
        return None
