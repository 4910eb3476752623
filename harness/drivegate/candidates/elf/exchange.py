"""What a manifest writes into the variables of an image before a step, and reads from them after it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.contract import ContractName
from drivegate.candidates.elf.debug_information import POINTER_SIZE
from drivegate.candidates.elf.evaluation import Row, constant, loaded, operation, range_of, stored
from drivegate.candidates.elf.expression import Place, Step
from drivegate.candidates.elf.image import hexadecimal
from drivegate.candidates.elf.stubs import Answer, Parameter
from drivegate.candidates.elf.variables import FLOAT, SIGNED, Number, Variables
from drivegate_cases.documents.wording import nearest, short_line
from drivegate_models.contract.current.records import NAMEPLATE
from drivegate_models.contract.current.signals import Command
from drivegate_models.contract.duty.records import DUTY_NAMEPLATE
from drivegate_models.contract.duty.signals import DutyCommand
from drivegate_models.contract.layout import CURRENT, DUTY, Layout
from drivegate_models.errors import InputError

REQUIRED_OUTPUTS: Final[Mapping[ContractName, tuple[str, ...]]] = {
    "current": ("current_reference", "advance_angle"),
    "duty": ("duty_ratios[0]", "duty_ratios[1]", "duty_ratios[2]"),
}
"""Fields that each Command has, by contract."""
LAYOUTS: Final = {"current": (CURRENT, NAMEPLATE), "duty": (DUTY, DUTY_NAMEPLATE)}
"""Records of a step, and that of the nameplate, by contract."""
MOST_PHASES: Final = 64
"""Number of phase currents that the memory of a step has space for."""
_ANSWERS: Final[Mapping[ContractName, tuple[type[Command | DutyCommand], tuple[str, ...]]]] = {
    "current": (Command, ()),
    "duty": (DutyCommand, ("duty_ratios", "legs")),
}
"""What a controller in Python answers, with the fields that have a number for each leg."""


@dataclass(frozen=True)
class Records:
    """The records of a step in the memory of this machine."""

    signals: Mapping[str, Number]
    """What expressions of writes may name: fields of the Sense, and of the nameplate as ``nameplate.resistance``."""
    outputs: Mapping[str, Number]
    """What is read: fields of the Command."""


def records_in(mail: int, places: Sequence[int], contract: ContractName) -> Records:
    """Find the fields of the records that are exchanged.

    `mail`: address of the memory that they are in. `places`: where nameplate, Sense, Command and currents begin.
    """
    layout, nameplate = LAYOUTS[contract]
    signals = {f"nameplate.{name}": number for name, number in _fields(mail + places[0], nameplate)}
    signals |= dict(_fields(mail + places[1], layout.sense))
    signals.pop("phase_currents")
    signals |= {
        f"phase_currents[{phase}]": Number(mail + places[3] + 8 * phase, FLOAT, 8)
        for phase in range(MOST_PHASES)
    }
    named = _names_of_outputs(contract, layout)
    fields = dict(_fields(mail + places[2], layout.command))
    return Records(signals, {name: fields[field] for name, field in named.items()})


def _fields(begin: int, record: np.dtype[Any]) -> Iterator[tuple[str, Number]]:
    """List the numbers of a record, those of an array one by one."""
    fields: Any = record.fields
    for name in (record.names or ())[1:]:
        kind, offset = fields[name][:2]
        form = FLOAT if kind.base.kind == "f" else SIGNED
        for index in range(kind.shape[0] if kind.shape else 1):
            text = f"{name}[{index}]" if kind.shape else name
            yield text, Number(begin + offset + 8 * index, form, 8)


def _names_of_outputs(contract: ContractName, layout: Layout) -> dict[str, str]:
    """Name the fields of a Command as a controller in Python does, with those of the record."""
    answer, by_leg = _ANSWERS[contract]
    names = [
        text
        for name in answer._fields
        for text in ([f"{name}[{leg}]" for leg in range(3)] if name in by_leg else [name])
    ]
    return dict(zip(names, layout.outputs, strict=True))


class Program:
    """Rows for `run_program`, each with the place that it is for."""

    def __init__(self) -> None:
        self.rows: list[Row] = []
        self._places: list[str] = []

    def add(self, rows: Sequence[Row], place: str) -> None:
        self.rows += rows
        self._places += [place] * len(rows)

    def place_of_row(self, row: int) -> str:
        """Return the place that a row is for, the number of which is counted from 1 on."""
        return self._places[row - 1]


class Programs:
    def __init__(
        self,
        variables: Variables,
        peripherals: Mapping[str, Place],
        records: Records,
        memory: Callable[[int, int], NDArray[np.uint8]],
    ) -> None:
        self._variables = variables
        self._peripherals = peripherals
        self._records = records
        self._memory = memory

    def write(self, program: Program, place: Place, value: tuple[Step, ...]) -> None:
        """Evaluate what follows from signals, and store it in a variable of the target."""
        self._evaluate(program, value, self._signal)
        program.add(stored(self._target(place)), place.text)

    def read(self, program: Program, output: str, value: tuple[Step, ...]) -> None:
        """Evaluate what follows from variables of the target, and store it in the Command."""
        if output not in self._records.outputs:
            known = self._records.outputs
            raise InputError(f"a Command has no '{short_line(output)}'; it has {', '.join(known)}")
        self._evaluate(program, value, self._target)
        program.add(stored(self._records.outputs[output]), output)

    def stub(
        self,
        program: Program,
        answer: Answer,
        function: str,
        value: tuple[Step, ...],
        fills: Sequence[tuple[Place, tuple[Step, ...]]],
    ) -> bool:
        """Evaluate what follows from signals and parameters, and store it where the function's answer is taken from.

        `fills`: what the function writes, mostly through pointers that it is passed. Return whether it needs what is
        passed.
        """
        evaluated = [step for steps in (value, *(steps for _, steps in fills)) for step in steps]
        named = [place for place, _ in fills] + [step for step in evaluated if isinstance(step, Place)]
        own = [each for each in named if each.address is None and each.text not in self._records.signals]
        parameters = answer.parameters(function, self._variables) if own else {}

        def passed(place: Place) -> Number:
            # A signal of the same name as a parameter is the signal.
            if place.text in self._records.signals or place.root not in parameters:
                return self._signal(place, tuple(parameters))
            return self._parameter(place, parameters[place.root])

        for place, steps in fills:
            is_passed = place.address is None and place.root in parameters
            self._evaluate(program, steps, passed)
            target = self._parameter(place, parameters[place.root]) if is_passed else self._target(place)
            program.add(stored(target), place.text)
        returned = self._variables.returned(function)
        if returned is not None:
            form, size = returned
            where = answer.value(form, size, self._variables.passes_floats_in_registers)
            self._evaluate(program, value, passed)
            program.add(stored(where, range_of(form, size)), function)
        return any(each.root in parameters for each in own)

    def _parameter(self, place: Place, parameter: Parameter) -> Number:
        return self._variables.number_within(parameter.where, parameter.typed, place)

    def _evaluate(self, program: Program, steps: tuple[Step, ...], found: Callable[[Place], Number]) -> None:
        for step in steps:
            if isinstance(step, Place):
                program.add(loaded(found(step)), step.text)
            else:
                program.add([operation(step) if isinstance(step, str) else constant(step)], "")

    def _signal(self, place: Place, further: tuple[str, ...] = ()) -> Number:
        if place.text not in self._records.signals:
            known = [*self._records.signals, *further]
            raise InputError(
                f"there is no signal '{place.text}', the nearest one is '{nearest(place.text, known)}'"
            )
        return self._records.signals[place.text]

    def _target(self, place: Place) -> Number:
        alias = self._peripherals.get(place.root) if place.address is None else None
        whole = place if alias is None else alias._replace(path=(*alias.path, *place.path))
        number = self._variables.number(whole)
        size = POINTER_SIZE if number.offsets else number.size
        try:
            memory = self._memory(number.address, size)
        except KeyError:
            raise InputError(
                f"'{place.text}' is at {hexadecimal(number.address)}, where the target has no memory; add it to 'ram'"
            ) from None
        return number._replace(address=int(memory.ctypes.data))
