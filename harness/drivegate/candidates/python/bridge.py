"""A Python controller behind the C function that the compiled loop calls.

The callback runs once per control period, so it reads and writes the binary records with precompiled
`struct` packings over cached views. Whatever the candidate does, no exception leaves the callback: what went
wrong becomes a `Fault`, and the command requests a stop of the loop.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from math import isfinite, isinf
from struct import Struct
from typing import Any, ClassVar, Final

from drivegate.candidates.contract import AnyNameplate, ContractName, contract_of
from drivegate.candidates.fault import CandidateFault, Fault, exception_fault
from drivegate.candidates.python.bridged_steps import BridgedSteps, InvalidOutput, real_number
from drivegate.candidates.python.duty_steps import DutySteps
from drivegate_models.contract.current.records import COMMAND, SENSE, packing
from drivegate_models.contract.current.signals import Command, Sense
from drivegate_models.errors import InputError

_CALLBACK = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)
_SENSE = packing(SENSE)
_OUTPUTS = Struct("=" + "d" * len(Command._fields))
_OUTPUTS_OFFSET = COMMAND.fields["current_reference"][1] if COMMAND.fields else 0


class PythonController:
    """One instance of a Python candidate, steppable by address, by the contract of the nameplate that resets it.

    Its `reset(nameplate)` forgets all earlier runs. Its `step(sense)` answers a Sense with a Command, and a DutySense
    with a DutyCommand. `remarks` returns what the process has warned of so far.
    """

    state_address = 0
    """The state is in the Python object."""

    def __init__(self, instance: Any, remarks: Callable[[], tuple[str, ...]] = tuple) -> None:
        self.instance = instance
        self.remarks = remarks
        self._bridges: dict[ContractName, _Bridge] = {}
        self._bridge = self._bridge_of("current")

    def _bridge_of(self, contract: ContractName) -> _Bridge:
        if contract not in self._bridges:
            self._bridges[contract] = _Bridge(_STEPS[contract](self.instance.step))
        return self._bridges[contract]

    @property
    def step_address(self) -> int:
        """Address of a C function like `drivegate_step`, of the last reset's contract; valid as long as this lives."""
        return self._bridge.address

    @property
    def fault(self) -> Fault | None:
        return self._bridge.steps.fault

    @property
    def refusal(self) -> InputError | None:
        """What ended the run, if the candidate answers by the other contract."""
        return self._bridge.steps.refusal

    def reset(self, nameplate: AnyNameplate) -> None:
        self._bridge = self._bridge_of(contract_of(nameplate))
        steps = self._bridge.steps
        steps.fault = steps.refusal = None
        try:
            self.instance.reset(nameplate)
            steps.candidate_step = self.instance.step
        except BaseException as error:
            fault = error.fault if isinstance(error, CandidateFault) else exception_fault(error, "reset")
            steps.fault = fault
            raise CandidateFault(fault) from error


class _Bridge:
    """The callback of one contract.

    It holds the steps and not the controller, so that the instance goes when the controller does.
    """

    def __init__(self, steps: BridgedSteps) -> None:
        self.steps = steps
        self._callback = _CALLBACK(steps.step)
        # Casting would make a cycle of references, and the instance would stay until it is collected.
        self.address: int = ctypes.c_void_p.from_address(ctypes.addressof(self._callback)).value or 0


class _Steps(BridgedSteps):
    contract: ClassVar[ContractName] = "current"
    sizes: ClassVar = (SENSE.itemsize, COMMAND.itemsize)

    def __init__(self, candidate_step: Callable[[Sense], Command]) -> None:
        super().__init__(candidate_step)
        self._phases = 0
        self._currents_packing = Struct("=")

    def step(self, _state: int | None, sense_address: int, command_address: int) -> None:
        sense = None
        try:
            # The addresses stay the same during a run, and making views takes longer than reading them.
            if sense_address != self.sense_address or command_address != self.command_address:
                self.look_at(sense_address, command_address)
            _, time, speed_reference, speed, phases, currents, magnitude_sum, voltage = _SENSE.unpack_from(
                self.sense_view
            )
            if currents != self.currents_address or phases != self._phases:
                self.currents_address, self._phases = currents, phases
                self._currents_packing = Struct(f"={phases}d")
                self.currents_view = (ctypes.c_char * self._currents_packing.size).from_address(currents)
            sense = Sense(
                time,
                speed_reference,
                speed,
                self._currents_packing.unpack_from(self.currents_view),
                magnitude_sum,
                voltage,
            )
            answer = self.candidate_step(sense)
            if not isinstance(answer, Command):
                raise self.not_a_command(answer)
            current_reference, angle, power = answer
            if not (type(current_reference) is type(angle) is type(power) is float):
                current_reference, angle, power = map(real_number, Command._fields, answer)
            if not (isfinite(current_reference) and isfinite(angle)) or isinf(power):
                raise InvalidOutput(_not_finite(current_reference, angle, power))
            _OUTPUTS.pack_into(self.command_view, _OUTPUTS_OFFSET, current_reference, angle, power)
        except BaseException as error:
            self.stop(error, sense, command_address)


def _not_finite(current_reference: float, angle: float, power: float) -> str:
    if not isfinite(current_reference):
        return f"current_reference is {current_reference}, but must be finite"
    if not isfinite(angle):
        return f"advance_angle is {angle}, but must be finite"
    return f"input_power is {power}, but must be finite, or NaN for no estimate"


_STEPS: Final[dict[ContractName, type[BridgedSteps]]] = {"current": _Steps, "duty": DutySteps}
