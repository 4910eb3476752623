"""Three controllers: a good one, one that is equal to it but for a late change, and one without integral action."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import numpy as np
from tests.toy_contract.motor import COMMAND, SENSE, STEP, toy_drive

from drivegate.candidates import kinds
from drivegate.candidates.candidate import Candidate
from drivegate.candidates.declaration import Declaration
from drivegate_models.errors import InputError

INTEGRAL_GAINS = {"good": 40.0, "late": 40.0, "weak": 0.0}
LATE_S = 0.2


class ToyController:
    """Proportional and integral action on the speed, with the EMF fed forward."""

    state_address = 0
    fault = None

    def __init__(self, name: str) -> None:
        self._name = name
        self._callback = STEP(self._step)
        self.step_address = ctypes.cast(self._callback, ctypes.c_void_p).value or 0
        self._integral = 0.0

    def reset(self, nameplate: dict[str, float]) -> None:
        self._nameplate, self._integral = nameplate, 0.0

    def _step(self, _state: int, sensed: int, answered: int) -> None:
        sense = np.frombuffer((ctypes.c_char * SENSE.itemsize).from_address(sensed), SENSE)[0]
        command = np.frombuffer((ctypes.c_char * COMMAND.itemsize).from_address(answered), COMMAND)
        error = sense["reference"] - sense["speed"]
        self._integral += INTEGRAL_GAINS[self._name] * error * self._nameplate["control_period"]
        voltage = self._nameplate["emf_constant"] * sense["speed"] + 2.0 * error + self._integral
        command["voltage"] = voltage + 0.125 * (self._name == "late" and sense["time"] >= LATE_S)


class ToyKind(kinds.Kind):
    def from_text(self, specification: str) -> Candidate:
        name = specification.removeprefix("toy:")
        if name not in INTEGRAL_GAINS:
            raise InputError(f"the candidate '{name}' must be one of {', '.join(INTEGRAL_GAINS)}")
        contract: Any = "toy"
        return Candidate(
            specification,
            "toy",
            specification,
            name,
            Path.cwd(),
            (),
            "0" * 64,
            Declaration(),
            None,
            toy_drive(),
            contract,
        )

    def load_controller(self, candidate: Candidate) -> Any:
        return ToyController(candidate.entry)


KIND = ToyKind("toy", "toy", prefixes=("toy:",), is_included=True)
