"""The contract of duty ratios as binary records: only 64-bit numbers and pointers, so that no compiler pads them.

The first field of each record is its own size in bytes. Later minor versions append fields and do not change others.
"""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.duty.signals import LEG_PWM, DutyNameplate

DUTY_SENSE: Final = np.dtype(
    [
        ("struct_size", np.int64),
        ("time", np.float64),
        ("reference", np.float64),
        ("phase_currents", np.uintp),
        ("supply_voltage", np.float64),
        ("supply_current", np.float64),
        ("angle", np.float64),
        ("speed", np.float64),
        ("hall", np.int64),
        ("encoder_count", np.int64),
        ("trip", np.int64),
    ],
    align=True,
)
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
    ],
    align=True,
)
"""Record of `signals.DutyCommand`, with one field per element of its triples."""

DUTY_NAMEPLATE: Final = np.dtype(
    [
        ("struct_size", np.int64),
        ("kind", np.int64),
        ("reference_kind", np.int64),
        ("pole_pairs", np.int64),
        ("updates", np.int64),
        ("update_delay", np.int64),
        ("supply_voltage", np.float64),
        ("base_speed", np.float64),
        ("highest_speed", np.float64),
        ("rated_power", np.float64),
        ("current_limit", np.float64),
        ("control_period", np.float64),
        ("dead_time", np.float64),
        ("resistance", np.float64),
        ("direct_inductance", np.float64),
        ("quadrature_inductance", np.float64),
        ("magnet_flux", np.float64),
        ("inertia", np.float64),
        ("core_loss_conductance", np.float64),
    ],
    align=True,
)
"""Record of `signals.DutyNameplate`."""


def duty_sense_record(phase_currents: NDArray[np.float64]) -> NDArray[Any]:
    """Return a record for the harness to fill.

    Parameters
    ----------
    phase_currents : ndarray, shape (3,)
        Phase currents (A). The record points to it, so it must outlive the record.

    Returns
    -------
    array of DUTY_SENSE, shape (1,)
        For a drive without Hall switches and encoder counts.
    """
    record = np.zeros(1, DUTY_SENSE)
    record["struct_size"] = DUTY_SENSE.itemsize
    record["phase_currents"] = phase_currents.ctypes.data
    record["hall"] = -1
    record["encoder_count"] = -1
    return record


def duty_command_record() -> NDArray[Any]:
    """Return a record for a controller to fill.

    Returns
    -------
    array of DUTY_COMMAND, shape (1,)
        All legs follow their duty ratios, which are NaN to detect missing ones.
    """
    record = np.zeros(1, DUTY_COMMAND)
    record["struct_size"] = DUTY_COMMAND.itemsize
    for name in ("first_leg", "second_leg", "third_leg"):
        record[name] = LEG_PWM
    for name in ("first_duty", "second_duty", "third_duty", "torque", "angle", "speed", "input_power"):
        record[name] = np.nan
    return record


def duty_nameplate_record(nameplate: DutyNameplate) -> NDArray[Any]:
    """Return a nameplate as a record.

    Parameters
    ----------
    nameplate : DutyNameplate
        The drive's nominal data.

    Returns
    -------
    array of DUTY_NAMEPLATE, shape (1,)
        With its own size in the first field.
    """
    return np.array([(DUTY_NAMEPLATE.itemsize, *nameplate)], dtype=DUTY_NAMEPLATE)
