"""A Cortex-M processor with its memory, emulated by Unicorn, and a C function that steps a controller on it.

The emulator calls nothing of Python while it runs. The compiled function copies the records of a step into the
memory of the target, sets the registers as a call does, and lets the emulator run to the return address.
"""

from __future__ import annotations

import ctypes
from contextlib import suppress
from functools import cache
from importlib import import_module
from typing import Any, Final

import numba
import numpy as np
from numba import types
from numba.np.numpy_support import carray
from numpy.typing import NDArray

from drivegate.candidates.elf.emulator import arm_const, binding, start, write_register
from drivegate.candidates.elf.exchange import answering_function, run_program
from drivegate.candidates.elf.expression import DEEPEST
from drivegate.candidates.elf.image import Image, hexadecimal, place_of
from drivegate.candidates.elf.instruction_count import CYCLE, counter, counting_function
from drivegate.candidates.elf.traps import (
    CONTROL_REGISTER,
    MASK,
    OPERAND,
    PLACE,
    Trap,
    rules_of,
    trapping_function,
    traps_of,
)
from drivegate_models.compilation.calling import copy_bytes
from drivegate_models.compilation.kernels import KEEPS_CACHE
from drivegate_models.contract.current.records import STOP
from drivegate_models.errors import HarnessFault

unicorn: Any = import_module("unicorn")

PAGE: Final = 4096
STACK_BYTES: Final = 64 * 1024
"""Size of the stack (bytes)."""
_ABOVE: Final = 16
_REGION: Final = 0x1000_0000
"""Records, stack and return address are in a region of this size that the image does not use (bytes)."""
_MAIL, _STACK, _RETURN = 0x0000_0000, 0x0100_0000, 0x0200_0000
_TRANSLATIONS: Final = 32 * 2**20
_TRAP: Final = -1
"""What ended a step, next to the errors of the emulator: a rule of ``traps``."""

# Words of the state that the C function gets.
ENGINE, BEGIN, UNTIL, SELF, ERROR, STOP_WORD, SCRATCH = range(7)
HOST_SENSE, SENSE_BYTES, CURRENTS_OFFSET, HOST_CURRENTS, GUEST_CURRENTS, CURRENTS_BYTES = range(7, 13)
HOST_COMMAND, COMMAND_BYTES, COUNTER, TRAPPED, WRITES, READS, ARGUMENTS = range(13, 20)
MOST_INSTRUCTIONS: Final = ARGUMENTS + 5
MOST_CYCLES: Final = MOST_INSTRUCTIONS + 1
_COUNTED: Final = MOST_CYCLES + 1
STACK: Final = _COUNTED + 2
WORDS: Final = STACK + DEEPEST
_PAINT: Final = 0xA5
"""What the stack is filled with, so that the deepest byte that is written shows."""

_REGISTERS: Final = (
    arm_const.UC_ARM_REG_R0,
    arm_const.UC_ARM_REG_R1,
    arm_const.UC_ARM_REG_R2,
    arm_const.UC_ARM_REG_SP,
    arm_const.UC_ARM_REG_LR,
)
_FLOATING_POINT_ON: Final = 0x40000000
_ACCESSES: Final = {
    unicorn.UC_MEM_READ_UNMAPPED: "reads address {}, where the target has no memory,",
    unicorn.UC_MEM_WRITE_UNMAPPED: "writes to address {}, where the target has no memory,",
    unicorn.UC_MEM_FETCH_UNMAPPED: "jumps to address {}, where the target has no memory,",
    unicorn.UC_MEM_WRITE_PROT: "writes to the read-only address {}",
    unicorn.UC_MEM_READ_PROT: "reads the unreadable address {}",
    unicorn.UC_MEM_FETCH_PROT: "executes the data at address {}",
}
"""What an access that is refused does, by its kind; those are all kinds of the hook."""


class TargetFault(Exception):
    """The code on the target did what its processor or its memory does not allow; its text is a sentence."""


