"""Images for Cortex-M: the same commands as on this machine, and faults that name the line.

No source calls a sine or the like: the libraries of the two compilers differ in the last digit.
"""

from __future__ import annotations

import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from drivegate.candidates.elf.instruction_count import CORE, REFILL, cycles_of
from drivegate.candidates.elf.loading import TargetController
from drivegate.candidates.fault import CandidateFault, Fault, FaultKind
from drivegate.candidates.kinds import load_controller, untimed_because
from drivegate.candidates.native.compiler import include_folder
from drivegate.candidates.resolution import resolve_candidate
from drivegate.candidates.step_costs import NO_COSTS, StepCosts
from drivegate.containment.judge import Judge, own_candidate
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.running import recorded
from drivegate.gate.plan import NOTHING_DECLARED, time_steps
from drivegate.gate.shard import FixedRuns, run_fixed
from drivegate.results.verdict import check_outcomes, costly_steps
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

pytestmark = pytest.mark.needs("arm-none-eabi-gcc")

TARGET = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-nostartfiles")
PLACES = ("-Wl,-Ttext=0x08000000", "-Wl,-Tdata=0x20000000", "-Wl,-e,0")
CURRENT = """
#include "drivegate.h"
#include <math.h>
typedef struct { double limit; int64_t steps; } controller;
static double runs = 0.25;
static float filtered;
int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }
int64_t drivegate_state_size(void) { return sizeof(controller); }
int drivegate_reset(void *state, const drivegate_nameplate *nameplate) {
    controller *self = state;
    self->limit = nameplate->current_limit; self->steps = 0; runs += 1.0; filtered = 0.0f;
    return RESET;
}
void drivegate_step(void *state, const drivegate_sense *sense, drivegate_command *command) {
    controller *self = state;
    float error = (float)(sense->speed_reference - sense->speed);
    filtered += 0.01f * (error - filtered) + 0.001f * (float)sense->phase_currents[1];
    self->steps += 1;
    command->current_reference = fmin(fmax(0.4 * filtered, 0.0), self->limit);
    command->advance_angle = 0.3 + 0.01 * (runs - 1.25) + 0.1 * sense->time;
    STEP
}
"""
DUTY = """
#include "drivegate_duty.h"
#include <math.h>
int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }
int64_t drivegate_state_size(void) { return 8; }
int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *nameplate) {
    *(double *)state = (double)nameplate->pole_pairs;
    return 0;
}
void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    double turns = *(double *)state * sense->angle / 6.283185307179586;
    for (int leg = 0; leg < 3; ++leg) {
        double within = turns - leg / 3.0 - floor(turns - leg / 3.0);
        command->duty_ratios[leg] = 0.45 + 0.2 * fabs(within - 0.5) - 0.001 * sense->phase_currents[leg];
    }
}
"""


def scenario_of(drive: str) -> Scenario:
    document = load_drive(drive)
    fixed = contract_of(document).fixed_scenarios(document, NOTHING_DECLARED)
    return fixed[1].model_copy(update={"duration_s": 0.05})


def digest_of(loaded: JudgedCandidate, scenario: Scenario) -> int:
    return int(recorded(loaded, scenario, loaded.controller()).run.digest)


def digests_of_two_runs(loaded: JudgedCandidate, scenario: Scenario) -> list[int]:
    controller = loaded.controller()
    return [int(recorded(loaded, scenario, controller).run.digest) for _ in range(2)]


@pytest.fixture
def image(tmp_path: Path) -> Callable[..., Path]:
    """Link an image from one source."""

    def linked(
        source: str = CURRENT, step: str = "", reset: str = "0", target: tuple[str, ...] = TARGET
    ) -> Path:
        (tmp_path / "mine.c").write_text(source, encoding="utf-8")
        words = (
            f"-DSTEP={step or ';'}",
            f"-DRESET={reset}",
            "-O1",
            "-g",
            "-ffp-contract=off",
            *target,
        )
        command = [
            "arm-none-eabi-gcc",
            *words,
            f"-I{include_folder()}",
            *PLACES,
            "-o",
            "mine.elf",
            "mine.c",
            "-lm",
        ]
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
        return tmp_path / "mine.elf"

    return linked


