"""The C function that steps a controller on a target.

The emulator calls nothing of Python while it runs. The compiled function copies the records of a step into the
memory of the target, sets the registers as a call does, and lets the emulator run to the return address.
"""

from __future__ import annotations

from functools import cache
from typing import Any, Final

import numba
import numpy as np
from numba import types
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from drivegate.candidates.elf.emulator import arm_const, read_register, start, write_register
from drivegate.candidates.elf.evaluation import run_program
from drivegate.candidates.elf.expression import DEEPEST
from drivegate.candidates.elf.instruction_count import CYCLE, LONGEST_INSTRUCTION, SET_BY_CALLER
from drivegate.candidates.elf.traps import MASK
from drivegate_models.compilation.calling import copy_bytes
from drivegate_models.compilation.kernels import KEEPS_CACHE, unallocating

# Words of the state that the C function gets.
ENGINE, BEGIN, UNTIL, SELF, ERROR, STOP_WORD, SCRATCH = range(7)
HOST_SENSE, SENSE_BYTES, CURRENTS_OFFSET, HOST_CURRENTS, GUEST_CURRENTS, CURRENTS_BYTES = range(7, 13)
HOST_COMMAND, COMMAND_BYTES, COUNTER, TRAPPED, WRITES, READS, AREAS, ROW, PAUSED_AT, ARGUMENTS = range(13, 23)
MOST_INSTRUCTIONS: Final = ARGUMENTS + 5
MOST_CYCLES: Final = MOST_INSTRUCTIONS + 1
_COUNTED: Final = MOST_CYCLES + 1
STACK: Final = _COUNTED + SET_BY_CALLER
WORDS: Final = STACK + DEEPEST
CALL_REGISTERS: Final = (
    arm_const.UC_ARM_REG_R0,
    arm_const.UC_ARM_REG_R1,
    arm_const.UC_ARM_REG_R2,
    arm_const.UC_ARM_REG_SP,
    arm_const.UC_ARM_REG_LR,
)
TRAP, WILD_WRITE, WILD_READ, RETURNED = -1, -2, -3, -4
"""What ended a step, next to the errors of the emulator: what ``traps`` lists, a value of a manifest that leads through
a pointer to no memory, and a function that returns although it is to pause."""
MOST_INSTRUCTIONS_OF_STEP: Final = 10_000_000
"""Instructions after which a step is taken for endless; on a processor they are longer than any control period."""


@unallocating
def _emulate(words: NDArray[np.int64], counter: int) -> None:
    """Run the emulator until the step comes to its end, and note what ended it; `counter`: the register."""
    scratch = words[SELF] + 8 * SCRATCH
    begin = words[BEGIN]
    is_pausing, has_paused, has_trapped = words[PAUSED_AT] != 0, False, False
    while True:
        words[ERROR] = start(words[ENGINE], begin, words[UNTIL], 0, 0)
        copy_bytes(words[TRAPPED] + 8 * MASK, scratch, 8)
        has_trapped = words[SCRATCH] != 0
        copy_bytes(words[TRAPPED], scratch, 8)
        has_trapped = has_trapped or words[SCRATCH] != 0
        if is_pausing:
            copy_bytes(words[PAUSED_AT], scratch, 8)
            has_paused = words[SCRATCH] != 0
        words[SCRATCH] = 0
        read_register(words[ENGINE], counter, scratch)
        begin = words[SCRATCH] | 1
        # The emulator also ends where an instruction waits under a condition; it goes on there.
        if words[ERROR] != 0 or has_trapped or has_paused or begin == words[UNTIL] | 1:
            break
    if has_trapped:
        words[ERROR] = TRAP
    elif words[ERROR] == 0 and is_pausing and not has_paused:
        words[ERROR] = RETURNED


@cache
def step_function() -> Any:
    """Compile the C function that steps a controller on a target; one serves all."""
    # Compiled code is found again by the values of its closure, so numbers of the emulator's version belong there.
    r0, r1, r2, sp, lr = CALL_REGISTERS
    pc = arm_const.UC_ARM_REG_PC

    def step_on_target(state: Any, sense: int, command: int) -> None:
        words = carray(state, WORDS)
        own = words[SELF]
        copy_bytes(sense, words[HOST_SENSE], words[SENSE_BYTES])
        # The Sense points to the currents in this machine. Copy what is there too, and point the copy of the Sense to
        # the copy of the currents, at its address in the target.
        copy_bytes(sense + words[CURRENTS_OFFSET], own + 8 * SCRATCH, 8)
        copy_bytes(words[SCRATCH], words[HOST_CURRENTS], words[CURRENTS_BYTES])
        copy_bytes(own + 8 * GUEST_CURRENTS, words[HOST_SENSE] + words[CURRENTS_OFFSET], 8)
        copy_bytes(command, words[HOST_COMMAND], words[COMMAND_BYTES])
        stack, scratch = words[STACK:], own + 8 * SCRATCH
        if words[WRITES] != 0:
            words[ROW] = run_program(words[WRITES], stack, own + 8 * STACK, words[AREAS], True)
            if words[ROW] != 0:
                words[ERROR] = WILD_WRITE
                copy_bytes(own + 8 * STOP_WORD, command, 8)
                return
        if words[PAUSED_AT] == 0:
            write_register(words[ENGINE], r0, own + 8 * ARGUMENTS)
            write_register(words[ENGINE], r1, own + 8 * (ARGUMENTS + 1))
            write_register(words[ENGINE], r2, own + 8 * (ARGUMENTS + 2))
            write_register(words[ENGINE], sp, own + 8 * (ARGUMENTS + 3))
            write_register(words[ENGINE], lr, own + 8 * (ARGUMENTS + 4))
        else:
            copy_bytes(words[PAUSED_AT], own + 8 * BEGIN, 8)
            words[SCRATCH] = 0
            copy_bytes(scratch, words[PAUSED_AT], 8)
        words[_COUNTED] = words[_COUNTED + 1] = words[_COUNTED + 2] = 0
        words[_COUNTED + 3] = LONGEST_INSTRUCTION * MOST_INSTRUCTIONS_OF_STEP
        copy_bytes(own + 8 * _COUNTED, words[COUNTER], 8 * SET_BY_CALLER)
        _emulate(words, pc)
        copy_bytes(words[COUNTER], own + 8 * _COUNTED, 8)
        words[MOST_INSTRUCTIONS] = max(words[MOST_INSTRUCTIONS], words[_COUNTED] % CYCLE)
        words[MOST_CYCLES] = max(words[MOST_CYCLES], words[_COUNTED] // CYCLE)
        if words[ERROR] == 0 and words[READS] != 0:
            words[ROW] = run_program(words[READS], stack, own + 8 * STACK, words[AREAS], True)
            if words[ROW] != 0:
                words[ERROR] = WILD_READ
        if words[ERROR] != 0:
            copy_bytes(own + 8 * STOP_WORD, command, 8)
            return
        copy_bytes(words[HOST_COMMAND], command, words[COMMAND_BYTES])

    pointer: Any = types.CPointer
    signature = types.void(pointer(types.int64), types.int64, types.int64)
    return numba.cfunc(signature, cache=KEEPS_CACHE)(step_on_target)