class CortexM:
    def __init__(self, image: Image, ram: tuple[tuple[int, int], ...]) -> None:
        self.image = image
        self._engine = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS)
        self._engine.ctl_set_cpu_model(getattr(arm_const, f"UC_CPU_ARM_{image.core}"))
        self._engine.ctl_set_tcg_buffer_size(_TRANSLATIONS)
        # Start-up code would enable the floating-point unit, but functions are also called without any.
        self._engine.reg_write(arm_const.UC_ARM_REG_FPEXC, _FLOATING_POINT_ON)
        self._pages: dict[int, NDArray[np.uint8]] = {}
        # Copied back at each reset, as start-up code does at power-on, so that no run sees another's variables.
        self._initial: list[tuple[NDArray[np.uint8], bytes]] = []
        for segment in image.segments:
            self._map(segment.address, segment.size, segment.is_writable, segment.is_executable)
            memory = self.memory(segment.address, segment.size)
            self._initial.append((memory, segment.content.ljust(segment.size, b"\0")))
        for address, size in ram:
            self._map(address, size, True, False)
            self._initial.append((self.memory(address, size), bytes(size)))
        taken = list(self._pages)
        self._base = next(
            base
            # Code, SRAM and peripherals of every Cortex-M are below this address.
            for base in range(0x6000_0000, 0xFFFF_FFFF, _REGION)
            if not any(base <= address < base + _REGION for address in taken)
        )
        # Where records are exchanged, once `map_mail` has made the memory.
        self.mail = self._base + _MAIL
        self._map(self._base + _STACK, STACK_BYTES, True, False)
        # The first words of a call are above the stack pointer.
        self._stack = self.memory(self._base + _STACK, STACK_BYTES - _ABOVE)
        self._map(self._base + _RETURN, PAGE, False, True)
        self._refused: tuple[int, int] | None = None
        self._engine.hook_add(unicorn.UC_HOOK_MEM_INVALID, self._note_refused)
        self._counter = counter(image)
        self._add_hook(unicorn.UC_HOOK_BLOCK, counting_function(), self._counter)
        self._is_watched = False
        self._trapped = np.zeros(MASK + 1, np.int64)
        # What compiled functions get must live as long as the emulator.
        self._rules: list[NDArray[np.int64]] = []
        self._watch_divisions()
        self.power_on()

    def map_mail(self, size: int) -> NDArray[np.uint8]:
        """Make the memory that records are exchanged in."""
        self._map(self.mail, size, True, False)
        return self.memory(self.mail, size)

    def power_on(self) -> None:
        """Load the image again, so that all of its variables have their initial values."""
        for memory, content in self._initial:
            memory[:] = np.frombuffer(content, np.uint8)
        self._trapped[:] = 0

    def memory(self, address: int, size: int) -> NDArray[np.uint8]:
        """Return memory of the target, which changes with it."""
        for base, page in self._pages.items():
            if base <= address and address + size <= base + page.size:
                return page[address - base : address - base + size]
        raise KeyError(address)

    def call(self, function: int, *arguments: int) -> int:
        """Call a function, and return its result.

        Raises TargetFault if it does what the processor or the memory does not allow.
        """
        for register, value in zip(_REGISTERS, self.call_registers(*arguments), strict=True):
            self._engine.reg_write(register, value)
        self._refused = None
        try:
            # The lowest bit selects the Thumb instruction set, the only one that these processors have.
            self._engine.emu_start(function | 1, self._base + _RETURN)
        except unicorn.UcError as error:
            raise TargetFault(self.describe(error.errno)) from None
        if self._trapped[PLACE]:
            raise TargetFault(self.describe(_TRAP))
        return int(self._engine.reg_read(arm_const.UC_ARM_REG_R0))

    def call_registers(self, *arguments: int) -> tuple[int, ...]:
        """Return the registers of a call: three arguments, stack pointer and link register."""
        three = (*arguments, 0, 0, 0)[:3]
        return (*three, self._base + _STACK + STACK_BYTES - _ABOVE, (self._base + _RETURN) | 1)

    def describe(self, error: int) -> str:
        if error == _TRAP:
            place = place_of(self.image, int(self._trapped[PLACE]))
            if not self._trapped[MASK]:
                return f"divides by zero {place}"
            size = int(self._trapped[MASK]) + 1
            return (
                f"accesses address {hexadecimal(int(self._trapped[OPERAND]))}, no multiple of {size}, {place}"
            )
        register = arm_const.UC_ARM_REG_PC
        if self._refused is not None and self._refused[0] == unicorn.UC_MEM_FETCH_UNMAPPED:
            # Where it has jumped to says nothing of who jumped.
            register = arm_const.UC_ARM_REG_LR
        place = place_of(self.image, int(self._engine.reg_read(register)) & ~1)
        if self._refused is not None:
            access, address = self._refused
            if self._base + _STACK - STACK_BYTES <= address < self._base + _STACK:
                return f"uses more than {STACK_BYTES // 1024} KiB of stack {place}"
            return f"{_ACCESSES[access].format(hexadecimal(address))} {place}"
        if error == unicorn.UC_ERR_INSN_INVALID:
            return f"executes what is no instruction of this processor {place}"
        return f"raises an exception of the processor {place} ({unicorn.UcError(error)})"

    def words_for_step(self, step: int) -> NDArray[np.int64]:
        """Return the state of the C function, with all that is the same in each step."""
        words = np.zeros(WORDS, np.int64)
        words[ENGINE] = self._engine._uch.value
        words[BEGIN], words[UNTIL] = step | 1, self._base + _RETURN
        words[SELF] = words.ctypes.data
        words[STOP_WORD] = STOP
        words[TRAPPED] = self._trapped.ctypes.data
        words[COUNTER] = self._counter.ctypes.data
        return words

    def answer(self, function: int, words: NDArray[np.int64]) -> None:
        """Answer each call of a function by a value, without running it."""
        self._rules.append(words)
        self._add_hook(unicorn.UC_HOOK_CODE, answering_function(), words, function, function)

    def paint_stack(self) -> None:
        """Fill the stack, so that `stack_depth` begins at 0."""
        self._stack[:] = _PAINT

    def stack_depth(self) -> int:
        """Return how much of the stack has been written since it was filled (bytes)."""
        written = np.flatnonzero(self._stack != _PAINT)
        return 0 if written.size == 0 else self._stack.size - int(written[0])

    def watch_accesses(self) -> None:
        """Stop at accesses that are not aligned from now on, which takes as long as the steps."""
        if not self._is_watched:
            self._is_watched = True
            accesses = [trap for trap in traps_of(self.image) if not trap.is_division]
            if accesses:
                self._watch(accesses)
            # What has been translated before calls no hook.
            self._engine.ctl_flush_tb()

    def _watch_divisions(self) -> None:
        """Stop at divisions by zero, once the target enables their trap; what it cannot write to stays off."""
        divisions = [trap for trap in traps_of(self.image) if trap.is_division]
        with suppress(KeyError):
            control = self.memory(CONTROL_REGISTER, 4).ctypes.data
            for trap in divisions:
                self._watch([trap], control)

    def _watch(self, traps: list[Trap], control: int = 0) -> None:
        """Have the emulator call the compiled function from the first to the last of the instructions."""
        self._rules.append(rules_of(traps, self._trapped, control))
        places = [trap.place for trap in traps]
        self._add_hook(unicorn.UC_HOOK_CODE, trapping_function(), self._rules[-1], min(places), max(places))

    def _add_hook(
        self, kind: int, function: Any, state: NDArray[np.int64], begin: int = 1, end: int = 0
    ) -> None:
        """Have the emulator call a compiled function; its package passes Python functions only."""
        status = binding.uclib.uc_hook_add(
            self._engine._uch,
            ctypes.byref(binding.uc_hook_h()),
            kind,
            ctypes.c_void_p(function.address),
            ctypes.c_void_p(state.ctypes.data),
            ctypes.c_uint64(begin),
            ctypes.c_uint64(end),
        )
        if status != unicorn.UC_ERR_OK:
            raise HarnessFault(f"the emulator cannot watch instructions: {unicorn.UcError(status)}")

    def _note_refused(
        self, _engine: Any, access: int, address: int, _size: int, _value: int, _data: Any
    ) -> bool:
        self._refused = access, address
        return False

    def _map(self, address: int, size: int, is_writable: bool, is_executable: bool) -> None:
        """Map memory of the host, in whole pages; parts that are mapped already stay."""
        begin, end = address & -PAGE, -(-(address + size) // PAGE) * PAGE
        if any(base < end and begin < base + page.size for base, page in self._pages.items()):
            raise TargetFault(
                f"has two pieces of memory in the page at {hexadecimal(begin)}; link them {PAGE} bytes apart"
            )
        # The emulator maps only memory that begins at a page, which numpy does not promise.
        memory = np.zeros(end - begin + PAGE, np.uint8)
        page = memory[-memory.ctypes.data % PAGE :][: end - begin]
        rights = unicorn.UC_PROT_READ
        rights |= unicorn.UC_PROT_WRITE if is_writable else 0
        rights |= unicorn.UC_PROT_EXEC if is_executable else 0
        self._engine.mem_map_ptr(begin, end - begin, rights, page.ctypes.data)
        self._pages[begin] = page


@cache
def step_function() -> Any:
    """Compile the C function that steps a controller on a target; one serves all."""
    # Compiled code is found again by the values of its closure, so numbers of the emulator's version belong there.
    r0, r1, r2, sp, lr = _REGISTERS

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
        if words[WRITES] != 0:
            run_program(words[WRITES], words[STACK:], own + 8 * STACK)
        write_register(words[ENGINE], r0, own + 8 * ARGUMENTS)
        write_register(words[ENGINE], r1, own + 8 * (ARGUMENTS + 1))
        write_register(words[ENGINE], r2, own + 8 * (ARGUMENTS + 2))
        write_register(words[ENGINE], sp, own + 8 * (ARGUMENTS + 3))
        write_register(words[ENGINE], lr, own + 8 * (ARGUMENTS + 4))
        words[_COUNTED] = words[_COUNTED + 1] = 0
        copy_bytes(own + 8 * _COUNTED, words[COUNTER], 16)
        words[ERROR] = start(words[ENGINE], words[BEGIN], words[UNTIL], 0, 0)
        copy_bytes(words[COUNTER], own + 8 * _COUNTED, 8)
        words[MOST_INSTRUCTIONS] = max(words[MOST_INSTRUCTIONS], words[_COUNTED] % CYCLE)
        words[MOST_CYCLES] = max(words[MOST_CYCLES], words[_COUNTED] // CYCLE)
        copy_bytes(words[TRAPPED], own + 8 * SCRATCH, 8)
        if words[SCRATCH] != 0:
            words[ERROR] = _TRAP
        if words[ERROR] != 0:
            copy_bytes(own + 8 * STOP_WORD, command, 8)
            return
        if words[READS] != 0:
            run_program(words[READS], words[STACK:], own + 8 * STACK)
        copy_bytes(words[HOST_COMMAND], command, words[COMMAND_BYTES])

    pointer: Any = types.CPointer
    signature = types.void(pointer(types.int64), types.int64, types.int64)
    return numba.cfunc(signature, cache=KEEPS_CACHE)(step_on_target)
