"""Loading the built-in controllers, which are compiled code behind the native interface."""

from typing import Final

import numpy as np

from drivegate.candidates.builtin.prefixed import family_of
from drivegate.candidates.candidate import Candidate
from drivegate.candidates.controller import CompiledController, Controller
from drivegate_models.contract.current.records import nameplate_record
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.controllers.current.builtin import SEARCHES, reset_function, step_function
from drivegate_models.controllers.current.state import CONTROLLER_STATE


def load_controller(candidate: Candidate) -> Controller:
    found = family_of(candidate.entry)
    if found is not None:
        family, name = found
        return family.load_controller(name)
    return _LOADERS[candidate.contract or "current"](candidate.entry)


def _load_search(name: str) -> Controller:
    return BuiltinController(SEARCHES[name])


def _load_duty_controller(name: str) -> Controller:
    from drivegate.candidates.builtin.duty_loading import DutyController

    return DutyController(name)


_LOADERS: Final = {"current": _load_search, "duty": _load_duty_controller}
"""For each contract, what makes one of its controllers."""


class BuiltinController(CompiledController):
    """One instance of a built-in controller.

    `state_size`: size of the state (bytes).
    """

    def __init__(self, number: int) -> None:
        super().__init__(step_function(), np.zeros(1, CONTROLLER_STATE))
        self._number = number
        self.state_size: int = self._state.nbytes

    def reset(self, nameplate: Nameplate) -> None:
        reset_function()(self._state, nameplate_record(nameplate), self._number)
