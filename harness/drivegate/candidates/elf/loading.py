"""Loading an image onto an emulated processor: this belongs into a worker process."""

from __future__ import annotations

from typing import Any, Final

from drivegate.candidates.candidate import Candidate, Target
from drivegate.candidates.contract import HEADERS, AnyNameplate, ContractName, require_nameplate_of
from drivegate.candidates.elf import processor
from drivegate.candidates.elf.image import Image, read_image
from drivegate.candidates.elf.processor import CortexM, TargetFault, step_function
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind, Phase, bounded_line
from drivegate.candidates.native.controller import RESETS, STEPS, record_of, refused_by_reset
from drivegate.candidates.native.loading import COMMON, LARGEST_STATE, require_version
from drivegate_cases.documents.wording import one_line
from drivegate_models.contract.current.records import NAMEPLATE, STATE_ALIGNMENT
from drivegate_models.contract.duty.records import DUTY_NAMEPLATE
from drivegate_models.contract.duty.signals import DutyNameplate
from drivegate_models.contract.layout import CURRENT, DUTY
from drivegate_models.errors import HarnessFault, InputError

_PHASES_OF_DUTY: Final = 3
_CURRENTS_BYTES: Final = 8 * 64
_LAYOUTS: Final = {"current": CURRENT, "duty": DUTY}
_NAMEPLATES: Final = {"current": NAMEPLATE, "duty": DUTY_NAMEPLATE}


def load_controller(candidate: Candidate) -> TargetController:
    """Make a new instance of an image: a processor with its memory."""
    if not isinstance(candidate.details, Target):
        raise HarnessFault(f"the candidate {candidate.name} is no image")
    image = read_image(candidate.details.image)
    name = one_line(candidate.name)
    contract = _contract_of(image, name)
    required = (*COMMON, RESETS[contract], STEPS[contract], *filter(None, (candidate.details.start,)))
    missing = [function for function in required if function not in image.functions]
    if missing:
        raise InputError(
            f"{name} has no function {', '.join(map(one_line, missing))}; an image has the functions that "
            f"{HEADERS[contract]} declares, and keeps their names when it is linked (not with -s)"
        )
    try:
        return TargetController(image, candidate.details, contract, name)
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
        self._fault: Fault | None = None
        self._processor = CortexM(image, target.ram)
        require_version(self._processor.call(self._functions["drivegate_abi_version"]), name)
        self.state_size = self._processor.call(self._functions["drivegate_state_size"])
        if self.state_size > LARGEST_STATE:
            raise InputError(
                f"{name}: drivegate_state_size returned {self.state_size}, but must return at most {LARGEST_STATE}"
            )
        layout = _LAYOUTS[contract]
        sizes = (
            _NAMEPLATES[contract].itemsize,
            layout.sense.itemsize,
            layout.command.itemsize,
            _CURRENTS_BYTES,
        )
        places = [0]
        for size in sizes:
            places.append(places[-1] + -(-size // STATE_ALIGNMENT) * STATE_ALIGNMENT)
        nameplate, sense, command, currents, state = (self._processor.mail + place for place in places)
        self._nameplate_at, self._state_at = nameplate, state if self.state_size else 0
        self._mail = self._processor.map_mail(places[-1] + self.state_size + 1)
        words = self._processor.words_for_step(self._functions[STEPS[contract]])
        begin = self._mail.ctypes.data
        words[processor.HOST_SENSE], words[processor.SENSE_BYTES] = begin + places[1], layout.sense.itemsize
        words[processor.HOST_COMMAND], words[processor.COMMAND_BYTES] = (
            begin + places[2],
            layout.command.itemsize,
        )
        words[processor.HOST_CURRENTS], words[processor.GUEST_CURRENTS] = begin + places[3], currents
        fields: Any = layout.sense.fields
        words[processor.CURRENTS_OFFSET] = fields["phase_currents"][1]
        registers = self._processor.call_registers(self._state_at, sense, command)
        words[processor.ARGUMENTS :] = registers
        self._words = words
        self._step = step_function()
        self.step_address: int = self._step.address
        self.state_address: int = words.ctypes.data

    def watch_steps(self) -> None:
        """Count the instructions of the steps from now on, and end at an access that is not aligned."""
        self._words[processor.COUNTER] = self._processor.watch_steps()

    @property
    def most_instructions(self) -> int:
        """Greatest number of instructions of a counted step since the reset; 0 where none is counted."""
        return int(self._words[processor.MOST_INSTRUCTIONS])

    @property
    def fault(self) -> Fault | None:
        """What ended the last run, in the reset or in a step."""
        error = int(self._words[processor.ERROR])
        if self._fault is None and error:
            return _crash(self._processor.describe(error), "step")
        return self._fault

    def reset(self, nameplate: AnyNameplate) -> None:
        """Switch the target on again, and have the controller prepare for a run."""
        require_nameplate_of(self._contract, nameplate)
        record = record_of(nameplate)
        phases = _PHASES_OF_DUTY if isinstance(nameplate, DutyNameplate) else nameplate.phases
        self._words[processor.CURRENTS_BYTES] = 8 * phases
        self._words[processor.ERROR] = self._words[processor.MOST_INSTRUCTIONS] = 0
        self._processor.power_on()
        self._mail[:] = 0
        self._mail[: record.nbytes] = record.view("u1").reshape(-1)
        self._fault = self._reset_fault()
        if self._fault is not None:
            raise CandidateFault(self._fault)

    def _reset_fault(self) -> Fault | None:
        try:
            if self._start is not None:
                self._processor.call(self._functions[self._start])
            reset = self._functions[RESETS[self._contract]]
            status = self._processor.call(reset, self._state_at, self._nameplate_at)
        except TargetFault as fault:
            return _crash(str(fault), "reset")
        return None if status == 0 else refused_by_reset(self._contract, status - ((status >> 31) << 32))


def _crash(what: str, phase: Phase) -> Fault:
    return Fault(FaultKind.CRASH, bounded_line(f"the target {what}"), phase)


def _contract_of(image: Image, name: str) -> ContractName:
    """Return the contract whose step an image has."""
    found = [contract for contract, step in STEPS.items() if step in image.functions]
    if len(found) > 1:
        raise InputError(f"{name} has both {' and '.join(STEPS.values())}; link one of them")
    return found[0] if found else "current"
