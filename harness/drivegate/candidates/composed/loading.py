"""Loading a composed candidate: its blocks of its own, and the compiled rest.

This runs the candidate's code, so it belongs into a worker process.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from drivegate.candidates.candidate import Candidate, Composition
from drivegate.candidates.compiled_controller import CompiledController
from drivegate.candidates.composed.blocks import BLOCK_STEPS, Exchanged
from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import Fault
from drivegate.candidates.python.bridge import PythonController
from drivegate.candidates.python.loading import named_in_module
from drivegate_models.contract.current.records import nameplate_record
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.controllers.current.builtin import SEARCHES, reset_function
from drivegate_models.controllers.current.composed import COMPOSED_STATE, composed_step_function
from drivegate_models.errors import HarnessFault

_CONTROLLER: Final = "controller"


def load_controller(candidate: Candidate) -> Controller:
    """Make a new instance of a composed candidate; the modules of its blocks are imported once a process."""
    if not isinstance(candidate.details, Composition):
        raise HarnessFault(f"the candidate {candidate.name} of kind {candidate.kind} has no blocks")
    named = {name: named_in_module(candidate, entry) for name, entry in candidate.details.blocks}
    return ComposedController(candidate.details.base, named)


class ComposedController(CompiledController):
    """One instance of a composed controller."""

    def __init__(self, base: str, blocks: dict[str, Any]) -> None:
        super().__init__(composed_step_function(), np.zeros(1, COMPOSED_STATE))
        self._search = SEARCHES[base]
        exchanged = Exchanged(
            self._state["line_speed"], self._state["current_reference"], self._state["integral"]
        )
        self._bridges = {
            name: PythonController(BLOCK_STEPS[name](found, exchanged)) for name, found in blocks.items()
        }

    @property
    def fault(self) -> Fault | None:
        """What ended the last run, if a block did."""
        faults = (bridge.fault for bridge in self._bridges.values())
        return next((fault for fault in faults if fault is not None), None)

    def reset(self, nameplate: Nameplate) -> None:
        """Write the constants, forget everything else, and reset the blocks."""
        reset_function()(self._state[_CONTROLLER], nameplate_record(nameplate), self._search)
        for name, bridge in self._bridges.items():
            bridge.reset(nameplate)
            self._state[0][name] = bridge.step_address
