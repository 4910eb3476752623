"""The names of a controller's inputs, outputs and parameters, and finding them among the variables of an FMU."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NamedTuple, get_type_hints

from drivegate.candidates.contract import ContractName
from drivegate_cases.documents.wording import nearest, one_line
from drivegate_models.contract.current.signals import Nameplate, Sense
from drivegate_models.contract.duty.signals import DutyNameplate, DutySense

DUTY_RATIOS: Final = "duty_ratios"
"""The output, an array or three of them, by which an FMU answers with duty ratios."""
LEGS: Final = 3
"""Values of a variable that has one for each leg."""
REAL: Final = {2: "Real", 3: "Float64"}
"""Type of a real number, by version of FMI."""
_INTEGERS: Final = {2: ("Integer",), 3: ("Int32", "Int64")}


@dataclass(frozen=True, kw_only=True)
class Ports:
    """The variables of a controller of one contract."""

    contract: ContractName
    """The contract."""
    fields: tuple[str, ...]
    """Fields of its Sense, in order."""
    inputs: tuple[str, ...]
    more_inputs: tuple[str, ...]
    """Inputs of one value each that a controller must have, and that it may have."""
    input_arrays: tuple[str, ...]
    """Inputs that it may have, of one value for each phase: an array, or one input for each."""
    outputs: tuple[str, ...] = ()
    more_outputs: tuple[str, ...] = ()
    """Outputs that are one value each, likewise."""
    arrays: tuple[str, ...] = ()
    more_arrays: tuple[str, ...] = ()
    """Outputs of one value for each leg, likewise."""
    parameters: Mapping[str, str]
    """Field of the nameplate that each parameter receives."""
    whole: tuple[str, ...]
    """Those of the fields that are whole numbers."""


def _arrays(sense: type) -> tuple[str, ...]:
    """Return the fields of a Sense that have several values."""
    return tuple(name for name, kind in get_type_hints(sense).items() if kind not in (float, int))


def _port_parameters(fields: tuple[str, ...], renamed: str) -> dict[str, str]:
    """Name each parameter like its field; one has a longer name, for an input has the short one."""
    return {f"nominal_{field}" if field == renamed else field: field for field in fields}


CURRENT: Final = Ports(
    contract="current",
    fields=Sense._fields,
    inputs=("speed_reference", "speed", "current_magnitude_sum", "half_supply_voltage"),
    more_inputs=("time",),
    input_arrays=_arrays(Sense),
    outputs=("current_reference", "advance_angle"),
    more_outputs=("input_power",),
    parameters=_port_parameters(Nameplate._fields, "half_supply_voltage"),
    whole=("phases", "pole_pairs", "kind"),
)
"""Those of a controller that answers with a current reference and an advance angle."""

DUTY: Final = Ports(
    contract="duty",
    fields=DutySense._fields,
    inputs=("reference",),
    more_inputs=tuple(name for name in DutySense._fields if name not in ("reference", *_arrays(DutySense))),
    input_arrays=_arrays(DutySense),
    # The estimates of angle and speed have the names of inputs.
    more_outputs=("next_period", "torque", "input_power", "fault"),
    arrays=(DUTY_RATIOS,),
    more_arrays=("legs",),
    parameters=_port_parameters(DutyNameplate._fields, "supply_voltage"),
    whole=("kind", "reference_kind", "pole_pairs", "updates", "update_delay", "control_every"),
)
"""Those of a controller that answers with duty ratios."""

PORTS: Final = {ports.contract: ports for ports in (CURRENT, DUTY)}
"""Those of each contract."""


class Variable(NamedTuple):
    """A variable of an FMU, as its description has it."""

    name: str
    """Its name."""
    value_reference: int
    """Its value reference."""
    causality: str
    """``input``, ``output``, ``parameter``, ``local``, ..."""
    kind: str
    """Its type, in the words of its version of FMI."""
    shape: tuple[int, ...] = ()
    """Sizes of an array; empty for a single value."""


class Parameter(NamedTuple):
    """A parameter that takes a number of the nameplate."""

    field: str
    """Name of the number."""
    value_reference: int
    """Value reference of the parameter."""
    kind: str
    """Its type."""


@dataclass(frozen=True)
class Connections:
    """Which variables of an FMU carry what."""

    contract: ContractName
    """Contract that it answers by."""
    signals: tuple[str, ...]
    """Fields of one value that it takes from the Sense."""
    arrays: tuple[tuple[str, int], ...]
    """Fields of several values that it takes, each with its number of values."""
    input_references: tuple[int, ...]
    """Value references of these fields, one for an array."""
    outputs: tuple[tuple[str, int], ...]
    """Fields of the command that it gives, each with its number of values."""
    output_references: tuple[int, ...]
    """Value references of these, one for an array."""
    parameters: tuple[Parameter, ...]
    """What it reads of the nameplate."""


class Mismatch(Exception):
    """The variables of an FMU are not those of a controller."""

    def __init__(self, ports: Ports, problems: Sequence[str]) -> None:
        super().__init__(", ".join(problems))
        self.ports = ports


def connections_of(variables: Iterable[Variable], version: int) -> Connections:
    """Connect the variables of an FMU, by the contract that its outputs are of."""
    by_name = {variable.name: variable for variable in variables}
    ports = DUTY if any(_is_part_of(DUTY_RATIOS, variable) for variable in by_name.values()) else CURRENT
    problems: list[str] = []
    for names, causality in ((ports.inputs, "input"), (ports.outputs, "output")):
        for name in names:
            problems += _problems_of(name, causality, by_name, version)
    signals = ports.inputs + _given(ports.more_inputs, "input", by_name, version, problems)
    scalars = ports.outputs + _given(ports.more_outputs, "output", by_name, version, problems)
    arrays = [
        (name, _array(name, "output", by_name, version, problems))
        for name in (*ports.arrays, *ports.more_arrays)
    ]
    problems += [
        f"'{name}' has {_values(array)} values, but must have 3, one for each leg"
        for name, array in arrays
        if (array or name in ports.arrays) and _values(array) != LEGS
    ]
    sensed = [(name, _array(name, "input", by_name, version, problems)) for name in ports.input_arrays]
    problems += _unknown_inputs(ports, by_name, [element for _, array in sensed for element in array])
    parameters = _parameters(ports, by_name, version, problems)
    if problems:
        raise Mismatch(ports, problems)
    taken = tuple(name for name in ports.fields if name in signals)
    given = [(name, array) for name, array in arrays if array]
    given += [(name, (by_name[name],)) for name in scalars]
    return Connections(
        ports.contract,
        taken,
        tuple((name, _values(array)) for name, array in sensed if array),
        tuple(by_name[name].value_reference for name in taken)
        + tuple(element.value_reference for _, array in sensed for element in array),
        tuple((name, _values(carriers)) for name, carriers in given),
        tuple(carrier.value_reference for _, carriers in given for carrier in carriers),
        parameters,
    )


def _is_part_of(name: str, variable: Variable) -> bool:
    return variable.causality == "output" and variable.name.partition("[")[0] == name


def _values(carriers: Iterable[Variable]) -> int:
    """Count the values that variables carry."""
    return sum(carrier.shape[0] if carrier.shape else 1 for carrier in carriers)


def _given(
    names: Iterable[str],
    causality: str,
    by_name: Mapping[str, Variable],
    version: int,
    problems: list[str],
) -> tuple[str, ...]:
    """Find those of some variables that there are."""
    found = tuple(name for name in names if name in by_name and by_name[name].causality == causality)
    for name in found:
        problems += _type_problems(by_name[name], version)
    return found


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


def _array(
    name: str, causality: str, by_name: Mapping[str, Variable], version: int, problems: list[str]
) -> tuple[Variable, ...]:
    """Find what carries several values: one array, or its elements one by one."""
    array = by_name.get(name)
    if array is not None and array.causality == causality:
        if len(array.shape) != 1 or array.kind != REAL[version]:
            problems.append(
                f"'{name}' must be an array of {REAL[version]} with one dimension, or {causality}s "
                f"'{name}[1]' and so on"
            )
        return (array,)
    pattern = re.compile(rf"{name}\[([1-9][0-9]*)\]")
    elements = {
        int(match[1]): variable
        for own, variable in by_name.items()
        if variable.causality == causality and (match := pattern.fullmatch(own))
    }
    problems += [
        f"there is no {causality} '{name}[{index}]'"
        for index in range(1, min(max(elements, default=0), 64))
        if index not in elements
    ]
    for variable in elements.values():
        problems += _type_problems(variable, version)
    return tuple(elements[index] for index in sorted(elements))


def _unknown_inputs(ports: Ports, by_name: Mapping[str, Variable], elements: Iterable[Variable]) -> list[str]:
    own = (*ports.inputs, *ports.more_inputs)
    known = {*own, *(element.name for element in elements)}
    return [
        f"nothing is known of the input '{one_line(name)}' (the nearest known one is "
        f"'{nearest(name, [*own, *ports.input_arrays])}')"
        for name, variable in by_name.items()
        if variable.causality == "input" and name not in known
    ]


def _parameters(
    ports: Ports, by_name: Mapping[str, Variable], version: int, problems: list[str]
) -> tuple[Parameter, ...]:
    found = []
    for name, field in ports.parameters.items():
        variable = by_name.get(name)
        if variable is None or variable.causality != "parameter":
            continue
        problems += _type_problems(variable, version, _INTEGERS[version] if field in ports.whole else ())
        found.append(Parameter(field, variable.value_reference, variable.kind))
    return tuple(found)
