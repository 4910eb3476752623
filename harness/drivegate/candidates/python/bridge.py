"""A Python controller behind the C function that the compiled loop calls.

The callback runs once per control period, so it reads and writes the binary records with precompiled
`struct` packings over cached views. Whatever the candidate does, no exception leaves the callback: what went
wrong becomes a `Fault`, and the command tells the loop to stop.
"""

import ctypes
from collections.abc import Callable
from dataclasses import replace
from math import isfinite, isinf
from numbers import Real
from struct import Struct
from typing import Any, Protocol

from drivegate.candidates.fault import CandidateFault, Fault, FaultKind, Phase, bounded_line, exception_fault
from drivegate_models.contract.outer_loop.records import COMMAND, SENSE, STOP, packing
from drivegate_models.contract.outer_loop.signals import Command, Nameplate, Sense

_CALLBACK = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
_SENSE = packing(SENSE)
_OUTPUTS = Struct("=" + "d" * len(Command._fields))
_OUTPUTS_OFFSET = COMMAND.fields["current_reference"][1] if COMMAND.fields else 0
_STOP = Struct("=q").pack(STOP)


class PythonCandidate(Protocol):
    """What a controller written in Python looks like."""

    def reset(self, nameplate: Nameplate) -> None:
        """Prepare for a run and forget all earlier ones."""

    def step(self, sense: Sense) -> Command:
        """Answer for one control period."""


class InvalidOutput(Exception):
    """What a candidate's step returned is not a command that the plant could take."""


class PythonController:
    """One instance of a Python candidate, steppable by address.

    Attributes
    ----------
    step_address : int
        Address of a C function of the type of `drivegate_step`; valid as long as this object lives.
    state_address : int
        Always 0: the state is in the Python object.
    instance : object
        The candidate.
    """

    def __init__(self, instance: Any) -> None:
        self.state_address = 0
        self.instance: PythonCandidate = instance
        # The callback holds the steps and not this object, so that the instance goes when this object does.
        self._steps = _Steps(instance)
        self._callback = _CALLBACK(self._steps.step)
        # Casting would make a cycle of references, and the instance would stay until it is collected.
        self.step_address = ctypes.c_void_p.from_address(ctypes.addressof(self._callback)).value or 0

    @property
    def fault(self) -> Fault | None:
        """What ended the run, if the candidate did."""
        return self._steps.fault

    def reset(self, nameplate: Nameplate) -> None:
        """Reset the candidate before a run."""
        self._steps.fault = None
        try:
            self.instance.reset(nameplate)
            self._steps.candidate_step = self.instance.step
        except BaseException as error:
            fault = error.fault if isinstance(error, CandidateFault) else exception_fault(error, "reset")
            self._steps.fault = fault
            raise CandidateFault(fault) from error


class _Steps:
    """What the callback works on."""

    def __init__(self, instance: PythonCandidate) -> None:
        self.fault: Fault | None = None
        self.candidate_step: Callable[[Sense], Command] = instance.step
        self._sense_address = self._command_address = self._currents_address = self._phases = 0
        self._sense_view = self._command_view = self._currents_view = (ctypes.c_char * 0)()
        self._currents_packing = Struct("=")

    def step(self, _state: int | None, sense_address: int, command_address: int) -> None:
        sense = None
        try:
            if sense_address != self._sense_address or command_address != self._command_address:
                self._look_at(sense_address, command_address)
            _, time, speed_reference, speed, phases, currents, magnitude_sum, voltage = _SENSE.unpack_from(
                self._sense_view
            )
            if currents != self._currents_address or phases != self._phases:
                self._look_at_currents(currents, phases)
            sense = Sense(
                time,
                speed_reference,
                speed,
                self._currents_packing.unpack_from(self._currents_view),
                magnitude_sum,
                voltage,
            )
            answer = self.candidate_step(sense)
            if not isinstance(answer, Command):
                raise InvalidOutput(_not_a_command(answer))
            current_reference, angle, power = answer
            if not (type(current_reference) is type(angle) is type(power) is float):
                current_reference, angle, power = _real_numbers(answer)
            if not (isfinite(current_reference) and isfinite(angle)) or isinf(power):
                raise InvalidOutput(_not_finite(current_reference, angle, power))
            _OUTPUTS.pack_into(self._command_view, _OUTPUTS_OFFSET, current_reference, angle, power)
        except BaseException as error:
            self._stop(error, sense, command_address)

    def _look_at(self, sense_address: int, command_address: int) -> None:
        self._sense_address, self._command_address = sense_address, command_address
        self._sense_view = (ctypes.c_char * SENSE.itemsize).from_address(sense_address)
        self._command_view = (ctypes.c_char * COMMAND.itemsize).from_address(command_address)

    def _look_at_currents(self, address: int, phases: int) -> None:
        self._currents_address, self._phases = address, phases
        self._currents_packing = Struct(f"={phases}d")
        self._currents_view = (ctypes.c_char * self._currents_packing.size).from_address(address)

    def _stop(self, error: BaseException, sense: Sense | None, command_address: int) -> None:
        """End the run. Memory may be exhausted, so the loop is stopped first and the fault may stay terse."""
        ctypes.memmove(command_address, _STOP, len(_STOP))
        if self.fault is not None:
            return
        name = type(error).__name__
        self.fault = Fault(FaultKind.EXCEPTION, name, "step", error=name)
        try:
            self.fault = _step_fault(error, sense)
        except MemoryError:
            return


def _step_fault(error: BaseException, sense: Sense | None) -> Fault:
    phase: Phase = "step"
    if isinstance(error, CandidateFault):
        fault = error.fault
    elif isinstance(error, InvalidOutput):
        fault = Fault(FaultKind.INVALID_OUTPUT, bounded_line(str(error)), phase)
    else:
        fault = exception_fault(error, phase)
    return fault if sense is None else replace(fault, time=sense.time, sense=sense._asdict())


def _not_a_command(answer: object) -> str:
    what = "None" if answer is None else f"an object of type {type(answer).__name__}"
    return f"step returned {what}, but must return a drivegate.Command(current_reference, advance_angle)"


def _real_numbers(answer: Command) -> list[float]:
    """Accept what is a real number to Python, such as an int or a numpy scalar."""
    numbers: list[float] = []
    outputs: tuple[object, ...] = tuple(answer)
    for name, value in zip(Command._fields, outputs, strict=True):
        if isinstance(value, bool) or not isinstance(value, Real):
            raise InvalidOutput(f"{name} is of type {type(value).__name__}, but must be a real number")
        try:
            numbers.append(float(value))
        except OverflowError:
            raise InvalidOutput(f"{name} is an integer too large for a 64-bit float") from None
    return numbers


def _not_finite(current_reference: float, angle: float, power: float) -> str:
    if not isfinite(current_reference):
        return f"current_reference is {current_reference}, but must be finite"
    if not isfinite(angle):
        return f"advance_angle is {angle}, but must be finite"
    return f"input_power is {power}, but must be finite, or NaN for no estimate"
