"""What the callbacks of both contracts share: how a step that goes wrong ends the run, and what a number is."""

from __future__ import annotations

import ctypes
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import replace
from numbers import Real
from struct import Struct
from typing import Any, ClassVar, TypeAlias

from drivegate.candidates.contract import ContractName, other_contract
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind, Phase, bounded_line, exception_fault
from drivegate_models.contract.current.records import STOP
from drivegate_models.contract.current.signals import Command, Sense
from drivegate_models.contract.duty.signals import DutyCommand, DutySense
from drivegate_models.errors import InputError

_STOP = Struct("=q").pack(STOP)

AnySense: TypeAlias = Sense | DutySense


_COMMANDS: dict[ContractName, type] = {"current": Command, "duty": DutyCommand}
_EXAMPLES: dict[ContractName, str] = {
    "current": "drivegate.Command(current_reference, advance_angle)",
    "duty": "drivegate.DutyCommand(duty_ratios)",
}


class InvalidOutput(Exception):
    """What a candidate's step returned is not a command that the plant could take."""


class BridgedSteps(ABC):
    """What a callback works on; `step` is the C function's body.

    `refusal`: what ended it, where that is the drive and no fault: the candidate answers by the other contract.
    `candidate_step`: the candidate's method.
    """

    contract: ClassVar[ContractName]
    sizes: ClassVar[tuple[int, int]]
    """Sizes of the contract's Sense and Command (bytes)."""

    def __init__(self, candidate_step: Callable[[Any], Any]) -> None:
        self.fault: Fault | None = None
        self.refusal: InputError | None = None
        self.candidate_step = candidate_step
        self.sense_address = self.command_address = self.currents_address = 0
        self.sense_view = self.command_view = self.currents_view = (ctypes.c_char * 0)()

    def look_at(self, sense_address: int, command_address: int) -> None:
        """Make views of the memory at two addresses, which stay the same during a run."""
        self.sense_address, self.command_address = sense_address, command_address
        self.sense_view, self.command_view = (
            (ctypes.c_char * size).from_address(address)
            for size, address in zip(self.sizes, (sense_address, command_address), strict=True)
        )

    @abstractmethod
    def step(self, state: int | None, sense_address: int, command_address: int) -> None:
        """Step the candidate on what lies at an address, and write its answer to another."""

    def stop(self, error: BaseException, sense: AnySense | None, command_address: int) -> None:
        """End the run. Memory may be exhausted, so the loop is stopped first and the fault may stay terse."""
        ctypes.memmove(command_address, _STOP, len(_STOP))
        if self.fault is not None:
            return
        name = type(error).__name__
        self.fault = Fault(FaultKind.EXCEPTION, name, "step", error=name)
        if isinstance(error, OtherContract):
            self.refusal = error
        try:
            self.fault = _step_fault(error, sense)
        except MemoryError:
            return

    def not_a_command(self, answer: object) -> Exception:
        """Return what is wrong with an answer that is no command of this contract."""
        for other, command in _COMMANDS.items():
            if other != self.contract and isinstance(answer, command):
                return OtherContract(other_contract(other, self.contract))
        what = "None" if answer is None else f"an object of type {type(answer).__name__}"
        return InvalidOutput(f"step returned {what}, but must return a {_EXAMPLES[self.contract]}")


class OtherContract(InputError):
    """A candidate answered as drives of the other contract take it."""


def real_number(name: str, value: object) -> float:
    """Accept what is a real number to Python, such as an int or a numpy scalar."""
    if isinstance(value, bool) or not isinstance(value, Real):
        raise InvalidOutput(f"{name} is of type {type(value).__name__}, but must be a real number")
    try:
        return float(value)
    except OverflowError:
        raise InvalidOutput(f"{name} is an integer too large for a 64-bit float") from None


def _step_fault(error: BaseException, sense: AnySense | None) -> Fault:
    phase: Phase = "step"
    if isinstance(error, CandidateFault):
        fault = error.fault
    elif isinstance(error, InvalidOutput | OtherContract):
        fault = Fault(FaultKind.INVALID_OUTPUT, bounded_line(str(error)), phase)
    else:
        fault = exception_fault(error, phase)
    return fault if sense is None else replace(fault, time=sense.time, sense=sense._asdict())
