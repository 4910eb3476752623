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

DUTY: Final = Ports(
    contract="duty",
    fields=DutySense._fields,
    inputs=("reference",),
    more_inputs=tuple(name for name in DutySense._fields if name not in ("reference", *_arrays(DutySense))),
    input_arrays=_arrays(DutySense),
    # The estimates of angle and speed have the names of inputs.
    more_outputs=("next_period", "torque", "input_power", "fault", "brake_duty"),
    arrays=(DUTY_RATIOS,),
    more_arrays=("legs",),
    parameters=_port_parameters(DutyNameplate._fields, "supply_voltage"),
    whole=(
        "kind",
        "reference_kind",
        "pole_pairs",
        "updates",
        "update_delay",
        "control_every",
        "position",
        "is_reversing",
    ),
)

PORTS: Final = {ports.contract: ports for ports in (CURRENT, DUTY)}


class Variable(NamedTuple):
    name: str
    value_reference: int
    causality: str
    """``input``, ``output``, ``parameter``, ``local``, ..."""
    kind: str
    """Its type, in the words of its version of FMI."""
    shape: tuple[int, ...] = ()
    """Sizes of an array; empty for a single value."""


class Parameter(NamedTuple):
    field: str
    """Name of the number."""
    value_reference: int
    kind: str


@dataclass(frozen=True)
class Connections:
    """Which variables of an FMU carry what."""

    contract: ContractName
    signals: tuple[str, ...]
    """Fields of one value that it takes from the Sense."""
    arrays: tuple[tuple[str, int], ...]
    """Fields of several values that it takes, each with its number of values."""
    input_references: tuple[int, ...]
    """Value references of these fields, one for an array."""
    outputs: tuple[tuple[str, int], ...]
    """Fields of the command that it answers with, each with its number of values."""
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
    search = _Search({variable.name: variable for variable in variables}, version)
    by_name = search.by_name
    is_duty = any(
        variable.causality == "output" and name.partition("[")[0] == DUTY_RATIOS
        for name, variable in by_name.items()
    )
    ports = DUTY if is_duty else CURRENT
    for names, causality in ((ports.inputs, "input"), (ports.outputs, "output")):
        for name in names:
            search.require(name, causality)
    signals = ports.inputs + search.given(ports.more_inputs, "input")
    scalars = ports.outputs + search.given(ports.more_outputs, "output")
    arrays = [(name, search.array(name, "output")) for name in (*ports.arrays, *ports.more_arrays)]
    search.problems += [
        f"'{name}' has {_values(array)} values, but must have 3, one for each leg"
        for name, array in arrays
        if (array or name in ports.arrays) and _values(array) != LEGS
    ]
    sensed = [(name, search.array(name, "input")) for name in ports.input_arrays]
    search.refuse_unknown_inputs(ports, [element.name for _, array in sensed for element in array])
    parameters = search.parameters(ports)
    if search.problems:
        raise Mismatch(ports, search.problems)
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


def _values(carriers: Iterable[Variable]) -> int:
    """Count the values that variables carry."""
    return sum(carrier.shape[0] if carrier.shape else 1 for carrier in carriers)


class _Search:
    """Looks for a controller's variables among those of an FMU, and collects all that is wrong with them."""

    def __init__(self, by_name: Mapping[str, Variable], version: int) -> None:
        self.by_name = by_name
        self._version = version
        self.problems: list[str] = []

    def given(self, names: Iterable[str], causality: str) -> tuple[str, ...]:
        """Find those of some variables that there are."""
        found = tuple(
            name for name in names if name in self.by_name and self.by_name[name].causality == causality
        )
        for name in found:
            self._require_type(self.by_name[name])
        return found

    def require(self, name: str, causality: str) -> None:
        variable = self.by_name.get(name)
        if variable is None:
            others = [other.name for other in self.by_name.values() if other.causality == causality]
            closest = nearest(name, others)
            advice = f" (the nearest {causality} is '{one_line(closest)}')" if closest else ""
            self.problems.append(f"there is no {causality} '{name}'{advice}")
        elif variable.causality != causality:
            self.problems.append(
                f"'{name}' is of the causality {one_line(variable.causality)}, but must be an {causality}"
            )
        else:
            self._require_type(variable)

    def _require_type(self, variable: Variable, kinds: tuple[str, ...] = ()) -> None:
        """Require a single real number, or one of further kinds."""
        allowed = (REAL[self._version], *kinds)
        name = one_line(variable.name)
        if variable.kind not in allowed:
            self.problems.append(
                f"'{name}' is of the type {one_line(variable.kind)}, but must be {' or '.join(allowed)}"
            )
        elif variable.shape:
            self.problems.append(f"'{name}' is an array, but must be a single value")

    def array(self, name: str, causality: str) -> tuple[Variable, ...]:
        """Find what carries several values: one array, or its elements one by one."""
        array = self.by_name.get(name)
        if array is not None and array.causality == causality:
            real = REAL[self._version]
            if len(array.shape) != 1 or array.kind != real:
                self.problems.append(
                    f"'{name}' must be an array of {real} with one dimension, or {causality}s '{name}[1]' and so on"
                )
            return (array,)
        pattern = re.compile(rf"{name}\[([1-9][0-9]*)\]")
        elements = {
            int(match[1]): variable
            for own, variable in self.by_name.items()
            if variable.causality == causality and (match := pattern.fullmatch(own))
        }
        # Bounded, since the number in a name may be of any size.
        self.problems += [
            f"there is no {causality} '{name}[{index}]'"
            for index in range(1, min(max(elements, default=0), 64))
            if index not in elements
        ]
        for variable in elements.values():
            self._require_type(variable)
        return tuple(elements[index] for index in sorted(elements))

    def refuse_unknown_inputs(self, ports: Ports, elements: Iterable[str]) -> None:
        own = (*ports.inputs, *ports.more_inputs)
        known = {*own, *elements}
        self.problems += [
            f"nothing is known of the input '{one_line(name)}' (the nearest known one is "
            f"'{nearest(name, [*own, *ports.input_arrays])}')"
            for name, variable in self.by_name.items()
            if variable.causality == "input" and name not in known
        ]

    def parameters(self, ports: Ports) -> tuple[Parameter, ...]:
        found = []
        for name, field in ports.parameters.items():
            variable = self.by_name.get(name)
            if variable is None or variable.causality != "parameter":
                continue
            self._require_type(variable, _INTEGERS[self._version] if field in ports.whole else ())
            found.append(Parameter(field, variable.value_reference, variable.kind))
        return tuple(found)
