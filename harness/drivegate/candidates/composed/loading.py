"""Loading a composed candidate: the blocks that may be the user's own, how each is called, and the compiled rest.

Each block is behind the same bridge as a Python controller: it gets a Sense and answers in a field of a Command.

This runs the candidate's code, so it belongs into a worker process.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from math import isfinite
from numbers import Real
from types import MappingProxyType
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.candidate import Candidate, Composition
from drivegate.candidates.controller import CompiledController, Controller
from drivegate.candidates.fault import CandidateFault, Fault, exception_fault
from drivegate.candidates.python.bridge import PythonController
from drivegate.candidates.python.bridged_steps import InvalidOutput
from drivegate.candidates.python.loading import named_in_module
from drivegate_cases.documents.wording import one_line
from drivegate_models.contract.current.records import nameplate_record
from drivegate_models.contract.current.signals import Command, Nameplate, Sense
from drivegate_models.controllers.current.builtin import SEARCHES, reset_function
from drivegate_models.controllers.current.composed import COMPOSED_STATE, composed_step_function
from drivegate_models.errors import HarnessFault, InputError

_CONTROLLER: Final = "controller"


@dataclass(frozen=True)
class Exchanged:
    """What passes between blocks and the compiled rest besides Sense and Command; views of its state, shape (1,)."""

    line_speed: NDArray[np.float64]
    """The speed that the angle model is evaluated at (rad/s)."""
    current_reference: NDArray[np.float64]
    """The regulator's answer, for the search (A)."""
    integral: NDArray[np.float64]
    """What the regulator keeps and the reference controller's search may set back (A)."""


class AngleModelStep:
    """The initial advance angle (Fig. 3): a function ``angle_model(speed, nameplate)`` that returns rad."""

    def __init__(self, found: Any, exchanged: Exchanged) -> None:
        if isinstance(found, type) or not callable(found):
            raise InputError(
                "the block angle_model must be a function angle_model(speed, nameplate) that returns an angle in rad, "
                f"but {_named(found)} is {'a class' if isinstance(found, type) else 'no function'}"
            )
        _refuse_wrong_arguments(found, "angle_model(speed, nameplate)", 2)
        self._angle: Callable[[float, Nameplate], object] = found
        self._line_speed = exchanged.line_speed

    def reset(self, nameplate: Nameplate) -> None:
        """Take over the nameplate."""
        self._nameplate = nameplate

    def step(self, sense: Sense) -> Command:  # noqa: ARG002  (the bridge's signature)
        """Request the angle."""
        angle = self._angle(float(self._line_speed[0]), self._nameplate)
        return Command(0.0, _number(angle, "angle_model", "an angle in rad"))


class SpeedRegulatorStep:
    """The speed regulator: ``reset(nameplate)`` and ``step(speed_reference, speed, dt)``, which returns A."""

    def __init__(self, found: Any, exchanged: Exchanged) -> None:
        self._regulator = _instance(found, "speed_regulator", "step(speed_reference, speed, dt)", 3)
        self._integral = exchanged.integral
        self._reported = 0.0
        self._period = 0.0

    def reset(self, nameplate: Nameplate) -> None:
        """Reset the regulator."""
        self._period = nameplate.control_period
        self._regulator.reset(nameplate)
        self._reported = 0.0

    def step(self, sense: Sense) -> Command:
        """Set its integral back where the search did, request the current reference, and report its integral."""
        restored = float(self._integral[0])
        keeps = hasattr(self._regulator, "integral")
        if keeps and restored != self._reported:
            self._regulator.integral = restored
        answer = self._regulator.step(sense.speed_reference, sense.speed, self._period)
        current_reference = _number(answer, "speed_regulator.step", "a current in A")
        kept = self._regulator.integral if keeps else current_reference
        self._reported = _number(kept, "speed_regulator.integral", "a current in A")
        self._integral[0] = self._reported
        return Command(current_reference, 0.0)


class SearchStep:
    """The search (Fig. 4): ``reset(nameplate)`` and ``step(sense, current_reference)``, which returns rad."""

    def __init__(self, found: Any, exchanged: Exchanged) -> None:
        self._search = _instance(found, "search", "step(sense, current_reference)", 2)
        self._reference = exchanged.current_reference

    def reset(self, nameplate: Nameplate) -> None:
        """Reset the search."""
        self._search.reset(nameplate)

    def step(self, sense: Sense) -> Command:
        """Request what is to be added to the initial angle."""
        offset = self._search.step(sense, float(self._reference[0]))
        return Command(0.0, _number(offset, "search.step", "an angle in rad"))


BLOCK_STEPS: Final = MappingProxyType(
    {"angle_model": AngleModelStep, "speed_regulator": SpeedRegulatorStep, "search": SearchStep}
)
"""How each block is called, by its name."""


def _instance(found: Any, block: str, step: str, arguments: int) -> Any:
    if not isinstance(found, type):
        raise InputError(
            f"the block {block} must be a class with reset(nameplate) and {step}, but {_named(found)} is no class"
        )
    for method in ("reset", "step"):
        if not callable(getattr(found, method, None)):
            raise InputError(
                f"the class {_named(found)} has no method '{method}'; the block {block} has reset(nameplate) and {step}"
            )
    try:
        made = found()
    except BaseException as error:
        raise CandidateFault(exception_fault(error, "loading")) from error
    _refuse_wrong_arguments(made.reset, f"{block}.reset(nameplate)", 1)
    _refuse_wrong_arguments(made.step, f"{block}.{step}", arguments)
    return made


def _refuse_wrong_arguments(function: Callable[..., object], call: str, arguments: int) -> None:
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):
        # What has no signature, such as a function of an extension module, shows at its first call.
        return
    try:
        signature.bind(*range(arguments))
    except TypeError:
        raise InputError(
            f"{_named(function)} takes {one_line(str(signature))}, but is called as {call}; give it these arguments"
        ) from None


def _named(found: object) -> str:
    return f"'{one_line(str(getattr(found, '__qualname__', type(found).__name__)))}'"


def _number(answer: object, what: str, expected: str) -> float:
    if type(answer) is not float:
        if isinstance(answer, bool) or not isinstance(answer, Real):
            raise InvalidOutput(f"{what} is of type {type(answer).__name__}, but must be {expected}")
        answer = float(answer)
    if not isfinite(answer):
        raise InvalidOutput(f"{what} is {answer}, but must be finite: {expected}")
    return answer


def compile_own_code(_candidate: Candidate) -> None:
    """Compile the rest that blocks are put into."""
    composed_step_function()


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
