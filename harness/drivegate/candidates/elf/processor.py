"""A Cortex-M processor with its memory, emulated by Unicorn."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from contextlib import suppress
from importlib import import_module
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.elf.emulator import arm_const, binding
from drivegate.candidates.elf.evaluation import table_of
from drivegate.candidates.elf.hints import passing_function, waiting_at, words_of
from drivegate.candidates.elf.image import Image, hexadecimal, place_of
from drivegate.candidates.elf.instruction_count import (
    BUDGET,
    LONGEST_INSTRUCTION,
    SPENT,
    counter,
    counting_function,
)
from drivegate.candidates.elf.memory import ADDRESSES, PAGE, Area, Stretch, areas_of, memory_at
from drivegate.candidates.elf.step import (
    AREAS,
    BEGIN,
    CALL_REGISTERS,
    COUNTER,
    ENGINE,
    MOST_INSTRUCTIONS_OF_STEP,
    RETURNED,
    SELF,
    STOP_WORD,
    TRAP,
    TRAPPED,
    UNTIL,
    WORDS,
)
from drivegate.candidates.elf.stubs import Answer, answering_function
from drivegate.candidates.elf.traps import (
    CONTROL_REGISTER,
    ENDLESS,
    MASK,
    OPERAND,
    PLACE,
    WILD_POINTER,
    Trap,
    rules_of,
    trapping_function,
    traps_of,
)
from drivegate_cases.documents.wording import shown_path
from drivegate_models.contract.current.records import STOP
from drivegate_models.errors import HarnessFault, InputError

if TYPE_CHECKING:
    from drivegate.candidates.elf.exchange import Program

unicorn: Any = import_module("unicorn")

STACK_BYTES: Final = 64 * 1024
"""Size of the stack (bytes)."""
_ABOVE: Final = 16
_REGION: Final = 0x1000_0000
"""Records, stack and return address are in a region of this size that the image does not use (bytes)."""
_MAIL, _STACK, _RETURN = 0x0000_0000, 0x0100_0000, 0x0200_0000
_TRANSLATIONS: Final = 32 * 2**20
MOST_INSTRUCTIONS_OF_START: Final = 20_000_000
"""The same for a function that is called before a run; it takes a second, where a worker has five."""
_PAINT: Final = 0xA5
"""What the stack is filled with, so that the deepest byte that is written shows."""

_SEMIHOSTING: Final = 0xAB
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
        further = [Stretch(address, size, True, False) for address, size in ram]
        if any(each.address + each.size > ADDRESSES for each in further):
            raise InputError(
                f"{shown_path(image.file)}: a piece of 'ram' ends beyond the last address; give [address, bytes]"
            )
        self._areas = [*areas_of((*image.stretches, *further))]
        for segment in image.segments:
            # Where segments overlap, what the code sees at its own addresses is last.
            if segment.content:
                flash = self.memory(segment.flashed_at, len(segment.content))
                flash[:] = np.frombuffer(segment.content, np.uint8)
        for segment in image.segments:
            content = segment.content.ljust(segment.size, b"\0")
            self.memory(segment.address, segment.size)[:] = np.frombuffer(content, np.uint8)
        # Copied back at each reset, as start-up code does at power-on, so that no run sees another's variables.
        self._initial = [(area.content, area.content.copy()) for area in self._areas]
        for area in self._areas:
            self._map(area)
        self._base = self._free_region()
        # Where records are exchanged, once `map_mail` has made the memory.
        self.mail = self._base + _MAIL
        self._add(Stretch(self._base + _STACK, STACK_BYTES, True, False))
        # The first words of a call are above the stack pointer.
        self._stack = self.memory(self._base + _STACK, STACK_BYTES - _ABOVE)
        self._add(Stretch(self._base + _RETURN, PAGE, False, True))
        self.table = table_of(self._areas)
        self._refused: tuple[int, int] | None = None
        self._engine.hook_add(unicorn.UC_HOOK_MEM_INVALID, self._note_refused)
        self._ended = np.zeros(MASK + 1, np.int64)
        self._counter = counter(image, self._ended)
        self._add_hook(unicorn.UC_HOOK_BLOCK, counting_function(), self._counter)
        self._is_watched = False
        # What compiled functions get must live as long as the emulator.
        self._rules: list[NDArray[np.int64]] = []
        self._fills: dict[int, Program] = {}
        self._answers: list[Answer] = []
        self._paused_at = np.zeros(1, np.int64)
        self._watch_divisions()
        self.power_on()

    def watch_blocks(self, blocks: set[tuple[int, int]]) -> None:
        """Add each block of instructions that runs from now on, its address and size, to a set."""

        def note(_engine: Any, address: int, size: int, _data: object) -> None:
            blocks.add((address, size))

        self._engine.hook_add(unicorn.UC_HOOK_BLOCK, note)

    def map_mail(self, size: int) -> NDArray[np.uint8]:
        """Make the memory that records are exchanged in."""
        self._add(Stretch(self.mail, size, True, False))
        return self.memory(self.mail, size)

    def power_on(self) -> None:
        """Load the image again, so that all of its variables have their initial values."""
        for memory, content in self._initial:
            memory[:] = content
        self._ended[:] = 0
        self._paused_at[:] = 0

    def memory(self, address: int, size: int) -> NDArray[np.uint8]:
        """Return memory of the target, which changes with it."""
        return memory_at(self._areas, address, size)

    def call(self, function: int, *arguments: int, may_pause: bool = False) -> int:
        """Call a function, and return its result; `may_pause`: whether it also ends where it pauses.

        Raises TargetFault if it does what the processor or the memory does not allow.
        """
        for register, value in zip(CALL_REGISTERS, self.call_registers(*arguments), strict=True):
            self._engine.reg_write(register, value)
        self._refused = None
        self._counter[SPENT], self._counter[BUDGET] = 0, LONGEST_INSTRUCTION * MOST_INSTRUCTIONS_OF_START
        # The lowest bit selects the Thumb instruction set, the only one that these processors have.
        place, until = function | 1, self._base + _RETURN
        try:
            while place & ~1 != until:
                self._engine.emu_start(place, until)
                if self._ended.any() or (may_pause and self._paused_at[0]):
                    break
                self._paused_at[:] = 0
                # The emulator also ends where an instruction waits under a condition.
                place = int(self._engine.reg_read(arm_const.UC_ARM_REG_PC)) | 1
        except unicorn.UcError as error:
            raise TargetFault(self.describe(error.errno)) from None
        if self._ended.any():
            raise TargetFault(self.describe(TRAP, MOST_INSTRUCTIONS_OF_START))
        return int(self._engine.reg_read(arm_const.UC_ARM_REG_R0))

    @property
    def is_paused(self) -> bool:
        """Whether the last call has ended at a pause, where the next step goes on."""
        return bool(self._paused_at[0])

    def call_registers(self, *arguments: int) -> tuple[int, ...]:
        """Return the registers of a call: three arguments, stack pointer and link register."""
        three = (*arguments, 0, 0, 0)[:3]
        return (*three, self._base + _STACK + STACK_BYTES - _ABOVE, (self._base + _RETURN) | 1)

    def describe(self, error: int, most: int = MOST_INSTRUCTIONS_OF_STEP) -> str:
        """Say what ended a call: an error of the emulator, or TRAP; `most`: the instructions that it could execute."""
        if error == TRAP:
            return self._describe_trap(most)
        if error == RETURNED:
            return (
                "returns before it pauses; 'pause' must name a function that it calls in each control period"
            )
        stop_sentence = self._describe_stop(error)
        if stop_sentence:
            return stop_sentence
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

    def _describe_trap(self, most: int) -> str:
        place, mask = place_of(self.image, int(self._ended[PLACE])), int(self._ended[MASK])
        if mask == ENDLESS:
            return f"executes more than {most // 1_000_000} million instructions without coming to an end, {place}"
        if mask == WILD_POINTER:
            filled = self._fills[int(self._ended[PLACE])].place_of_row(int(self._ended[OPERAND]))
            return f"passes a pointer to no memory of the target: '{filled}' in [stub], {place}"
        if not mask:
            return f"divides by zero {place}"
        address = hexadecimal(int(self._ended[OPERAND]))
        return f"accesses address {address}, no multiple of {mask + 1}, {place}"

    def _describe_stop(self, error: int) -> str:
        """Name an instruction that asks a debugger or an operating system for something; empty for another one."""
        if error != unicorn.UC_ERR_EXCEPTION:
            return ""
        address = int(self._engine.reg_read(arm_const.UC_ARM_REG_PC)) & ~1
        try:
            before, at = self.memory(address - 2, 4).view("<u2").tolist()
        except KeyError:
            return ""
        number, place = at & 0xFF, place_of(self.image, address)
        if at >> 8 == 0xBE:
            if number == _SEMIHOSTING:
                return (
                    f"calls a debugger by semihosting (bkpt ABh) {place}; link with --specs=nosys.specs instead of "
                    "rdimon.specs, or answer the function in [stub]"
                )
            return f"stops at a breakpoint for a debugger (bkpt {number}), often a failed assertion, {place}"
        if before >> 8 == 0xDF:
            place = place_of(self.image, address - 2)
            return f"calls an operating system (svc {before & 0xFF}), which is not emulated, {place}"
        return ""

    def words_for_step(self, step: int) -> NDArray[np.int64]:
        """Return the state of the C function, with all that is the same in each step."""
        words = np.zeros(WORDS, np.int64)
        words[ENGINE] = self._engine._uch.value
        words[BEGIN], words[UNTIL] = step | 1, self._base + _RETURN
        words[SELF] = words.ctypes.data
        words[STOP_WORD] = STOP
        words[TRAPPED] = self._ended.ctypes.data
        words[COUNTER] = self._counter.ctypes.data
        words[AREAS] = self.table.ctypes.data
        return words

    def answer(self, function: int, made: Callable[[Answer], Program]) -> None:
        """Answer each call of a function by a program that `made` makes, without running it."""
        answer = Answer(self.table, self._ended)
        self._fills[function] = made(answer)
        self._rules.append(answer.words)
        self._answers.append(answer)
        self._add_hook(unicorn.UC_HOOK_CODE, answering_function(), answer.words, function, function)

    def pass_waiting(self, pause: int | None, *, at_interrupts: bool) -> NDArray[np.int64] | None:
        """Go on at instructions that wait.

        `pause`: address of a function where each step ends instead, and the next one goes on. `at_interrupts`: whether
        that is each instruction that waits for an interrupt. Return where the step finds the place that it goes on at,
        shape (1,); None where no step pauses.
        """
        for address, size, waits_for_interrupt in waiting_at(self.image):
            ends = at_interrupts and waits_for_interrupt
            self._rules.append(words_of(size, self._paused_at if ends else None))
            self._add_hook(unicorn.UC_HOOK_CODE, passing_function(), self._rules[-1], address, address)
        if pause is not None:
            self._rules.append(words_of(0, self._paused_at))
            self._add_hook(unicorn.UC_HOOK_CODE, passing_function(), self._rules[-1], pause, pause)
        return self._paused_at if pause is not None or at_interrupts else None

    def paint_stack(self) -> None:
        """Fill the stack, so that `stack_depth` begins at 0, or at the depth of what is paused."""
        end = self._stack.size
        if self.is_paused:
            end = int(self._engine.reg_read(arm_const.UC_ARM_REG_SP)) - self._base - _STACK
        self._stack[: max(end, 0)] = _PAINT

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
        self._rules.append(rules_of(traps, self._ended, control))
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

    def _free_region(self) -> int:
        """Find a region that the image does not use."""
        # Code, SRAM and peripherals of every Cortex-M are below the first address.
        for base in range(0x6000_0000, ADDRESSES, _REGION):
            if not any(
                area.address < base + _REGION and base < area.address + area.content.size
                for area in self._areas
            ):
                return base
        raise InputError(
            f"{shown_path(self.image.file)}: segments and 'ram' leave no {_REGION // 2**20} MiB free from 60000000h "
            "on; leave out what the controller does not need"
        )

    def _add(self, stretch: Stretch) -> None:
        """Map memory that is not the image's."""
        for area in areas_of([stretch]):
            self._areas.append(area)
            self._map(area)

    def _map(self, area: Area) -> None:
        """Map memory of this machine."""
        for stretch in area.stretches:
            rights = unicorn.UC_PROT_READ
            rights |= unicorn.UC_PROT_WRITE if stretch.is_writable else 0
            rights |= unicorn.UC_PROT_EXEC if stretch.is_executable else 0
            place = area.content.ctypes.data + stretch.address - area.address
            self._engine.mem_map_ptr(stretch.address, stretch.size, rights, place)
