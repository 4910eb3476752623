"""Builds of one controller in a process: the plain one answers, the instrumented one must answer as its reference."""

from __future__ import annotations

import ctypes
from typing import Any, Final

import numpy as np

from drivegate.candidates.candidate import Instrument, Instrumented
from drivegate.candidates.contract import AnyNameplate, require_nameplate_of
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind
from drivegate.candidates.native.controller import NativeController
from drivegate.candidates.native.exact_memory import ExactMemory
from drivegate_models.contract.duty.signals import DutyNameplate
from drivegate_models.contract.layout import LAYOUTS, Layout

STEP_BOTH: Final = "drivegate_step_two_builds"
"""Name of the function in `two_builds.c` that steps both builds."""
WRITE_COUNTERS: Final = "drivegate_write_counters"
"""Name of the function there that writes what was counted into files."""

_LONGEST_ANSWER: Final = 256
_DUTY_PHASES: Final = 3
_CAUSES: Final[dict[Instrument, str]] = {
    "coverage": "two builds of the same sources differ where the code reads what it never wrote, goes beyond an array "
    "or overflows; look for that with --sanitize address,undefined",
    "sanitizers": "what was never written has other values in it, so look for a variable that is read before, also "
    "with -Wuninitialized or valgrind",
}
_REFERENCES: Final[dict[Instrument, str]] = {
    "coverage": "the plain one",
    "sanitizers": "the same without them",
}
_WORDS: Final[dict[Instrument, str]] = {
    "coverage": "the build that counts lines",
    "sanitizers": "the build with sanitizers",
}


class _Builds(ctypes.Structure):
    """The record `builds` of `two_builds.c`."""

    _fields_ = (
        ("plain", ctypes.c_void_p),
        ("instrumented", ctypes.c_void_p),
        ("reference", ctypes.c_void_p),
        ("plain_state", ctypes.c_void_p),
        ("instrumented_state", ctypes.c_void_p),
        ("reference_state", ctypes.c_void_p),
        ("sense", ctypes.c_void_p),
        ("currents", ctypes.c_void_p),
        ("command", ctypes.c_void_p),
        ("sense_size", ctypes.c_int64),
        ("command_size", ctypes.c_int64),
        ("currents_offset", ctypes.c_int64),
        ("currents_size", ctypes.c_int64),
        ("differs", ctypes.c_int64),
        ("answers", ctypes.c_ubyte * _LONGEST_ANSWER * 2),
    )


class TwoBuilds:
    """The builds of a candidate as one controller, which answers as the plain one does.

    `reference`: what the instrumented build is compared with; None for the plain one. `step`: address of the function
    that steps all. `how`: what the instrumented build is for. `write_counters`: writes what was counted; None where
    nothing is.
    """

    def __init__(
        self,
        plain: NativeController,
        instrumented: NativeController,
        reference: NativeController | None,
        step: int,
        how: Instrumented,
        write_counters: Any = None,
    ) -> None:
        self._plain, self._instrumented, self._reference, self._how = plain, instrumented, reference, how
        self._write_counters = write_counters
        self.contract = plain.contract
        self.step_address = step
        self.state_size = plain.state_size
        self._layout: Layout = next(each for each in LAYOUTS.values() if each.name == plain.contract)
        sense, command = self._layout.sense, self._layout.command
        fields: Any = sense.fields
        assert command.itemsize <= _LONGEST_ANSWER
        self._sense, self._command = ExactMemory(sense.itemsize), ExactMemory(command.itemsize)
        self._currents: ExactMemory | None = None
        self._builds = _Builds(
            plain=plain.step_address,
            instrumented=instrumented.step_address,
            plain_state=plain.state_address,
            instrumented_state=instrumented.state_address,
            reference=0 if reference is None else reference.step_address,
            reference_state=0 if reference is None else reference.state_address,
            sense=self._sense.address,
            command=self._command.address,
            sense_size=sense.itemsize,
            command_size=command.itemsize,
            currents_offset=fields["phase_currents"][1],
        )
        self.state_address = ctypes.addressof(self._builds)

    @property
    def fault(self) -> Fault | None:
        """What ended the last run: a refusal of the reset, or answers that differ."""
        if self._plain.fault is not None or not self._builds.differs:
            return self._plain.fault
        return Fault(FaultKind.BUILDS, self._difference(), "step")

    def reset(self, nameplate: AnyNameplate) -> None:
        require_nameplate_of(self.contract, nameplate)
        phases = _DUTY_PHASES if isinstance(nameplate, DutyNameplate) else nameplate.phases
        self._currents = ExactMemory(phases * 8)
        self._builds.currents, self._builds.currents_size = self._currents.address, phases * 8
        self._builds.differs = 0
        self.write_counters()
        # First, so that what ends the process in any build is reported.
        found = self._refusal_of(self._instrumented, nameplate)
        refused = self._refusal_of(self._plain, nameplate)
        expected = refused if self._reference is None else self._refusal_of(self._reference, nameplate)
        if found != expected:
            message = f"{_WORDS[self._how.by]} ends its reset otherwise than the plain one; {self._causes()}"
            raise CandidateFault(Fault(FaultKind.BUILDS, message, "reset"))
        if refused is not None:
            raise CandidateFault(refused)

    def _refusal_of(self, build: NativeController, nameplate: AnyNameplate) -> Fault | None:
        try:
            build.reset(nameplate)
        except CandidateFault as refused:
            return refused.fault
        return None

    def write_counters(self) -> None:
        """Write what was counted since the last time; the variables of the library may be put back after that."""
        if self._write_counters is not None:
            self._write_counters()

    def _difference(self) -> str:
        expected, instrumented = (
            np.frombuffer(bytes(answer), self._layout.command, 1)[0] for answer in self._builds.answers
        )
        different = (
            f": {name} is {instrumented[name]} instead of {expected[name]}"
            for name in self._layout.command.names or ()
            if expected[name].tobytes() != instrumented[name].tobytes()
        )
        what = (
            f"{_WORDS[self._how.by]} answers otherwise than {_REFERENCES[self._how.by]}{next(different, '')}"
        )
        return f"{what}; {self._causes()}"

    def _causes(self) -> str:
        if self._how.suspects:
            return f"the compiler suspects {'; '.join(self._how.suspects)}"
        return _CAUSES[self._how.by]
