"""Loading an image onto an emulated processor: this belongs into a worker process."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from drivegate.candidates.candidate import WAIT_FOR_INTERRUPT, Candidate, Target
from drivegate.candidates.contract import HEADERS, AnyNameplate, ContractName, require_nameplate_of
from drivegate.candidates.elf import step as words_of_step
from drivegate.candidates.elf.coverage import write_blocks
from drivegate.candidates.elf.evaluation import program_of, run_program
from drivegate.candidates.elf.exchange import LAYOUTS, MOST_PHASES, records_in
from drivegate.candidates.elf.hints import passing_function
from drivegate.candidates.elf.image import Image, clone_of, linked_name, read_image
from drivegate.candidates.elf.inlining import inlined_into
from drivegate.candidates.elf.instruction_count import counting_function, has_cycles
from drivegate.candidates.elf.processor import CortexM, TargetFault
from drivegate.candidates.elf.stubs import answering_function
from drivegate.candidates.elf.tables import Tables
from drivegate.candidates.elf.traps import trapping_function
from drivegate.candidates.elf.variables import variables_of
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind, Phase, bounded_line
from drivegate.candidates.native.controller import RESETS, STEPS, record_of, refused_by_reset
from drivegate.candidates.native.loading import COMMON, LARGEST_STATE, require_version
from drivegate.candidates.step_costs import StepCosts
from drivegate_cases.documents.wording import one_line
from drivegate_models.contract.current.records import STATE_ALIGNMENT
from drivegate_models.contract.duty.signals import DutyNameplate
from drivegate_models.errors import HarnessFault, InputError

_PHASES_OF_DUTY: Final = 3


def compile_own_code(_candidate: Candidate) -> None:
    """Compile what the emulator calls and what steps a controller on it."""
    for function in (
        words_of_step.step_function,
        counting_function,
        answering_function,
        trapping_function,
        passing_function,
    ):
        function()
    program, stack = program_of([]), np.zeros(1, np.int64)
    run_program(program.ctypes.data, stack, stack.ctypes.data, stack.ctypes.data, False)


def load_controller(candidate: Candidate) -> TargetController:
    if not isinstance(candidate.details, Target):
        raise HarnessFault(f"the candidate {candidate.name} is no image")
    image = read_image(candidate.details.image)
    name = one_line(candidate.name)
    target = _as_linked(candidate.details, image)
    contract = _contract_of(image, name) if target.step is None else candidate.contract or "current"
    own = (*COMMON, RESETS[contract], STEPS[contract]) if target.step is None else (target.step,)
    pauses = () if target.pause in (None, WAIT_FOR_INTERRUPT) else (target.pause,)
    required = (*own, *target.start, *pauses, *(stub.function for stub in target.stub))
    missing = [function for function in required if function not in image.functions]
    if missing:
        named = f"that {HEADERS[contract]} declares" if target.step is None else "that its manifest names"
        raise InputError(
            f"{name} has no function {', '.join(map(one_line, missing))}; an image has the functions {named}, and "
            f"keeps their names when it is linked (not with -s){_hint(image, missing)}"
        )
    try:
        controller = TargetController(image, target, contract, name)
        if candidate.instrumented is not None:
            controller.count_into(candidate.instrumented.folder)
        return controller
    except TargetFault as fault:
        raise InputError(f"{name} {bounded_line(str(fault))}") from fault


class TargetController:
    """One instance of an image, stepped by address.

    `step_address`: address of the C function that steps it. `state_address`: address of what that function needs.
    `state_size`: size of the controller's own state in the memory of the target (bytes).
    """

    def __init__(self, image: Image, target: Target, contract: ContractName, name: str) -> None:
        self._contract: ContractName = contract
        self._functions = image.functions
        self._start = target.start
        self._has_adapter = target.step is None
        self._fault: Fault | None = None
        self._processor = CortexM(image, target.ram)
        self._stack_depth = 0
        self._counted: tuple[set[tuple[int, int]], Path] | None = None
        step = self._functions[target.step or STEPS[contract]]
        paused_at = self._let_pause(target)
        self._looping = None if paused_at is None else step
        if target.limits.cycles and not has_cycles(image):
            raise InputError(
                f"{name} is built for another core than the Cortex-M4, whose cycles alone are known; leave out "
                "'step_cycles' and state 'step_instructions'"
            )
        self.state_size = 0
        if self._has_adapter:
            require_version(self._processor.call(self._functions["drivegate_abi_version"]), name)
            self.state_size = self._processor.call(self._functions["drivegate_state_size"])
        if self.state_size > LARGEST_STATE:
            raise InputError(
                f"{name}: drivegate_state_size returned {self.state_size}, but must return at most {LARGEST_STATE}"
            )
        layout, nameplate_record = LAYOUTS[contract]
        sizes = (
            nameplate_record.itemsize,
            layout.sense.itemsize,
            layout.command.itemsize,
            8 * MOST_PHASES,
        )
        places = [0]
        for size in sizes:
            places.append(places[-1] + -(-size // STATE_ALIGNMENT) * STATE_ALIGNMENT)
        nameplate, sense, command, currents, state = (self._processor.mail + place for place in places)
        self._nameplate_at, self._state_at = nameplate, state if self.state_size else 0
        self._mail = self._processor.map_mail(places[-1] + self.state_size + 1)
        words = self._processor.words_for_step(step)
        words[words_of_step.PAUSED_AT] = 0 if paused_at is None else paused_at.ctypes.data
        begin = self._mail.ctypes.data
        words[words_of_step.HOST_SENSE], words[words_of_step.SENSE_BYTES] = (
            begin + places[1],
            layout.sense.itemsize,
        )
        words[words_of_step.HOST_COMMAND], words[words_of_step.COMMAND_BYTES] = (
            begin + places[2],
            layout.command.itemsize,
        )
        words[words_of_step.HOST_CURRENTS], words[words_of_step.GUEST_CURRENTS] = begin + places[3], currents
        fields: Any = layout.sense.fields
        words[words_of_step.CURRENTS_OFFSET] = fields["phase_currents"][1]
        registers = self._processor.call_registers(self._state_at, sense, command)
        words[words_of_step.ARGUMENTS : words_of_step.MOST_INSTRUCTIONS] = registers
        self._words = words
        self._places = places
        self._layout = layout
        self._tables: Tables | None = None
        if not self._has_adapter:
            records = records_in(begin, places, contract)
            self._tables = Tables(self._processor, target, records, contract, name)
            words[words_of_step.WRITES] = self._tables.writes.ctypes.data
            words[words_of_step.READS] = self._tables.reads.ctypes.data
        self._step = words_of_step.step_function()
        self.step_address: int = self._step.address
        self.state_address: int = words.ctypes.data

    def count_into(self, folder: Path) -> None:
        """Count from now on which blocks of instructions run, and write them into a folder after each run."""
        blocks: set[tuple[int, int]] = set()
        self._processor.watch_blocks(blocks)
        self._counted = blocks, folder

    def write_counters(self) -> None:
        if self._counted is not None:
            write_blocks(*self._counted)

    def watch_accesses(self) -> None:
        """End at an access that is not aligned from now on."""
        self._processor.watch_accesses()

    def taken_costs(self) -> StepCosts:
        """Return the greatest costs of a step since they were last taken."""
        words = self._words[[words_of_step.MOST_INSTRUCTIONS, words_of_step.MOST_CYCLES]].tolist()
        self._words[[words_of_step.MOST_INSTRUCTIONS, words_of_step.MOST_CYCLES]] = 0
        instructions, cycles = words
        depth = max(self._stack_depth, self._processor.stack_depth()) if instructions else 0
        self._stack_depth = 0
        return StepCosts(instructions, cycles if has_cycles(self._processor.image) else 0, depth)

    @property
    def fault(self) -> Fault | None:
        error = int(self._words[words_of_step.ERROR])
        if self._fault is None and error:
            return _crash(self._described(error), "step")
        return self._fault

    def _described(self, error: int) -> str:
        if self._tables is not None and error in (words_of_step.WILD_WRITE, words_of_step.WILD_READ):
            row, in_write = int(self._words[words_of_step.ROW]), error == words_of_step.WILD_WRITE
            return self._tables.wild_pointer(row, in_write=in_write)
        return self._processor.describe(error)

    def _let_pause(self, target: Target) -> NDArray[np.int64] | None:
        at_interrupts = target.pause == WAIT_FOR_INTERRUPT
        pause = None if target.pause is None or at_interrupts else self._functions[target.pause]
        return self._processor.pass_waiting(pause, at_interrupts=at_interrupts)

    def reset(self, nameplate: AnyNameplate) -> None:
        """Switch the target on again, and have the controller prepare for a run."""
        require_nameplate_of(self._contract, nameplate)
        record = record_of(nameplate)
        phases = _PHASES_OF_DUTY if isinstance(nameplate, DutyNameplate) else nameplate.phases
        self._words[words_of_step.CURRENTS_BYTES] = 8 * phases
        self._words[words_of_step.ERROR] = 0
        if self._words[words_of_step.MOST_INSTRUCTIONS]:
            # A reset in the middle of a run.
            self._stack_depth = max(self._stack_depth, self._processor.stack_depth())
        self._processor.power_on()
        self._mail[:] = 0
        self._mail[: record.nbytes] = record.view("u1").reshape(-1)
        if not self._has_adapter:
            self._sense_rest(nameplate)
        self._fault = self._reset_fault()
        if self._fault is None and not self._has_adapter:
            # What the start-up code has cleared is written again.
            self._write_at_start(is_strict=True)
        # Painted after the reset: what start and reset need of the stack is not that of a step.
        self._processor.paint_stack()
        if self._fault is not None:
            raise CandidateFault(self._fault)

    def _sense_rest(self, nameplate: AnyNameplate) -> None:
        """Write the Sense of a drive at rest on its nominal supply."""
        sense = self._mail[self._places[1] :][: self._layout.sense.itemsize].view(self._layout.sense)
        for field in self._layout.sense.names or ():
            if field != "phase_currents":
                default = self._layout.signals._field_defaults.get(field, 0)
                sense[field] = getattr(nameplate, field, default)

    def _write_at_start(self, *, is_strict: bool) -> None:
        if self._tables is not None:
            self._tables.write_at_start(is_strict=is_strict)

    def _reset_fault(self) -> Fault | None:
        try:
            for function in self._start:
                # Each time, since one of the functions may clear all variables.
                self._write_at_start(is_strict=False)
                self._processor.call(self._functions[function])
            if self._looping is not None:
                self._write_at_start(is_strict=False)
                self._processor.call(self._looping, may_pause=True)
                if not self._processor.is_paused:
                    return _crash(self._processor.describe(words_of_step.RETURNED), "reset")
            if not self._has_adapter:
                return None
            reset = self._functions[RESETS[self._contract]]
            status = self._processor.call(reset, self._state_at, self._nameplate_at)
        except TargetFault as fault:
            return _crash(str(fault), "reset")
        # The emulator returns the 32 bits of the register as an unsigned number.
        return None if status == 0 else refused_by_reset(self._contract, status - ((status >> 31) << 32))


def _crash(what: str, phase: Phase) -> Fault:
    return Fault(FaultKind.CRASH, bounded_line(f"the target {what}"), phase)


def _hint(image: Image, missing: Sequence[str]) -> str:
    """Say what has become of the first function that the compiler has changed."""
    clones = (clone_of(image, function) for function in missing)
    clone = next((each for each in clones if each), "")
    if clone:
        return f". The compiler has made '{one_line(clone)}' of one: mark it __attribute__((noipa))"
    described = variables_of(image.file).functions
    inlined = next((function for function in missing if function in described), "")
    if not inlined:
        return ""
    places = " and ".join(map(one_line, inlined_into(described[inlined])))
    return (
        f". The compiler has {f'inlined it into {places}' if places else 'left it out'}: mark "
        f"'{one_line(inlined)}' __attribute__((noinline, used)), and link without -flto"
    )


def _as_linked(target: Target, image: Image) -> Target:
    """Return a target whose functions have the names that the linker knows."""
    pause = target.pause if target.pause in (None, WAIT_FOR_INTERRUPT) else linked_name(image, target.pause)
    return replace(
        target,
        step=None if target.step is None else linked_name(image, target.step),
        start=tuple(linked_name(image, function) for function in target.start),
        stub=tuple(replace(stub, function=linked_name(image, stub.function)) for stub in target.stub),
        pause=pause,
    )


def _contract_of(image: Image, name: str) -> ContractName:
    found = [contract for contract, step in STEPS.items() if step in image.functions]
    if len(found) > 1:
        raise InputError(f"{name} has both {' and '.join(STEPS.values())}; link one of them")
    return found[0] if found else "current"
