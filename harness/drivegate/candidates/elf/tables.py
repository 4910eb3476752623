"""The tables of a manifest on one target: programs that write, answer and read while it runs."""

from __future__ import annotations

from typing import Final

import numpy as np
from elftools.common.exceptions import DWARFError, ELFError
from numpy.typing import NDArray

from drivegate.candidates.candidate import Stub, Target
from drivegate.candidates.contract import ContractName
from drivegate.candidates.elf.evaluation import program_of, run_program
from drivegate.candidates.elf.exchange import REQUIRED_OUTPUTS, Program, Programs, Records
from drivegate.candidates.elf.expression import DEEPEST, Place, Step, parsed, parsed_place
from drivegate.candidates.elf.image import linked_name
from drivegate.candidates.elf.inlining import inlined_into
from drivegate.candidates.elf.processor import CortexM
from drivegate.candidates.elf.stubs import Answer
from drivegate.candidates.elf.variables import Variables, variables_of
from drivegate_cases.documents.wording import short_line
from drivegate_models.errors import InputError

# What a damaged or foreign debug information makes its reader raise.
_UNREADABLE: Final = (
    DWARFError,
    ELFError,
    ValueError,
    LookupError,
    TypeError,
    AttributeError,
    NotImplementedError,
    RecursionError,
)
_Fills = list[tuple[Place, tuple[Step, ...]]]


class Tables:
    """The programs of a manifest's tables, which must live as long as the step.

    `writes` and `reads`: the programs that the step runs, shape (n,).
    """

    def __init__(
        self, processor: CortexM, target: Target, records: Records, contract: ContractName, name: str
    ):
        self._processor = processor
        self._name = name
        self._written, self._once, self._read = Program(), Program(), Program()
        try:
            self._fill(target, records)
        except InputError as error:
            raise InputError(f"{name}: {error}") from error
        except _UNREADABLE as error:
            raise InputError(
                f"{name}: the debug information of the image cannot be read: "
                f"{short_line(str(error)) or type(error).__name__}; compile and link it with -g again"
            ) from error
        unread = [output for output in REQUIRED_OUTPUTS[contract] if output not in dict(target.read)]
        if unread:
            raise InputError(
                f"{name}: the table [read] has no {', '.join(unread)}; add what the step answers with"
            )
        self.writes, self.reads = program_of(self._written.rows), program_of(self._read.rows)
        self._once_made = program_of(self._once.rows)

    def write_at_start(self, *, is_strict: bool) -> None:
        """Write both tables; at first, pointers that the start-up code sets lead nowhere.

        Raises InputError if one still does and `is_strict`.
        """
        self._run("once", self._once, self._once_made, is_strict=is_strict)
        self._run("write", self._written, self.writes, is_strict=is_strict)

    def wild_pointer(self, row: int, *, in_write: bool) -> str:
        """Say which place of the step's programs leads through a pointer to no memory."""
        program, table = (self._written, "write") if in_write else (self._read, "read")
        return _wild(program.place_of_row(row), table)

    def _fill(self, target: Target, records: Records) -> None:
        variables = variables_of(self._processor.image.file)
        peripherals = {key: parsed_place(value) for key, value in target.peripherals}
        programs = Programs(variables, peripherals, records, self._processor.memory)
        for table, program in ((target.write, self._written), (target.once, self._once)):
            for key, value in table:
                programs.write(program, parsed_place(key), parsed(value))
        for key, value in target.read:
            programs.read(self._read, key, parsed(value))
        self._refuse_inlined(target, variables)
        for stub in target.stub:
            fills = [(parsed_place(key), parsed(value)) for key, value in stub.fills]

            def made(answer: Answer, stub: Stub = stub, fills: _Fills = fills) -> Program:
                program = Program()
                takes = programs.stub(program, answer, stub.function, parsed(stub.returns), fills)
                answer.run(program_of(program.rows), takes=takes)
                return program

            self._processor.answer(self._processor.image.functions[stub.function], made)

    def _refuse_inlined(self, target: Target, variables: Variables) -> None:
        """Refuse a function that is also inlined, unless into functions that are answered themselves."""
        image, answered = self._processor.image, {stub.function for stub in target.stub}
        for function in answered & variables.functions.keys():
            for place in inlined_into(variables.functions[function]):
                linked = linked_name(image, place)
                if linked in image.functions and linked not in answered:
                    raise InputError(
                        f"'{short_line(function)}' in [stub] is inlined into {short_line(place)}, which no stub "
                        "reaches; mark it __attribute__((noinline))"
                    )

    def _run(self, table: str, program: Program, made: NDArray[np.float64], *, is_strict: bool) -> None:
        stack = np.zeros(DEEPEST, np.int64)
        areas = self._processor.table.ctypes.data
        row = run_program(made.ctypes.data, stack, stack.ctypes.data, areas, is_strict)
        if row:
            raise InputError(f"{self._name} {_wild(program.place_of_row(row), table)}")


def _wild(place: str, table: str) -> str:
    return (
        f"leaves a pointer that points to no memory of the target, where [{table}] names '{place}'; 'start' lacks the "
        "function that sets it, or 'ram' what it points to"
    )
