"""What native code can do wrong is a verdict or a refusal, never an end of the harness."""

import ctypes
import math
import shutil
from pathlib import Path

import pytest

from drivegate.candidates.fault import CandidateFault, Fault, FaultKind
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate.containment.watches import WorkerLimits
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.record import CurrentRecord
from drivegate.drives.running import run_scenario
from drivegate.studies.simulate import run_once
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.contract.current.signals import Nameplate
from drivegate_models.errors import InputError
from drivegate_models.loop.closed_loop import ClosedLoopRun

NAMEPLATE = Nameplate(
    *(5, 11, 48.0, 52.36, 1500.0, 26.0, 0.0005, 0.25, 0.08, 0.00288, 0.339, 0.05),
    *(1, 2.513, 4.0, 0.576, 0.00417, 157.08),
)
LIMITS = WorkerLimits(step_processor_seconds=0.5, memory_bytes=2**30)
IMPATIENT = WorkerLimits(step_processor_seconds=0.5, start_processor_seconds=2.0, memory_bytes=2**30)
SPIN = "for (volatile int spin = 1; spin;) {}"
FILL = """volatile char *filled = malloc((size_t)10 << 30);
    for (size_t k = 0; k < (size_t)10 << 30; k += 4096) filled[k] = 1;"""


@pytest.fixture(scope="module", autouse=True)
def scenario():
    """A short run, whose kernels are compiled before any worker's time is watched."""
    short = load_scenario("fig5-search").replaced(duration_s=0.25)
    run_scenario(short, load_controller(resolve_candidate("initial")))
    return short


@pytest.fixture
def ended(tmp_path, written, controller_source, scenario):
    """Run a controller in a worker process, as every check does."""

    def run(**parts: str) -> ClosedLoopRun | Fault:
        candidate = resolve_candidate(str(written(tmp_path, controller_source(**parts))))
        limits = IMPATIENT if SPIN in str(parts) else LIMITS
        with Judge(candidate, limits=limits) as worker:
            ended = worker.once(Job(run_once, scenario))
            return ended if isinstance(ended, Fault) else ended.run

    return run


@pytest.fixture
def loaded(tmp_path, written, controller_source):
    """Load a controller into this process."""

    def load(**parts: str):
        return load_controller(resolve_candidate(str(written(tmp_path, controller_source(**parts)))))

    return load


@pytest.mark.nightly
def test_a_controller_without_fault_runs_to_the_end(ended):
    run = ended()
    assert isinstance(run, ClosedLoopRun)
    assert run.steps == 500


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("statement", "kind", "message"),
    [
        ("*(volatile int *)8 = 1;", FaultKind.CRASH, "SIGSEGV (Segmentation fault)"),
        ("abort();", FaultKind.CRASH, "SIGABRT (Aborted)"),
        ("__builtin_trap();", FaultKind.CRASH, "SIGILL (Illegal instruction)"),
        ("exit(3);", FaultKind.CRASH, "ended itself with exit status 3"),
        ("exit(0);", FaultKind.CRASH, "ended itself with exit status 0"),
        (SPIN, FaultKind.HANG, "processor time"),
        (FILL, FaultKind.CRASH, "SIGSEGV"),
    ],
)
def test_a_fault_of_the_process_is_reported_with_its_step(ended, statement, kind, message):
    fault = ended(fifth_step=statement)
    assert (fault.kind, fault.phase) == (kind, "step"), fault
    assert message in fault.message
    assert "completed step" in fault.message
    assert fault.sense["time"] == pytest.approx(4 * 0.0005)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("statement", "kind", "message"),
    [
        ("*(volatile int *)8 = 1;", FaultKind.CRASH, "SIGSEGV (Segmentation fault) in reset"),
        ("exit(3);", FaultKind.CRASH, "ended itself with exit status 3 in reset"),
        ("return 7;", FaultKind.EXCEPTION, "drivegate_reset returned 7, which refuses the run; 0 is success"),
        ("return -1;", FaultKind.EXCEPTION, "drivegate_reset returned -1, which refuses the run"),
        ("return malloc((size_t)10 << 30) ? 0 : 12;", FaultKind.EXCEPTION, "drivegate_reset returned 12"),
        (SPIN, FaultKind.HANG, "in reset"),
    ],
)
def test_a_fault_in_reset_is_reported(ended, statement, kind, message):
    fault = ended(reset=statement)
    assert (fault.kind, fault.phase) == (kind, "reset"), fault
    assert message in fault.message


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("command->current_reference = NAN;", "the command is not finite: current_reference = nan"),
        ("command->current_reference = INFINITY;", "the command is not finite: current_reference = inf"),
        ("command->advance_angle = -INFINITY;", "advance_angle = -inf"),
        ("command->input_power = INFINITY;", "input_power = inf"),
        ("command->struct_size = -1;", "the command's struct_size was overwritten with a negative number"),
        ("memset(command, 0xff, sizeof *command);", "the command's struct_size was overwritten"),
    ],
)
def test_an_invalid_command_is_reported_with_its_inputs(ended, statement, message):
    fault = ended(fifth_step=statement)
    assert (fault.kind, fault.phase, fault.step) == (FaultKind.INVALID_OUTPUT, "step", 4), fault
    assert message in fault.message
    assert fault.time == pytest.approx(4 * 0.0005)
    assert fault.sense["half_supply_voltage"] == 48.0