def run(candidate: str, scenario: Scenario) -> object:
    with Judge(resolve_candidate(candidate)) as judge:
        return judge.once(Job(digest_of, scenario))


def run_here(candidate: str, scenario: Scenario, *, is_watched: bool = False) -> int | Fault:
    """Run an image in this process, which compiles what steps a target only once."""
    loaded = own_candidate(resolve_candidate(candidate))
    controller = loaded.controller()
    if is_watched:
        assert isinstance(controller, TargetController)
        controller.watch_accesses()
    try:
        return int(recorded(loaded, scenario, controller).run.digest)
    except CandidateFault as ended:
        return ended.fault


@pytest.mark.parametrize(
    ("step", "more"),
    [
        ('__asm__ volatile(".rept 100\\n nop\\n .endr");', 100),
        # Of 16 and of 32 bits by turns.
        ('__asm__ volatile(".rept 50\\n nop\\n nop.w\\n .endr");', 100),
        # What a condition skips is fetched like any other; before the ten rounds the counter is set.
        (
            '__asm__ volatile("mov r3, #10\\n 1: subs r3, #1\\n it mi\\n nopmi\\n bne 1b" ::: "r3", "cc");',
            1 + 10 * 4,
        ),
    ],
)
def test_the_instructions_of_a_step_are_counted(image: Callable[..., Path], step: str, more: int) -> None:
    scenario = scenario_of("paper-5-phase")
    counts = []
    for name, code in (("one.elf", ";"), ("two.elf", step)):
        file = image(CURRENT, code)
        controller = load_controller(resolve_candidate(str(file.rename(file.with_name(name)))))
        loaded = JudgedCandidate(resolve_candidate("reference"), lambda own=controller: own)
        recorded(loaded, scenario, controller)
        counts.append(controller.taken_costs().instructions)
        assert controller.taken_costs() == NO_COSTS
    assert counts[1] - counts[0] == more


def costs_of(file: Path, scenario: Scenario) -> StepCosts:
    """Return what the steps of an image cost in a run in this process; the next image gets another name."""
    file = file.rename(file.with_name(f"image-{len([*file.parent.iterdir()])}.elf"))
    controller = load_controller(resolve_candidate(str(file)))
    loaded = JudgedCandidate(resolve_candidate("reference"), lambda: controller)
    recorded(loaded, scenario, controller)
    costs: StepCosts = controller.taken_costs()
    return costs


ROOM = '__asm__ volatile("sub sp, #{0}\\n mov r3, #0\\n str r3, [sp]\\n add sp, #{0}" ::: "r3", "memory");'


@pytest.mark.parametrize(
    ("step", "more"),
    [
        ('__asm__ volatile(".rept 100\\n nop\\n .endr");', 100),
        ('__asm__ volatile("mov r3, #7\\n udiv r3, r3, r3" ::: "r3");', 1 + 12),
        ('__asm__ volatile("vdiv.f32 s15, s15, s15\\n vmla.f32 s15, s15, s15" ::: "s15");', 14 + 3),
        # Nine branches back are taken, the tenth is not.
        (
            '__asm__ volatile("mov r3, #10\\n 1: subs r3, #1\\n bne 1b" ::: "r3", "cc");',
            1 + 10 * 2 + 9 * REFILL,
        ),
    ],
)
def test_the_cycles_of_a_step_follow_from_the_table(image: Callable[..., Path], step: str, more: int) -> None:
    scenario = scenario_of("paper-5-phase")
    plain = costs_of(image(), scenario)
    assert costs_of(image(CURRENT, step), scenario).cycles - plain.cycles == more


