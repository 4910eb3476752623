"""The candidate contract as binary records: the declarations of `drivegate.h` as numpy dtypes.

The records contain only 64-bit numbers and one pointer, so that no compiler pads them. The first field of each
record is its own size in bytes. Later minor versions append fields and do not change others.
"""

import struct
from typing import Any, Final, get_type_hints

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.current.signals import Command, Nameplate, Sense

ABI_MAJOR: Final = 1
"""Version of the layout; a controller built for another version is refused."""

ABI_MINOR: Final = 1
"""Number of the extension within a major version; any number is accepted."""

ABI_VERSION: Final = 1000 * ABI_MAJOR + ABI_MINOR
"""Both versions in one number, as returned by a controller's `drivegate_abi_version`."""

STATE_ALIGNMENT: Final = 16
"""Alignment of a native controller's state (bytes)."""

STOP: Final = -1
"""Value of `struct_size` by which a controller's bridge requests the end of the run."""

_STRUCT_CODES = {"i": "q", "u": "Q", "f": "d"}
_TYPES = {float: np.float64, int: np.int64}


def record_of(signals: type) -> np.dtype[Any]:
    """Return the record of a named tuple of signals.

    `signals`: each field is a float, an int or a tuple of three floats. Result: the record's size, then the fields in
    their order. `phase_currents` is an address; other tuples are in place.
    """
    layouts: list[Any] = [("struct_size", np.int64)]
    for name, kind in get_type_hints(signals).items():
        if name == "phase_currents":
            layouts.append((name, np.uintp))
        else:
            layouts.append((name, _TYPES[kind]) if kind in _TYPES else (name, np.float64, 3))
    return np.dtype(layouts, align=True)


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

COMMAND: Final = record_of(Command)
NAMEPLATE: Final = record_of(Nameplate)


def packing(record: np.dtype[Any]) -> struct.Struct:
    """Return the layout of a record for the standard library's `struct`, which is faster than numpy for one record.

    `record`: `SENSE`, `COMMAND` or `NAMEPLATE`. Result: packs and unpacks all numbers of the record in their order; a
    field of several numbers has as many.
    """
    fields = (record[name] for name in record.names or ())
    return struct.Struct(
        "=" + "".join(_STRUCT_CODES[field.base.kind] * (field.itemsize // 8) for field in fields)
    )


def sense_record(sense: Sense, phase_currents: NDArray[np.float64]) -> NDArray[Any]:
    """Return a Sense as a record.

    `phase_currents`, shape (phases,): receives the phase currents (A). The record points to it, so it must outlive the
    record. Result, shape (1,): with its own size and the number of phases.
    """
    phase_currents[:] = sense.phase_currents
    values = sense._replace(phase_currents=())._asdict()
    values["phase_currents"] = phase_currents.ctypes.data
    return _record(SENSE, {**values, "phase_count": phase_currents.size})


def fresh_sense_record(phase_currents: NDArray[np.float64]) -> NDArray[Any]:
    """Return a Sense of zeros as a record that points to phase currents, shape (phases,) (A)."""
    values = {"phase_count": phase_currents.size, "phase_currents": phase_currents.ctypes.data}
    return _record(SENSE, {**dict.fromkeys(SENSE.names or (), 0), **values})


def command_record() -> NDArray[Any]:
    """Return a record for a controller to fill.

    Result, shape (1,): all numbers are NaN to detect missing ones.
    """
    return _record(COMMAND, dict.fromkeys(COMMAND.names or (), np.nan))


def nameplate_record(nameplate: Nameplate) -> NDArray[Any]:
    """Return a nameplate as a record.

    Result, shape (1,): with its own size in the first field.
    """
    return _record(NAMEPLATE, nameplate._asdict())


def _record(layout: np.dtype[Any], values: dict[str, Any]) -> NDArray[Any]:
    sized = {**values, "struct_size": layout.itemsize}
    return np.array([tuple(sized[name] for name in layout.names or ())], dtype=layout)