@pytest.mark.parametrize("size", [0, 10**9])
def test_another_size_of_the_command_changes_nothing(ended, size):
    run = ended(fifth_step=f"command->struct_size = {size};")
    assert run.digest == ended().digest


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("parts", "message"),
    [
        ({"top": "__attribute__((constructor)) static void begin(void) { abort(); }\n"}, "SIGABRT (Aborted)"),
        ({"version": "int64_t drivegate_abi_version(void) { exit(5); }\n"}, "exit status 5"),
        ({"size": f"int64_t drivegate_state_size(void) {{ {SPIN} return 8; }}\n"}, "processor time"),
    ],
)
def test_a_fault_while_loading_is_reported(ended, parts, message):
    fault = ended(**parts)
    assert fault.phase == "loading", fault
    assert message in fault.message
    assert "while loading the candidate" in fault.message


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        (
            {"version": "int64_t drivegate_abi_version(void) { return 2000; }\n"},
            r"mine\.c was built for version 2\.0 of the contract, but this drivegate has version 1\.1; compile it",
        ),
        ({"version": "int64_t drivegate_abi_version(void) { return 999; }\n"}, r"for version 0\.999 of"),
        ({"version": "int64_t drivegate_abi_version(void) { return -1; }\n"}, r"for version -1\.999 of"),
        (
            {"size": "int64_t drivegate_state_size(void) { return -8; }\n"},
            r"mine\.c: drivegate_state_size returned -8, but must return the size of the state in bytes, 0 to 67108864",
        ),
        (
            {"size": "int64_t drivegate_state_size(void) { return 1L << 40; }\n"},
            "returned 1099511627776, but",
        ),
        ({"version": ""}, r"mine\.c does not export drivegate_abi_version; a controller exports"),
        ({"version": "", "size": ""}, "does not export drivegate_abi_version, drivegate_state_size; "),
        ({"top": "static char huge[1L << 36]; void *keep = huge;\n"}, r"mine\.c cannot be loaded: "),
    ],
)
def test_a_library_that_cannot_be_used_is_refused(ended, parts, sentence):
    with pytest.raises(InputError, match=sentence) as caught:
        ended(**parts)
    assert str(caught.value).isprintable()


def test_a_newer_minor_version_is_accepted(loaded):
    loaded(version="int64_t drivegate_abi_version(void) { return 1007; }\n")


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("statement", "check", "column", "clamped"),
    [
        ("command->advance_angle = -0.0174533;", "ADV-2", "advance_deg", 0.0),
        ("command->advance_angle = 1.5882496;", "ADV-2", "advance_deg", 90.0),
        ("command->current_reference = -1.0;", "CMD-1", "current_reference_a", 0.0),
        ("command->current_reference = 100.0;", "CMD-1", "current_reference_a", 26.0),
    ],
)
def test_a_command_out_of_range_fails_its_check_and_is_clamped(
    loaded, scenario, statement, check, column, clamped
):
    run = run_scenario(scenario, loaded(fifth_step=statement), trace_every=1)
    candidate = resolve_candidate("initial")
    margins = {
        m.check: m.value for m in judged(CurrentRecord(scenario, run, candidate.declaration), CHECKS).margins
    }
    assert margins[check] < 0.0
    assert run.trace[4][column] == pytest.approx(clamped)


OF_VERSION_1_0 = """
#include "drivegate.h"
typedef struct { drivegate_nameplate plate; } controller;
int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }
int64_t drivegate_state_size(void) { return sizeof(controller); }
int drivegate_reset(void *state, const drivegate_nameplate *plate) {
    controller *self = state;
    self->plate = *plate;
    if (sizeof(drivegate_nameplate) != 104 || plate->struct_size <= 104) return 2;
    return plate->inertia == 0.05 && plate->phases == 5 ? 0 : 3;
}
void drivegate_step(void *state, const drivegate_sense *sense, drivegate_command *command) {
    controller *self = state;
    command->current_reference = sense->speed < sense->speed_reference ? self->plate.current_limit : 0.0;
    command->advance_angle = 0.0;
}
"""


