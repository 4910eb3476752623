"""The candidate contract as binary records: what `drivegate.h` declares for C, as numpy dtypes.

The records hold 64-bit numbers and one pointer only, so that no compiler pads them. The first field of each
is its own size in bytes; later minor versions append fields and change none that exist.
"""

import struct
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.current.signals import Command, Nameplate, Sense

__all__ = [
    "ABI_MAJOR",
    "ABI_MINOR",
    "ABI_VERSION",
    "COMMAND",
    "NAMEPLATE",
    "SENSE",
    "STATE_ALIGNMENT",
    "STOP",
    "Command",
    "Nameplate",
    "Sense",
    "command_record",
    "nameplate_record",
    "packing",
    "sense_record",
]

ABI_MAJOR: Final = 1
"""Version of the layout; a controller that was built for another one is refused."""

ABI_MINOR: Final = 1
"""Counts the fields appended within a major version; any is accepted."""

ABI_VERSION: Final = 1000 * ABI_MAJOR + ABI_MINOR
"""Both in one number, as a controller's `drivegate_abi_version` returns it."""

STATE_ALIGNMENT: Final = 16
"""Alignment of a native controller's state (bytes)."""

STOP: Final = -1
"""A `struct_size` that a controller's bridge leaves in a command to end the run at once."""

SENSE: Final = np.dtype(
    [
        ("struct_size", np.int64),
        ("time", np.float64),
        ("speed_reference", np.float64),
        ("speed", np.float64),
        ("phase_count", np.int64),
        ("phase_currents", np.uintp),
        ("current_magnitude_sum", np.float64),
        ("half_supply_voltage", np.float64),
    ],
    align=True,
)
"""Record of `signals.Sense`; `phase_currents` is the address of `phase_count` doubles."""

COMMAND: Final = np.dtype(
    [
        ("struct_size", np.int64),
        ("current_reference", np.float64),
        ("advance_angle", np.float64),
        ("input_power", np.float64),
    ],
    align=True,
)
"""Record of `drivegate_models.contract.current.signals.Command`."""

NAMEPLATE: Final = np.dtype(
    [
        ("struct_size", np.int64),
        ("phases", np.int64),
        ("pole_pairs", np.int64),
        ("half_supply_voltage", np.float64),
        ("base_speed", np.float64),
        ("rated_power", np.float64),
        ("current_limit", np.float64),
        ("control_period", np.float64),
        ("hysteresis_band", np.float64),
        ("resistance", np.float64),
        ("inductance", np.float64),
        ("emf_constant", np.float64),
        ("inertia", np.float64),
        ("kind", np.int64),
        ("window", np.float64),
        ("conducting_phases", np.float64),
        ("advance_start", np.float64),
        ("advance_slope", np.float64),
        ("highest_speed", np.float64),
    ],
    align=True,
)
"""Record of `drivegate_models.contract.current.signals.Nameplate`."""

_STRUCT_CODES = {"i": "q", "u": "Q", "f": "d"}


def packing(record: np.dtype[Any]) -> struct.Struct:
    """Describe a record for the standard library's `struct`, which reads single records faster than numpy.

    Parameters
    ----------
    record : dtype
        `SENSE`, `COMMAND` or `NAMEPLATE`.

    Returns
    -------
    Struct
        Packs and unpacks all fields of the record in their order.
    """
    kinds = (record[name].kind for name in record.names or ())
    return struct.Struct("=" + "".join(_STRUCT_CODES[kind] for kind in kinds))


def sense_record(sense: Sense, phase_currents: NDArray[np.float64]) -> NDArray[Any]:
    """Write a sense as a record.

    Parameters
    ----------
    sense : Sense
        The signals.
    phase_currents : array, shape (phases,)
        Receives the phase currents (A). The record points into it, so it has to outlive the record.

    Returns
    -------
    array of SENSE, shape (1,)
        The record.
    """
    phase_currents[:] = sense.phase_currents
    values = sense._replace(phase_currents=())._asdict()
    values["phase_currents"] = phase_currents.ctypes.data
    return _record(SENSE, {**values, "phase_count": phase_currents.size})


def command_record() -> NDArray[Any]:
    """Make a record for a controller to fill in.

    Returns
    -------
    array of COMMAND, shape (1,)
        A record whose numbers are all NaN, so that one left out is distinguished from one given.
    """
    return _record(COMMAND, dict.fromkeys(COMMAND.names or (), np.nan))


def nameplate_record(nameplate: Nameplate) -> NDArray[Any]:
    """Write a nameplate as a record.

    Parameters
    ----------
    nameplate : Nameplate
        The drive's nominal data.

    Returns
    -------
    array of NAMEPLATE, shape (1,)
        The record.
    """
    return _record(NAMEPLATE, nameplate._asdict())


def _record(layout: np.dtype[Any], values: dict[str, Any]) -> NDArray[Any]:
    sized = {**values, "struct_size": layout.itemsize}
    return np.array([tuple(sized[name] for name in layout.names or ())], dtype=layout)
