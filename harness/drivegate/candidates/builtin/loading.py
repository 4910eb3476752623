"""Loading the controllers that come with drivegate, which are compiled code behind the native interface."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.controller import CompiledController, Controller
from drivegate.candidates.kinds import DESIGN_PREFIX, FAULTY_PREFIX, NEAR_PREFIX
from drivegate_models.contract.current.records import nameplate_record
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.controllers.current.builtin import SEARCHES, reset_function, step_function
from drivegate_models.controllers.current.state import CONTROLLER_STATE
from drivegate_models.errors import HarnessFault

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument


@dataclass(frozen=True)
class ControllerCode:
    """Compiled code that several controllers share; each is chosen by a number."""

    layout: np.dtype[Any]
    """The state."""
    step: Callable[[], Any]
    """Returns the compiled `drivegate_step`."""
    reset: Callable[[], Any]
    """Returns the compiled function that takes the state, a nameplate's record and the controller's number.
    """


SEARCHING: Final = ControllerCode(CONTROLLER_STATE, step_function, reset_function)
"""The code of `SEARCHES`."""


def load_controller(candidate: Candidate) -> Controller:
    """Make a new instance of a built-in controller."""
    return _LOADERS[candidate.contract or "current"](candidate)


def _load_duty_controller(candidate: Candidate) -> Controller:
    from drivegate.candidates.builtin.duty_loading import load_duty_controller

    return load_duty_controller(candidate.entry)


def _load_search(candidate: Candidate) -> Controller:
    if candidate.entry.startswith(FAULTY_PREFIX):
        from drivegate.candidates.builtin.faulty_controller import load_faulty_controller

        return load_faulty_controller(candidate.entry.removeprefix(FAULTY_PREFIX))
    if candidate.entry.startswith(NEAR_PREFIX):
        from drivegate.candidates.builtin.faulty_controller import load_near_design

        return load_near_design(candidate.entry.removeprefix(NEAR_PREFIX))
    if candidate.entry.startswith(DESIGN_PREFIX):
        return _design_controller(candidate.entry.removeprefix(DESIGN_PREFIX))
    return BuiltinController(SEARCHES[candidate.entry])


_LOADERS: Final = {"current": _load_search, "duty": _load_duty_controller}
"""For each contract, what makes one of its controllers."""


def _design_controller(design: str) -> "DesignController":
    from drivegate_models.controllers.current.designs.controllers import (
        DESIGNS,
        design_reset_function,
        design_step_function,
    )
    from drivegate_models.controllers.current.designs.state import DESIGN_STATE

    code = ControllerCode(DESIGN_STATE, design_step_function, design_reset_function)
    return DesignController(DESIGNS[design], code)


class BuiltinController(CompiledController):
    """One instance of a built-in controller.

    `state_size`: size of the state (bytes).
    """

    def __init__(self, number: int, code: ControllerCode = SEARCHING) -> None:
        super().__init__(code.step(), np.zeros(1, code.layout))
        self._number = number
        self._code = code
        self.state_size: int = self._state.nbytes

    def reset(self, nameplate: Nameplate) -> None:
        """Write the constants and forget everything else."""
        self._code.reset()(self._state, nameplate_record(nameplate), self._number)


class DesignController(BuiltinController):
    """One instance of a correct design, which has a table of its drive's angles; attributes as a built-in one's."""

    def __init__(self, number: int, code: ControllerCode) -> None:
        super().__init__(number, code)
        self._drive: DriveDocument | None = None

    def show_drive(self, drive: "DriveDocument") -> None:
        """Take the drive that the table is to be of."""
        if drive == self._drive:
            return
        from drivegate.candidates.builtin.design_table import table_of

        table = table_of(drive)
        self._state["table_from"] = table.first_speed
        self._state["table_step"] = table.speed_step
        self._state["table_sums"] = table.current_sums
        self._state["table_angles"] = table.angles
        self._drive = drive

    def reset(self, nameplate: Nameplate) -> None:
        """Write the constants but for the table, and forget everything else."""
        if self._drive is None:
            raise HarnessFault("a design with a table of its drive runs on one that it has not been shown")
        super().reset(nameplate)
