"""Correct controllers of other designs than the reference controller: no check may accuse one of them."""

from __future__ import annotations

import numpy as np

from drivegate.candidates.controller import CompiledController
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_lab.candidates.design_table import table_of
from drivegate_lab.kernels.designs.controllers import DESIGNS, design_reset_function, design_step_function
from drivegate_lab.kernels.designs.state import DESIGN_STATE
from drivegate_models.contract.current.records import nameplate_record
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.errors import HarnessFault


class DesignController(CompiledController):
    """One instance of a correct design, which has a table of its drive's angles.

    `state_size`: size of the state (bytes).
    """

    def __init__(self, name: str) -> None:
        super().__init__(design_step_function(), np.zeros(1, DESIGN_STATE))
        self._number = DESIGNS[name]
        self._drive: DriveDocument | None = None
        self.state_size: int = self._state.nbytes

    def show_drive(self, drive: DriveDocument) -> None:
        """Take the drive that the table is to be of."""
        if drive == self._drive:
            return
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
        design_reset_function()(self._state, nameplate_record(nameplate), self._number)
