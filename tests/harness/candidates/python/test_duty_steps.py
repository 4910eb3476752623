"""A Python controller of duty ratios behind its C function: what it senses, what it may answer, how faults read."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from drivegate import LEG_HIGH, LEG_LOW, LEG_OFF, Command, DutyCommand, DutyNameplate, DutySense, Nameplate
from drivegate.candidates.fault import FaultKind
from drivegate.candidates.python.bridge import PythonController
from drivegate_models.contract.current.records import STOP
from drivegate_models.contract.duty.records import duty_command_record, duty_sense_record

NAMEPLATE = DutyNameplate(3, 1, 2, 1, 1, *(float(number) for number in range(13)))
CURRENTS = np.array([1.0, -2.5, 1.5])
SENSE = DutySense(
    0.25,
    3.5,
    (1.0, -2.5, 1.5),
    96.0,
    1.25,
    0.5,
    104.0,
    5,
    -1,
    2,
    (3.5, -0.5, 60.0),
    winding_temperature=41.5,
    mean_voltages=(3.0, -0.5, 61.0),
)
STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


def controller_of(step: Callable[[Any], Any]) -> PythonController:
    controller = PythonController(SimpleNamespace(step=step, reset=lambda _nameplate: None))
    controller.reset(NAMEPLATE)
    return controller


def stepped(controller: PythonController) -> Any:
    """Call the controller's step by its address, as the compiled loop does."""
    sense, command = duty_sense_record(CURRENTS), duty_command_record()
    for name in DutySense._fields:
        if name != "phase_currents":
            sense[name] = getattr(SENSE, name)
    STEP(controller.step_address)(controller.state_address, sense.ctypes.data, command.ctypes.data)
    return command[0]


def test_the_controller_receives_the_sense_as_it_is() -> None:
    sensed: list[DutySense] = []
    stepped(controller_of(lambda sense: sensed.append(sense) or DutyCommand((0.5, 0.5, 0.5))))
    assert sensed == [SENSE]
    assert isinstance(sensed[0], DutySense)


def test_the_whole_answer_arrives() -> None:
    answer = DutyCommand(
        (0.1, 0.2, 0.3), (LEG_OFF, LEG_HIGH, LEG_LOW), 1e-4, 1.5, 0.5, 100.0, 250.0, 17, 0.75
    )
    command = stepped(controller_of(lambda _sense: answer))
    assert list(command.tolist())[1:] == [0.1, 0.2, 0.3, 0, 2, 3, 1e-4, 1.5, 0.5, 100.0, 250.0, 17, 0.75]
    assert command["struct_size"] == command.dtype.itemsize


@pytest.mark.parametrize("ratios", [[0, 1, 0.5], np.array([0.0, 1.0, 0.5]), (np.float32(0.0), 1, 0.5)])
def test_three_real_numbers_of_any_kind_are_duty_ratios(ratios: Any) -> None:
    command = stepped(controller_of(lambda _sense: DutyCommand(ratios)))
    assert [command[name] for name in ("first_duty", "second_duty", "third_duty")] == [0.0, 1.0, 0.5]
    assert math.isnan(command["torque"])


def test_what_is_out_of_range_is_for_the_checks() -> None:
    command = stepped(controller_of(lambda _sense: DutyCommand((1.2, -0.1, 0.5), next_period=-1.0)))
    assert (command["first_duty"], command["second_duty"], command["next_period"]) == (1.2, -0.1, -1.0)


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (None, r"step returned None, but must return a drivegate.DutyCommand(duty_ratios)"),
        ((0.5, 0.5, 0.5), "an object of type tuple"),
        (DutyCommand((0.5, math.nan, 0.5)), "duty_ratios are 0.5, nan, 0.5, but all must be finite"),
        (DutyCommand((0.5, 0.5, math.inf)), "inf, but all must be finite"),
        (DutyCommand((0.5, 0.5)), "duty_ratios must have three numbers, one for each leg"),
        (DutyCommand(0.5), "duty_ratios must have three numbers"),
        (DutyCommand(("a", 0.5, 0.5)), "a duty ratio is of type str, but must be a real number"),
        (DutyCommand((0.5, 0.5, 0.5), (1, 7, 1)), "legs are 1, 7, 1, but each must be from 0 to 3"),
        (DutyCommand((0.5, 0.5, 0.5), (1, 1, 1.5)), "a leg is of type float, but must be an integer"),
        (DutyCommand((0.5, 0.5, 0.5), (1, 1, True)), "a leg is of type bool"),
        (DutyCommand((0.5, 0.5, 0.5), (1,)), "legs must have three numbers"),
        (DutyCommand((0.5, 0.5, 0.5), next_period=math.nan), "next_period is nan, but must be finite, or 0"),
        (DutyCommand((0.5, 0.5, 0.5), torque=math.inf), "torque is inf, but must be finite, or NaN"),
        (DutyCommand((0.5, 0.5, 0.5), fault=2**63), "fault is 9223372036854775808, but must be an integer"),
    ],
)
def test_an_answer_that_is_none_ends_the_run_with_a_sentence(answer: Any, message: str) -> None:
    controller = controller_of(lambda _sense: answer)
    assert stepped(controller)["struct_size"] == STOP
    fault = controller.fault
    assert fault is not None
    assert (fault.kind, fault.phase, fault.time) == (FaultKind.INVALID_OUTPUT, "step", 0.25)
    assert message in fault.message
    assert fault.sense is not None
    assert fault.sense["phase_currents"] == (1.0, -2.5, 1.5)
    assert controller.refusal is None


def test_an_exception_is_a_fault_with_its_sense() -> None:
    controller = controller_of(lambda sense: sense.phase_currents[3])
    stepped(controller)
    fault = controller.fault
    assert fault is not None
    assert (fault.kind, fault.error) == (FaultKind.EXCEPTION, "IndexError")


def test_an_answer_of_the_other_contract_is_refused_either_way() -> None:
    controller = controller_of(lambda _sense: Command(1.0, 0.5))
    stepped(controller)
    assert str(controller.refusal).startswith(
        "the controller answers with a current reference and an advance angle, but the drive takes duty ratios"
    )
    other = PythonController(
        SimpleNamespace(step=lambda _sense: DutyCommand((0.5, 0.5, 0.5)), reset=lambda _nameplate: None)
    )
    plate = Nameplate(3, 1, *(1.0,) * 10, 1, *(1.0,) * 5)
    other.reset(plate)
    from drivegate_models.contract.current.records import command_record, sense_record
    from drivegate_models.contract.current.signals import Sense

    sense = sense_record(Sense(0.0, 1.0, 1.0, (0.0,) * 3, 0.0, 48.0), np.zeros(3))
    command = command_record()
    STEP(other.step_address)(other.state_address, sense.ctypes.data, command.ctypes.data)
    assert "answers with duty ratios, but the drive takes a current reference" in str(other.refusal)


def test_one_instance_may_serve_both_contracts_by_its_nameplate() -> None:
    controller = controller_of(lambda _sense: DutyCommand((0.25, 0.5, 0.75)))
    first = controller.step_address
    controller.reset(Nameplate(3, 1, *(1.0,) * 10, 1, *(1.0,) * 5))
    assert controller.step_address != first
    controller.reset(NAMEPLATE)
    assert controller.step_address == first
    assert stepped(controller)["third_duty"] == 0.75
