"""The records of a contract by their common names, for what works with any of them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate_models.contract.current.records import COMMAND, SENSE, command_record, fresh_sense_record
from drivegate_models.contract.current.signals import Sense
from drivegate_models.contract.duty.records import (
    DUTY_COMMAND,
    DUTY_SENSE,
    duty_command_record,
    duty_sense_record,
)
from drivegate_models.contract.duty.signals import DutySense


@dataclass(frozen=True)
class Layout:
    """What passes between controller and drive in one step of a contract.

    A sense has the fields `struct_size`, `time`, `speed` and `phase_currents`, which is an address. The first field of
    a command is its `struct_size`; all others are numbers of 64 bits that the controller writes.
    """

    name: str
    sense: np.dtype[Any]
    command: np.dtype[Any]
    signals: type[Sense] | type[DutySense]
    """What a controller in Python senses."""
    fresh_sense: Callable[[NDArray[np.float64]], NDArray[Any]]
    """Make what the harness fills, shape (1,), with the address of phase currents, shape (m,) (A), which must outlive
    it."""
    fresh_command: Callable[[], NDArray[Any]]
    """Make the command that a controller finds before it answers, shape (1,)."""

    @property
    def outputs(self) -> tuple[str, ...]:
        """Fields that a controller writes."""
        return (self.command.names or ())[1:]

    def sensed(self, record: Any, currents: NDArray[np.float64]) -> Any:
        """Return a record of a sense as a controller in Python sees it.

        `currents`, shape (m,): the phase currents (A), as the record's address is not followed.
        """
        values = (currents if name == "phase_currents" else record[name] for name in self.signals._fields)
        return self.signals._make(tuple(value.tolist()) if value.ndim else value.item() for value in values)


CURRENT: Final = Layout("current", SENSE, COMMAND, Sense, fresh_sense_record, command_record)
"""Records of controllers that answer with a current reference and an advance angle."""
DUTY: Final = Layout("duty", DUTY_SENSE, DUTY_COMMAND, DutySense, duty_sense_record, duty_command_record)
"""Records of controllers that answer with duty ratios."""
LAYOUTS: Final[Mapping[np.dtype[Any], Layout]] = {layout.sense: layout for layout in (CURRENT, DUTY)}
