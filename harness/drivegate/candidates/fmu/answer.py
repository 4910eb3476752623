"""From the values of an FMU's outputs to the command that they are, for each contract."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final, TypeAlias

from drivegate.candidates.fmu.variables import Connections
from drivegate_models.contract.current.signals import Command
from drivegate_models.contract.duty.signals import DutyCommand

Answer: TypeAlias = Callable[[tuple[float, ...]], Any]
"""From the outputs' values, in the order of the connections, to a Command or a DutyCommand."""


def answer_of(connections: Connections) -> Answer:
    """Make what turns the outputs of an FMU into commands."""
    return _ANSWERS[connections.contract](connections)


def _of_angles(_connections: Connections) -> Answer:
    # The fields of the command are the outputs, in their order.
    return lambda values: Command(*values)


def _of_duty_ratios(connections: Connections) -> Answer:
    places: dict[str, slice] = {}
    start = 0
    for name, count in connections.outputs:
        places[name] = slice(start, start + count)
        start += count
    arrays = {name: place for name, place in places.items() if name in ("duty_ratios", "legs")}
    scalars = {name: place.start for name, place in places.items() if name not in arrays}

    def answer(values: tuple[float, ...]) -> DutyCommand:
        fields: dict[str, Any] = {name: values[place] for name, place in scalars.items()}
        fields |= {name: values[place] for name, place in arrays.items()}
        if "legs" in fields:
            fields["legs"] = tuple(map(_whole, fields["legs"]))
        if "fault" in fields:
            fields["fault"] = _whole(fields["fault"])
        return DutyCommand(**fields)

    return answer


_ANSWERS: Final = {"current": _of_angles, "duty": _of_duty_ratios}


def _whole(value: float) -> float | int:
    """Make a whole number of a real one; what is none is left for the contract to refuse."""
    return int(value) if value.is_integer() else value