def test_of_another_core_cycles_are_not_known_and_a_limit_of_them_is_refused(
    image: Callable[..., Path],
) -> None:
    file = image(target=("-mcpu=cortex-m3", "-mthumb", "-nostartfiles"))
    manifest = file.with_name("candidate.toml")
    manifest.write_text(
        'schema = 1\nname = "mine"\nkind = "elf"\nentry = "mine.elf"\nstep_cycles = 9\n', encoding="utf-8"
    )
    with pytest.raises(
        InputError, match="mine is built for another core than the Cortex-M4, whose cycles alone"
    ):
        load_controller(resolve_candidate(str(manifest)))
    costs = costs_of(file, scenario_of("paper-5-phase"))
    assert (costs.cycles, costs.instructions > 100) == (0, True)


def test_the_depth_of_the_stack_is_that_of_the_deepest_step(image: Callable[..., Path]) -> None:
    scenario = scenario_of("paper-5-phase")
    depths = []
    for size in (504, 1016):
        only_once = f"if (self->steps == 7) {{ {ROOM.format(size)} }}"
        depths.append(costs_of(image(CURRENT, only_once), scenario).stack_bytes)
    assert depths[1] - depths[0] == 1016 - 504
    assert 504 < depths[0] < 700
    # What a reset needs is not that of a step.
    deep_reset = costs_of(
        image(CURRENT.replace("return RESET", f"{ROOM.format(1016)} return RESET")), scenario
    )
    assert deep_reset.stack_bytes < 200


@pytest.mark.parametrize(
    ("halfwords", "cycles"),
    [
        ((0xB5F0, 0), 6),  # push {r4-r7, lr}
        ((0xBDF0, 0), 6),  # pop {r4-r7, pc}, without the refill
        ((0x6818, 0), 2),  # ldr r0, [r3]
        ((0x4B01, 0), 2),  # ldr r3, [pc, #4]
        ((0xC80E, 0), 4),  # ldm r0, {r1-r3}
        ((0x4770, 0), 1),  # bx lr
        ((0xE92D, 0x4FF0), 10),  # stmdb sp!, {r4-r11, lr}
        ((0xE9D3, 0x0100), 3),  # ldrd r0, r1, [r3]
        ((0xE8DF, 0xF000), 2),  # tbb [pc, r0]
        ((0xE853, 0x0F00), 2),  # ldrex r0, [r3]
        ((0xF8D3, 0x0004), 2),  # ldr.w r0, [r3, #4]
        ((0xFB02, 0xF303), 1),  # mul r3, r2, r3
        ((0xFB93, 0xF3F2), 12),  # sdiv r3, r3, r2
        ((0xFBA3, 0x2300), 1),  # umull r2, r3, r3, r0
        ((0xEDD3, 0x7A00), 2),  # vldr s15, [r3]
        ((0xED93, 0x7B00), 3),  # vldr d7, [r3]
        ((0xED2D, 0x8B04), 5),  # vpush {d8-d9}
        ((0xEC53, 0x2B17), 2),  # vmov r2, r3, d7
        ((0xEE77, 0x7A87), 1),  # vadd.f32 s15, s15, s14
        ((0xEE67, 0x7A87), 1),  # vmul.f32 s15, s15, s14
        ((0xEEC7, 0x7A87), 14),  # vdiv.f32 s15, s15, s14
        ((0xEEE7, 0x7A87), 3),  # vfma.f32 s15, s15, s14
        ((0xEEF1, 0x7AE7), 14),  # vsqrt.f32 s15, s15
        ((0xEEF0, 0x7AE7), 1),  # vabs.f32 s15, s15
        ((0xEE17, 0x3A90), 1),  # vmov r3, s15
        ((0xEEF1, 0xFA10), 1),  # vmrs APSR_nzcv, fpscr
    ],
)
def test_the_cycles_of_an_instruction_are_those_of_the_manual(
    halfwords: tuple[int, int], cycles: int
) -> None:
    assert CORE == "CORTEX_M4"
    assert cycles_of(*halfwords) == cycles


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("limit", "is_met"),
    [
        ("step_instructions = 100000", True),
        ("step_instructions = 10", False),
        ("step_cycles = 100000", True),
        ("step_cycles = 10", False),
        ("stack_bytes = 10", False),
    ],
)
def test_a_step_is_judged_by_what_the_manifest_allows_in_every_run(
    image: Callable[..., Path], limit: str, is_met: bool
) -> None:
    file = image().with_name("candidate.toml")
    file.write_text(
        f'schema = 1\nname = "mine"\nkind = "elf"\nentry = "mine.elf"\n{limit}\n', encoding="utf-8"
    )
    scenario, key = scenario_of("paper-5-phase"), limit.split()[0]
    candidate = resolve_candidate(str(file))
    with Judge(candidate) as judge:
        timed = judge.once(Job(time_steps, scenario))
        fixed = judge.once(Job(run_fixed, FixedRuns((scenario,))))
    assert not isinstance(timed, Fault), timed
    assert not isinstance(fixed, Fault), fixed
    for run in (*timed.runs, *fixed.runs):
        (margin,) = (margin for margin in run.margins if margin.check == "TIM-1")
        assert margin.met is is_met, margin.measured
        assert margin.measured.endswith(f"{limit.split()[-1]} stated in '{key}'")
    outcomes = check_outcomes(fixed.runs, candidate.declaration, scenario.drive, complete=True)
    (outcome,) = (outcome for outcome in outcomes if outcome.id == "TIM-1")
    assert (outcome.verdict, outcome.scenario) == ("pass" if is_met else "fail", scenario.to_mapping())
    steps = costly_steps(fixed.runs, candidate.step_limits)
    assert steps is not None
    assert {name for name, cost in steps.items() if cost["limit"]} == {key.removeprefix("step_")}
    assert {cost["scenario"] for cost in steps.values()} == {scenario.name}
    assert set(steps) == {"instructions", "cycles", "stack_bytes"}


