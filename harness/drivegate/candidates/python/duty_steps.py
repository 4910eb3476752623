"""Steps of a Python candidate that answers with duty ratios, behind the C function that the compiled loop calls."""

from __future__ import annotations

import ctypes
from math import isfinite, isinf, isnan
from numbers import Integral
from operator import itemgetter
from struct import Struct
from typing import Any, ClassVar, Final

from drivegate.candidates.contract import ContractName
from drivegate.candidates.fault import UNSENSED
from drivegate.candidates.python.bridged_steps import BridgedSteps, InvalidOutput, real_number
from drivegate_models.contract.current.records import packing
from drivegate_models.contract.duty.records import DUTY_COMMAND, DUTY_SENSE
from drivegate_models.contract.duty.signals import LEG_LOW, LEG_OFF, DutyCommand, DutySense

_SENSE: Final = packing(DUTY_SENSE)
# The fields after the phase currents among the unpacked numbers; a slice is a tuple there.
_FIELDS: Any = DUTY_SENSE.fields
_OTHERS: Final = itemgetter(
    *(
        slice(place // 8, (place + layout.itemsize) // 8) if layout.shape else place // 8
        for layout, place in (_FIELDS[name] for name in DutySense._fields[3:])
    )
)
_CURRENTS: Final = Struct("=3d")
_OUTPUTS: Final = Struct("=3d3q5dqd")
_OUTPUTS_OFFSET: Final = DUTY_COMMAND.itemsize - _OUTPUTS.size
_NUMBERS: Final = DutyCommand._fields[2:7]
_LARGEST: Final = 2**63


class DutySteps(BridgedSteps):
    contract: ClassVar[ContractName] = "duty"
    sizes: ClassVar = (DUTY_SENSE.itemsize, DUTY_COMMAND.itemsize)

    def step(self, _state: int | None, sense_address: int, command_address: int) -> None:
        sense = None
        try:
            if sense_address != self.sense_address or command_address != self.command_address:
                self.look_at(sense_address, command_address)
            values = _SENSE.unpack_from(self.sense_view)
            _, time, reference, currents, *_ = values
            if currents != self.currents_address:
                self.currents_address = currents
                self.currents_view = (ctypes.c_char * _CURRENTS.size).from_address(currents)
            sense = DutySense(time, reference, _CURRENTS.unpack_from(self.currents_view), *_OTHERS(values))
            answer = self.candidate_step(sense)
            if not isinstance(answer, DutyCommand):
                raise self.not_a_command(answer)
            # While the bridge is off nothing of it acts.
            if sense.enable:
                _OUTPUTS.pack_into(
                    self.command_view,
                    _OUTPUTS_OFFSET,
                    *_ratios(answer, sense),
                    *_legs(answer),
                    *_rest(answer),
                )
        except BaseException as error:
            self.stop(error, sense, command_address)


def _three(name: str, values: Any) -> tuple[Any, Any, Any]:
    try:
        first, second, third = values
    except (TypeError, ValueError):
        raise InvalidOutput(f"{name} must have three numbers, one for each leg") from None
    return first, second, third


def _integer(name: str, value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise InvalidOutput(f"{name} is of type {type(value).__name__}, but must be an integer")
    return int(value)


def _ratios(answer: DutyCommand, sense: DutySense) -> tuple[float, float, float]:
    first, second, third = _three("duty_ratios", answer.duty_ratios)
    if not (type(first) is type(second) is type(third) is float):
        first, second, third = (real_number("a duty ratio", value) for value in (first, second, third))
    if not (isfinite(first) and isfinite(second) and isfinite(third)):
        because = UNSENSED if isnan(sense.angle) and sense.hall < 0 else ""
        raise InvalidOutput(f"duty_ratios are {first}, {second}, {third}, but all must be finite{because}")
    return first, second, third


def _legs(answer: DutyCommand) -> tuple[int, int, int]:
    first, second, third = _three("legs", answer.legs)
    if not (type(first) is type(second) is type(third) is int):
        first, second, third = (_integer("a leg", value) for value in (first, second, third))
    if not (LEG_OFF <= first <= LEG_LOW and LEG_OFF <= second <= LEG_LOW and LEG_OFF <= third <= LEG_LOW):
        raise InvalidOutput(
            f"legs are {first}, {second}, {third}, but each must be from {LEG_OFF} to {LEG_LOW}"
        )
    return first, second, third


def _rest(answer: DutyCommand) -> tuple[float, float, float, float, float, int, float]:
    _, _, period, torque, angle, speed, power, fault, brake = answer
    if type(brake) is not float:
        brake = real_number("brake_duty", brake)
    if isinf(brake):
        raise InvalidOutput(
            f"brake_duty is {brake}, but must be from 0 to 1, or NaN for the chopper's own thresholds"
        )
    if not (type(period) is type(torque) is type(angle) is type(speed) is type(power) is float):
        period, torque, angle, speed, power = map(
            real_number, _NUMBERS, (period, torque, angle, speed, power)
        )
    if not isfinite(period):
        raise InvalidOutput(f"next_period is {period}, but must be finite, or 0 to keep the control period")
    estimates = (torque, angle, speed, power)
    if any(map(isinf, estimates)):
        name, value = next(pair for pair in zip(_NUMBERS[1:], estimates, strict=True) if isinf(pair[1]))
        raise InvalidOutput(f"{name} is {value}, but must be finite, or NaN for no estimate")
    if type(fault) is not int:
        fault = _integer("fault", fault)
    if not -_LARGEST <= fault < _LARGEST:
        raise InvalidOutput(f"fault is {fault}, but must be an integer of 64 bits, the controller's own code")
    return period, torque, angle, speed, power, fault, brake
