"""Finding a controller's inputs, outputs and parameters among the variables of an FMU, by their names."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple

from drivegate_cases.documents.wording import nearest, one_line
from drivegate_models.contract.outer_loop.signals import Nameplate, Sense

REQUIRED_INPUTS: Final = ("speed_reference", "speed", "current_magnitude_sum", "half_supply_voltage")
TIME: Final = "time"
PHASE_CURRENTS: Final = "phase_currents"
REQUIRED_OUTPUTS: Final = ("current_reference", "advance_angle")
INPUT_POWER: Final = "input_power"

_RENAMED: Final = {"half_supply_voltage": "nominal_half_supply_voltage"}
PARAMETERS: Final = {_RENAMED.get(field, field): field for field in Nameplate._fields}
"""The nameplate's field that each parameter receives. One name is longer, for an input has the short one."""

REAL: Final = {2: "Real", 3: "Float64"}
"""Type of a real number, by version of FMI."""
_INTEGERS: Final = {2: ("Integer",), 3: ("Int32", "Int64")}
_WHOLE: Final = ("phases", "pole_pairs", "kind")
_ELEMENT: Final = re.compile(rf"{PHASE_CURRENTS}\[([1-9][0-9]*)\]")


class Variable(NamedTuple):
    """A variable of an FMU, as its description has it.

    Attributes
    ----------
    name : str
        Its name.
    value_reference : int
        Its value reference.
    causality : str
        ``input``, ``output``, ``parameter``, ``local``, ...
    kind : str
        Its type, in the words of its version of FMI.
    shape : tuple of int
        Sizes of an array; empty for a single value.
    """

    name: str
    value_reference: int
    causality: str
    kind: str
    shape: tuple[int, ...] = ()


class Parameter(NamedTuple):
    """A parameter that takes a number of the nameplate.

    Attributes
    ----------
    field : str
        Name of the number.
    value_reference : int
        Value reference of the parameter.
    kind : str
        Its type.
    """

    field: str
    value_reference: int
    kind: str


@dataclass(frozen=True)
class Connections:
    """Which variables of an FMU carry what.

    Attributes
    ----------
    signals : tuple of str
        Fields of the Sense that it takes, phase currents apart.
    input_references : tuple of int
        Their value references, then those of the phase currents.
    phase_currents : int
        Number of phase currents that it takes; 0 for none.
    output_references : tuple of int
        Value references of current reference, advance angle and, where there is one, input power.
    parameters : tuple of Parameter
        What it reads of the nameplate.
    """

    signals: tuple[str, ...]
    input_references: tuple[int, ...]
    phase_currents: int
    output_references: tuple[int, ...]
    parameters: tuple[Parameter, ...]


class Mismatch(Exception):
    """The variables of an FMU are not those of a controller."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__(", ".join(problems))


def connections_of(variables: Iterable[Variable], version: int) -> Connections:
    """Connect the variables of an FMU."""
    by_name = {variable.name: variable for variable in variables}
    problems: list[str] = []
    required = [
        *((name, "input") for name in REQUIRED_INPUTS),
        *((name, "output") for name in REQUIRED_OUTPUTS),
    ]
    for name, causality in required:
        problems += _problems_of(name, causality, by_name, version)
    optional = [(name, causality) for name, causality in ((TIME, "input"), (INPUT_POWER, "output"))]
    for name, causality in optional:
        if name in by_name and by_name[name].causality == causality:
            problems += _type_problems(by_name[name], version)
    currents = _phase_currents(by_name, version, problems)
    problems += _unknown_inputs(by_name, currents)
    parameters = _parameters(by_name, version, problems)
    if problems:
        raise Mismatch(problems)
    with_time = TIME in by_name and by_name[TIME].causality == "input"
    signals = ((TIME,) if with_time else ()) + REQUIRED_INPUTS
    with_power = INPUT_POWER in by_name and by_name[INPUT_POWER].causality == "output"
    outputs = REQUIRED_OUTPUTS + ((INPUT_POWER,) if with_power else ())
    return Connections(
        tuple(name for name in Sense._fields if name in signals),
        tuple(by_name[name].value_reference for name in Sense._fields if name in signals)
        + tuple(current.value_reference for current in currents),
        sum(current.shape[0] if current.shape else 1 for current in currents),
        tuple(by_name[name].value_reference for name in outputs),
        parameters,
    )


def _problems_of(name: str, causality: str, by_name: Mapping[str, Variable], version: int) -> list[str]:
    variable = by_name.get(name)
    if variable is None:
        others = [other.name for other in by_name.values() if other.causality == causality]
        closest = nearest(name, others)
        advice = f" (the nearest {causality} is '{one_line(closest)}')" if closest else ""
        return [f"there is no {causality} '{name}'{advice}"]
    if variable.causality != causality:
        return [f"'{name}' is of the causality {one_line(variable.causality)}, but must be an {causality}"]
    return _type_problems(variable, version)


def _type_problems(variable: Variable, version: int, kinds: tuple[str, ...] = ()) -> list[str]:
    allowed = (REAL[version], *kinds)
    name = one_line(variable.name)
    if variable.kind not in allowed:
        return [f"'{name}' is of the type {one_line(variable.kind)}, but must be {' or '.join(allowed)}"]
    if variable.shape:
        return [f"'{name}' is an array, but must be a single value"]
    return []


def _phase_currents(
    by_name: Mapping[str, Variable], version: int, problems: list[str]
) -> tuple[Variable, ...]:
    """Find the phase currents: one array, or its elements one by one."""
    array = by_name.get(PHASE_CURRENTS)
    if array is not None and array.causality == "input":
        if len(array.shape) != 1 or array.kind != REAL[version]:
            problems.append(
                f"'{PHASE_CURRENTS}' must be an array of {REAL[version]} with one dimension, or inputs "
                f"'{PHASE_CURRENTS}[1]' and so on"
            )
        return (array,)
    elements = {
        int(match[1]): variable
        for name, variable in by_name.items()
        if variable.causality == "input" and (match := _ELEMENT.fullmatch(name))
    }
    problems += [
        f"there is no input '{PHASE_CURRENTS}[{index}]'"
        for index in range(1, min(max(elements, default=0), 64))
        if index not in elements
    ]
    for variable in elements.values():
        problems += _type_problems(variable, version)
    return tuple(elements[index] for index in sorted(elements))


def _unknown_inputs(by_name: Mapping[str, Variable], currents: tuple[Variable, ...]) -> list[str]:
    known = {*REQUIRED_INPUTS, TIME, *(current.name for current in currents)}
    return [
        f"nothing is known of the input '{one_line(name)}' (the nearest known one is "
        f"'{nearest(name, [*REQUIRED_INPUTS, TIME, PHASE_CURRENTS])}')"
        for name, variable in by_name.items()
        if variable.causality == "input" and name not in known
    ]


def _parameters(by_name: Mapping[str, Variable], version: int, problems: list[str]) -> tuple[Parameter, ...]:
    found = []
    for name, field in PARAMETERS.items():
        variable = by_name.get(name)
        if variable is None or variable.causality != "parameter":
            continue
        problems += _type_problems(variable, version, _INTEGERS[version] if field in _WHOLE else ())
        found.append(Parameter(field, variable.value_reference, variable.kind))
    return tuple(found)