def test_a_controller_of_the_first_version_goes_on_working(tmp_path, written, scenario):
    # A header beside the source comes before drivegate's own.
    shutil.copy(Path(__file__).with_name("drivegate_1_0.h"), tmp_path / "drivegate.h")
    controller = load_controller(resolve_candidate(str(written(tmp_path, OF_VERSION_1_0))))
    controller.reset(NAMEPLATE)
    assert controller.fault is None
    assert run_scenario(scenario, controller).steps == 500


def test_the_state_is_zeroed_once_and_aligned(loaded):
    controller = loaded(reset="if (self->steps != 0) return 1;")
    assert controller.state_address % 16 == 0
    controller.reset(NAMEPLATE)
    assert controller.fault is None


STEPS_IN_RESET = """int drivegate_reset(void *state, const drivegate_nameplate *nameplate) {
    (void)nameplate;
    return (int)++*(int64_t *)state - 1;
}
"""


def test_the_state_is_not_zeroed_again_so_that_an_incomplete_reset_shows(
    tmp_path, written, controller_source
):
    source = controller_source().replace("int drivegate_reset(", "int unused_reset(") + STEPS_IN_RESET
    candidate = resolve_candidate(str(written(tmp_path, source)))
    controller, another = load_controller(candidate), load_controller(candidate)
    controller.reset(NAMEPLATE)
    with pytest.raises(CandidateFault, match="returned 1"):
        controller.reset(NAMEPLATE)
    another.reset(NAMEPLATE)


GLOBALS = "static double kept[2];\n#define state_of(state) ((state) ? 0 : (controller *)kept)\n"


def test_without_a_state_there_is_one_instance_and_no_address(tmp_path, written, controller_source, scenario):
    source = controller_source(top=GLOBALS, size="int64_t drivegate_state_size(void) { return 0; }\n")
    source = source.replace("controller *self = state;", "controller *self = state_of(state);")
    first, second = (
        resolve_candidate(str(written(tmp_path / name, source.replace("kept", name))))
        for name in ("one", "two")
    )
    controller = load_controller(first)
    assert controller.state_address == 0
    assert load_controller(first) is controller
    assert load_controller(second) is not controller
    assert run_scenario(scenario, controller).steps == 500


ALL_STATIC = """
static int started = 1, runs, table[3] = {1, 2, 3};
static const int *chosen = &table[1];
"""


def test_state_in_global_variables_is_that_of_power_on_at_every_reset(
    tmp_path, written, controller_source, scenario
):
    """Firmware whose variables have initial values, and which never clears them itself."""
    source = controller_source(
        top=GLOBALS + ALL_STATIC,
        size="int64_t drivegate_state_size(void) { return 0; }\n",
        reset="if (!started || runs++ || chosen != &table[1] || table[0]++ != 1) return 9;\nstarted = 0; chosen = 0;",
    )
    source = source.replace("controller *self = state;", "controller *self = state_of(state);")
    controller = load_controller(resolve_candidate(str(written(tmp_path / "one", source))))
    assert [run_scenario(scenario, controller).steps for _ in range(2)] == [500, 500]


def test_more_global_variables_than_a_state_may_have_are_refused(tmp_path, written, controller_source):
    source = controller_source(
        top=GLOBALS + "char huge[65 << 20];\n", size="int64_t drivegate_state_size(void) { return 0; }\n"
    )
    source = source.replace("controller *self = state;", "controller *self = state_of(state);")
    with pytest.raises(InputError, match=r"bytes of global variables, but a state may have at most 67108864"):
        load_controller(resolve_candidate(str(written(tmp_path / "one", source))))


SET_ROUNDING = (
    "#include <fenv.h>\n__attribute__((constructor)) static void begin(void) { fesetround(FE_UPWARD); }\n"
)


def test_what_a_library_does_to_the_rounding_is_undone(loaded, monkeypatch):
    rounding = ctypes.CDLL(None).fegetround
    before = rounding()
    controller = loaded(top=SET_ROUNDING, reset="fesetround(FE_TOWARDZERO);")
    assert rounding() == before
    controller.reset(NAMEPLATE)
    assert rounding() == before
    assert math.fsum([0.1] * 10) == 1.0


def test_the_command_line_states_where_the_header_is(capsys):
    from drivegate.candidates.native.compiler import include_folder
    from drivegate.commands.command_line import main

    with pytest.raises(SystemExit) as ended:
        main(["include-dir"])
    assert ended.value.code == 0
    assert capsys.readouterr().out == f"{include_folder()}\n"


def test_what_does_not_compile_ends_with_exit_code_2_without_a_traceback(tmp_path, written, capsys):
    from drivegate.commands.command_line import main

    file = written(tmp_path, "int x = y;\n")
    with pytest.raises(SystemExit) as ended:
        main(["simulate", str(file), "--case", "fig5-search"])
    assert ended.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: mine.c, line 1: 'y' undeclared here")
