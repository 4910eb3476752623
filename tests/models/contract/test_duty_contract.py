"""The records of the contract of duty ratios: 64 bits a field, its own size first, nothing given before the step."""

from __future__ import annotations

import math

import numpy as np
import pytest

from drivegate_models.contract.duty import records, signals

LAYOUTS = [
    (records.DUTY_SENSE, signals.DutySense),
    (records.DUTY_COMMAND, signals.DutyCommand),
    (records.DUTY_NAMEPLATE, signals.DutyNameplate),
]


@pytest.mark.parametrize(("layout", "signal"), LAYOUTS)
def test_fields_are_of_64_bits_without_gaps(layout: np.dtype, signal: type) -> None:
    names = list(layout.names or ())
    assert names[0] == "struct_size"
    ends = np.cumsum([layout[name].itemsize for name in names])
    assert [layout.fields[name][1] for name in names] == [0, *ends[:-1]]
    assert {layout[name].base.str[1:] for name in names} <= {"f8", "i8", "u8"}
    for name in signal._fields:
        if name not in ("duty_ratios", "legs"):
            assert name in names, f"{signal.__name__}.{name} has no place in the record"


def test_a_fresh_command_gives_nothing() -> None:
    command = records.duty_command_record()[0]
    assert command["struct_size"] == records.DUTY_COMMAND.itemsize
    assert all(math.isnan(command[name]) for name in ("first_duty", "second_duty", "third_duty", "torque"))
    assert command["first_leg"] == signals.LEG_PWM


def test_a_nameplate_keeps_its_values() -> None:
    values = dict.fromkeys(signals.DutyNameplate._fields, 2)
    record = records.duty_nameplate_record(signals.DutyNameplate(**values | {"inertia": 0.25}))[0]
    assert record["struct_size"] == records.DUTY_NAMEPLATE.itemsize
    assert record["inertia"] == 0.25
    assert record["pole_pairs"] == 2