@pytest.mark.parametrize(("limit", "judged"), [("", False), ("stack_bytes = 60000", True)])
def test_an_image_is_never_judged_by_the_speed_of_the_emulator(
    image: Callable[..., Path], limit: str, judged: bool
) -> None:
    file = image().with_name("candidate.toml")
    file.write_text(
        f'schema = 1\nname = "mine"\nkind = "elf"\nentry = "mine.elf"\n{limit}\n', encoding="utf-8"
    )
    scenario, candidate = scenario_of("paper-5-phase"), resolve_candidate(str(file))
    with Judge(candidate) as judge:
        timed = judge.once(Job(time_steps, scenario))
    assert not isinstance(timed, Fault), timed
    (run,) = timed.runs
    assert all("emulated" not in margin.measured for margin in run.margins)
    assert not any(margin.is_timed for margin in run.margins)
    because = untimed_because(candidate)
    outcomes = check_outcomes(
        timed.runs, candidate.declaration, scenario.drive, complete=True, untimed_because=because
    )
    (outcome,) = (outcome for outcome in outcomes if outcome.id == "TIM-1")
    assert outcome.verdict == ("pass" if judged else "not applicable")
    assert judged or "the speed of the emulator says nothing of the target" in outcome.message
    assert judged or "on the target, a step takes at most" in outcome.message


