"""The contract of duty ratios as binary records: only 64-bit numbers and pointers, so that no compiler pads them.

The first field of each record is its own size in bytes. Later minor versions append fields and do not change others.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.current.records import record_of
from drivegate_models.contract.duty.signals import LEG_PWM, DutyNameplate, DutySense

DUTY_SENSE: Final = record_of(DutySense)
"""Record of `signals.DutySense`; `phase_currents` is the address of three doubles."""

DUTY_COMMAND: Final = np.dtype(
    [
        ("struct_size", np.int64),
        ("first_duty", np.float64),
        ("second_duty", np.float64),
        ("third_duty", np.float64),
        ("first_leg", np.int64),
        ("second_leg", np.int64),
        ("third_leg", np.int64),
        ("next_period", np.float64),
        ("torque", np.float64),
        ("angle", np.float64),
        ("speed", np.float64),
        ("input_power", np.float64),
        ("fault", np.int64),
        ("brake_duty", np.float64),
    ],
    align=True,
)
"""Record of `signals.DutyCommand`, with one field per element of its triples."""

DUTY_NAMEPLATE: Final = record_of(DutyNameplate)


def duty_sense_record(phase_currents: NDArray[np.float64]) -> NDArray[Any]:
    """Return a record for the harness to fill.

    `phase_currents`, shape (3,): phase currents (A). The record points to it, so it must outlive the record. Result,
    shape (1,): with the default of each field that has one, and otherwise zeros.
    """
    record = np.zeros(1, DUTY_SENSE)
    record["struct_size"] = DUTY_SENSE.itemsize
    record["phase_currents"] = phase_currents.ctypes.data
    for name, value in DutySense._field_defaults.items():
        record[name] = value
    return record


def duty_command_record() -> NDArray[Any]:
    """Return a record for a controller to fill.

    Result, shape (1,): all legs follow their duty ratios, which are NaN to detect missing ones.
    """
    record = np.zeros(1, DUTY_COMMAND)
    record["struct_size"] = DUTY_COMMAND.itemsize
    for name in ("first_leg", "second_leg", "third_leg"):
        record[name] = LEG_PWM
    for name in DUTY_COMMAND.names or ():
        if DUTY_COMMAND[name] == np.float64 and name != "next_period":
            record[name] = np.nan
    return record


def duty_nameplate_record(nameplate: DutyNameplate) -> NDArray[Any]:
    """Return a nameplate as a record.

    Result, shape (1,): with its own size in the first field.
    """
    return np.array([(DUTY_NAMEPLATE.itemsize, *nameplate)], dtype=DUTY_NAMEPLATE)