@pytest.mark.parametrize(("source", "drive"), [(CURRENT, "paper-5-phase"), (DUTY, "pm-ac-surface")])
def test_an_image_gives_the_commands_of_a_build_for_this_machine(
    image: Callable[..., Path], tmp_path: Path, source: str, drive: str
) -> None:
    here = tmp_path / "here.toml"
    here.write_text(
        'schema = 1\nname = "here"\nkind = "c"\nentry = "mine.c"\nflags = ["-DSTEP=;", "-DRESET=0"]\n'
    )
    target = image(source)
    assert resolve_candidate(str(target)).contract == load_drive(drive).contract
    scenario = scenario_of(drive)
    on_target = run_here(str(target), scenario)
    assert not isinstance(on_target, Fault), on_target
    assert on_target == run_here(str(here), scenario)
    # The image counts its runs in a variable, which has its initial value again when the target is switched on.
    with Judge(resolve_candidate(str(target))) as judge:
        assert judge.once(Job(digests_of_two_runs, scenario)) == [on_target, on_target]


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("step", "reported"),
    [
        (
            "*(volatile int *)0x40012c34 = 1;",
            "writes to address 40012C34h, where the target has no memory, in drivegate_step (mine.c line ",
        ),
        ("*(volatile int *)0x08000000 = 1;", "writes to the read-only address 08000000h in drivegate_step"),
        (
            "((void (*)(void))0x12345671)();",
            "jumps to address 12345670h, where the target has no memory, in drivegate_step",
        ),
        (
            "volatile char *much = __builtin_alloca(100000); much[0] = 1;",
            "uses more than 64 KiB of stack in drivegate_step",
        ),
        (
            '__asm__ volatile("udf #0");',
            "executes what is no instruction of this processor in drivegate_step",
        ),
        (
            '__asm__ volatile("wfe\\n udf #0");',
            "executes what is no instruction of this processor in drivegate_step",
        ),
        (
            '__asm__ volatile("bkpt #0xAB");',
            "calls a debugger by semihosting (bkpt ABh) in drivegate_step (mine.c line ",
        ),
        (
            '__asm__ volatile("bkpt #1");',
            "stops at a breakpoint for a debugger (bkpt 1), often a failed assertion, in drivegate_step (mine.c line ",
        ),
        (
            '__asm__ volatile("svc #5");',
            "calls an operating system (svc 5), which is not emulated, in drivegate_step (mine.c line ",
        ),
        (
            "while (!*(volatile char *)&self->limit) {}",
            "executes more than 10 million instructions without coming to an end, in drivegate_step (mine.c line ",
        ),
    ],
)
def test_what_the_target_must_not_do_is_a_fault_with_its_line(
    image: Callable[..., Path], step: str, reported: str
) -> None:
    faulty = image(step=f"if (self->steps == 3) {{ {step} }}")
    fault = run_here(str(faulty), scenario_of("paper-5-phase"))
    assert isinstance(fault, Fault)
    assert (fault.kind, fault.phase, fault.step) == (FaultKind.CRASH, "step", 2)
    assert fault.message.startswith(f"the target {reported}"), fault.message


@pytest.mark.parametrize("target", ["-mcpu=cortex-m4", "-mcpu=cortex-m0plus"])
def test_an_instruction_that_waits_does_nothing(image: Callable[..., Path], target: str) -> None:
    scenario = scenario_of("paper-5-phase")
    cpu = TARGET if target in TARGET else (target, "-mthumb", "-nostartfiles")
    plain = run_here(str(image(target=cpu)), scenario)
    for waiting in ("wfi", "wfe", "yield", "sev", "wfi\\n wfi\\n wfe\\n wfe\\n wfi"):
        assert run_here(str(image(step=f'__asm__ volatile("{waiting}");', target=cpu)), scenario) == plain
    if cpu is TARGET:
        conditional = "wfi.w\\n wfe.w\\n yield.w\\n cmp r0, r0\\n itt eq\\n wfieq\\n wfeeq\\n it ne\\n wfine"
        step = f'__asm__ volatile("{conditional}" ::: "cc");'
        assert run_here(str(image(step=step, target=cpu)), scenario) == plain


def test_a_reset_that_does_not_end_is_a_fault_with_its_line(image: Callable[..., Path]) -> None:
    endless = CURRENT.replace(
        "return RESET;", 'while (nameplate->phases) { __asm__ volatile(""); } return 0;'
    )
    fault = run_here(str(image(endless)), scenario_of("paper-5-phase"))
    assert isinstance(fault, Fault)
    assert fault.phase == "reset"
    expected = (
        "the target executes more than 20 million instructions without coming to an end, in drivegate_reset ("
    )
    assert fault.message.startswith(expected), fault.message


M0 = ("-mcpu=cortex-m0plus", "-mthumb", "-nostartfiles")
READ_TWO = 'ldrd%s r2, r3, [%%0]" :: "r"((char *)self + 1) : "r2", "r3", "cc");'
DIVIDE = '*(volatile int *)0xE000ED14 = {}; __asm__ volatile("udiv r2, r2, %0" :: "r"({}) : "r2");'


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("step", "target", "reported"),
    [
        (f'__asm__ volatile("{READ_TWO % ""}', TARGET, "accesses address 60000301h, no multiple of 4, in "),
        # With equal operands, what is for unequal ones is not executed.
        (
            f'__asm__ volatile("cmp %0, %0\\n it eq\\n {READ_TWO % "eq"}',
            TARGET,
            "accesses address 60000301h, no multiple of 4, in ",
        ),
        (f'__asm__ volatile("cmp %0, %0\\n ite eq\\n nopeq\\n {READ_TWO % "ne"}', TARGET, ""),
        ("*(volatile int *)((char *)self + 1) = 1;", TARGET, ""),
        ("*(volatile int *)((char *)self + 2) = 1;", M0, "accesses address 60000302h, no multiple of 4, in "),
        (
            "((volatile short *)((char *)self + 1))[1];",
            M0,
            "accesses address 60000303h, no multiple of 2, in ",
        ),
        ("((volatile char *)self)[1];", M0, ""),
        (DIVIDE.format(16, 0), TARGET, "divides by zero in "),
        (DIVIDE.format(0, 0), TARGET, ""),
        (DIVIDE.format(16, 1), TARGET, ""),
    ],
)
def test_what_the_processor_traps_and_the_emulator_does_not_is_a_fault_with_its_line(
    image: Callable[..., Path], step: str, target: tuple[str, ...], reported: str
) -> None:
    manifest = image(CURRENT, f"if (self->steps == 3) {{ {step} }}", "0", target).with_name("candidate.toml")
    manifest.write_text(
        'schema = 1\nname = "mine"\nkind = "elf"\nentry = "mine.elf"\nram = [[0xE000E000, 0x1000]]\n',
        encoding="utf-8",
    )
    ended = run_here(str(manifest), scenario_of("paper-5-phase"), is_watched=True)
    assert isinstance(ended, Fault) is bool(reported), ended
    if isinstance(ended, Fault):
        assert (ended.kind, ended.phase) == (FaultKind.CRASH, "step")
        assert ended.message.startswith(f"the target {reported}drivegate_step (mine.c line "), ended.message


def test_a_reset_may_refuse_the_run(image: Callable[..., Path]) -> None:
    fault = run(str(image(reset="-7")), scenario_of("paper-5-phase"))
    assert isinstance(fault, Fault)
    assert fault.message == "drivegate_reset returned -7, which refuses the run; 0 is success"


def test_a_manifest_gives_memory_where_peripherals_are_and_a_function_to_start(
    image: Callable[..., Path], tmp_path: Path
) -> None:
    started = "__attribute__((used)) void start(void) { *(volatile int *)0x40012c34 = 5; }"
    image(f"{CURRENT}\n{started}", "if (*(volatile int *)0x40012c34 != 5) command->advance_angle = NAN;")
    manifest = tmp_path / "candidate.toml"
    text = 'schema = 1\nname = "mine"\nkind = "elf"\nentry = "mine.elf"\nram = [[0x40010000, 0x10000]]\n'
    manifest.write_text(text)
    refused = run_here(str(manifest), scenario_of("paper-5-phase"))
    assert isinstance(refused, Fault)
    assert refused.kind is FaultKind.INVALID_OUTPUT
    manifest.write_text(f'{text}start = "start"\n')
    assert not isinstance(run_here(str(manifest), scenario_of("paper-5-phase")), Fault)
    manifest.write_text(f'{text}start = "begin"\n')
    with pytest.raises(InputError, match="mine has no function begin; an image has the functions"):
        run_here(str(manifest), scenario_of("paper-5-phase"))


def test_what_is_no_image_is_refused_in_one_sentence(image: Callable[..., Path], tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"has no function drivegate_abi_version.*\(not with -s\)"):
        run_here(str(image(CURRENT, "", "0", (*TARGET, "-s"))), scenario_of("paper-5-phase"))
    other = tmp_path / "other.elf"
    other.write_bytes(Path("/bin/true").read_bytes())
    with pytest.raises(InputError, match="is no linked image of 32 bits for Arm"):
        resolve_candidate(str(other))
    other.write_text("no image", encoding="utf-8")
    with pytest.raises(InputError, match="is no ELF image; name what the linker wrote"):
        resolve_candidate(str(other))
