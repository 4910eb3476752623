"""What a candidate may try against the process that judges it, row by row of the table in docs/containment.md."""

import os
import tempfile
from dataclasses import replace
from pathlib import Path
from textwrap import indent

import pytest

from drivegate.candidates.contract import other_contract
from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate.containment.protocol import _HEADER, WORD, Ending
from drivegate.containment.watches import WorkerLimits
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError

LIMITS = WorkerLimits(step_processor_seconds=0.5, start_processor_seconds=20.0, idle_seconds=20.0)
SCENARIO = fixed_scenarios(load_drive("paper-5-phase"))[0].model_copy(update={"duration_s": 1.0})

CANDIDATE = """
import ctypes, gc, inspect, mmap, os, pickle, socket, struct, sys, threading, time
import numpy as np
from drivegate import Command
def connection():
    for name in os.listdir("/proc/self/fd"):
        try:
            found = socket.socket(fileno=os.dup(int(name)))
        except OSError:
            continue
        if found.family == socket.AF_UNIX and found.type == socket.SOCK_SEQPACKET:
            return found
def shared():
    for frame in frames():
        for value in frame.f_locals.values():
            if type(value).__name__ == "SharedMemory":
                return value
def frames():
    frame = sys._getframe()
    while frame is not None:
        yield frame
        frame = frame.f_back
{top}
class Mine:
    def __del__(self):
{deletion}
    def reset(self, nameplate):
        self.count = 0
    def step(self, sense):
        self.count += 1
        if self.count == 5:
{step}
        return Command(3.0, 0.5)
"""


@pytest.fixture(autouse=True)
def nothing_left(monkeypatch, tmp_path, no_process_left):
    """Hold the tests to leaving no file, no process and no shared memory behind."""
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(scratch))
    yield
    assert list(scratch.iterdir()) == [], "a temporary file is left"
    assert list(Path("/dev/shm").glob("*left-*")) == [], "shared memory is left"


def digest_of(loaded, scenario):
    return recorded(loaded, scenario, loaded.controller()).run.digest


def margins_of(loaded, scenario):
    return judged(recorded(loaded, scenario, loaded.controller()), CHECKS).margins


def digests_of_two(loaded, scenario):
    return [recorded(loaded, scenario, loaded.controller()).run.digest for _ in range(2)]


@pytest.fixture
def attempt(tmp_path):
    """Run a candidate that does something in its fifth step, when it is imported, or when it is deleted."""

    def made(step="pass", *, top="pass", deletion="pass", target=digest_of, limits=LIMITS):
        file = tmp_path / "mine.py"
        file.write_text(
            CANDIDATE.format(
                top=top, deletion=indent(deletion.strip(), " " * 8), step=indent(step.strip(), " " * 12)
            ),
            encoding="utf-8",
        )
        with Judge(resolve_candidate(f"{file}:Mine"), limits=limits) as judge:
            return judge.once(Job(target, SCENARIO))

    return made


@pytest.fixture
def honest(attempt):
    return attempt()


REPLACED = """
import drivegate.contracts.current.checks.catalogue as catalogue, drivegate.checks.check as judging
import drivegate.containment.serving as serving, drivegate.contracts.current.run as runs
from drivegate.checks.margin import Margin
judging.judged = lambda record, checks: judging.JudgedRun({}, tuple(Margin(c.id, 1.0, "fine") for c in checks))
for check in catalogue.CHECKS:
    object.__setattr__(check, "evaluate", lambda record, check=check: Margin(check.id, 1.0, "fine"))
"""


@pytest.mark.nightly
def test_a_candidate_that_replaces_the_checks_is_judged_all_the_same(attempt):
    plain, forged = attempt(target=margins_of), attempt(top=REPLACED, target=margins_of)
    assert [margin for margin in forged if margin.check != "TIM-1"] == [
        margin for margin in plain if margin.check != "TIM-1"
    ]
    assert not all(margin.met for margin in forged), "a constant command meets no check of convergence"


PICKLE = """
class Evil:
    def __reduce__(self):
        return (open, ({mark!r}, "w"))
connection().send(pickle.dumps(Evil()))
"""


def test_a_pickle_is_not_read(attempt, tmp_path):
    mark = tmp_path / "run by the harness"
    fault = attempt(PICKLE.format(mark=str(mark)))
    assert isinstance(fault, Fault)
    assert (fault.kind, "wrote into its connection" in fault.message) == (FaultKind.CRASH, True), (
        fault.message
    )
    assert not mark.exists(), "code of the candidate ran in the harness"


@pytest.mark.parametrize(
    "packet",
    [
        'b"x"',
        'b"drivegat" + bytes(10)',
        'b"\\xff" * 150_000',
        'struct.pack("=8s5q16s", b"drivegat", 9, 0, 0, 0, 0, b"")',
    ],
    ids=["short", "half", "huge", "of no known ending"],
)
def test_a_packet_of_another_form_is_a_crash(attempt, packet):
    fault = attempt(f"connection().send({packet})")
    assert isinstance(fault, Fault)
    assert fault.kind is FaultKind.CRASH, fault


def test_a_reply_that_says_all_went_well_does_not_make_it_so(attempt, honest):
    said = 'struct.pack("=8sqqqqq16s", b"drivegat", 0, 0, {steps}, 0, 0, b"")'
    steps = SCENARIO.control_periods
    fault = attempt(f"connection().send({said.format(steps=steps)})")
    assert isinstance(fault, Fault), "commands that were never given were taken for an answer"
    assert fault.kind in (FaultKind.MEMORY, FaultKind.CRASH)


def test_commands_written_over_are_what_is_judged(attempt, honest):
    fault = attempt("shared().commands()['current_reference'][:4] = 9.0")
    assert isinstance(fault, Fault)
    assert fault.kind is FaultKind.MEMORY, "the plant there has had other commands than are kept"


SERVER = "[f.f_locals['self'] for f in frames() if type(f.f_locals.get('self')).__name__ == '_Server'][0]"


def test_counters_written_over_do_no_harm(attempt, honest):
    assert attempt(f"{SERVER}._progress.steps[0] = -(2**60); {SERVER}._progress.enter(77)") == honest


@pytest.mark.parametrize(
    "step",
    [
        'connection().send(struct.pack("=8sqqqqq16s", b"drivegat", 3, 0, 0, 0, 0, b"") + b"forged")',
        f"{SERVER}._progress.enter(0); os._exit(3)",
        f"{SERVER}._progress.enter(0); time.sleep(1e6)",
    ],
    ids=["forged breakdown", "end as before the start", "hang as before the start"],
)
def test_nothing_of_a_candidate_is_a_fault_of_the_harness(attempt, step):
    fault = attempt(step, limits=replace(LIMITS, idle_seconds=4.0))
    assert isinstance(fault, Fault), fault
    assert fault.kind in (FaultKind.CRASH, FaultKind.HANG), fault


FORGED_REFUSAL = f'struct.pack({_HEADER.format!r}, {WORD!r}, {Ending.REFUSED:d}, *[0] * 7, b"")'
"""An expression for the beginning of a reply; what follows is its text."""


@pytest.mark.parametrize("text", ["in a stranger's words", other_contract("duty", "current")])
def test_a_refusal_that_is_forged_in_a_run_is_a_crash(attempt, text):
    """Believed, it would end the check without a report, and in the candidate's own words."""
    forged = f"connection().send({FORGED_REFUSAL} + {text.encode()!r})"
    fault = attempt(step=forged)
    assert isinstance(fault, Fault)
    assert fault.kind is FaultKind.CRASH
    assert "wrote into its connection" in fault.message


def test_a_refusal_that_is_forged_while_loading_is_shown_as_the_candidates(attempt):
    with pytest.raises(InputError) as refused:
        attempt(
            top=f"connection().send({FORGED_REFUSAL} + b'all passed\\x1b[2K' + b'!' * 30_000); time.sleep(60)"
        )
    said = str(refused.value)
    assert said.startswith("all passed")
    assert said.endswith("(reported by the candidate's process)")
    assert "\x1b" not in said
    assert len(said) < 30_000


def test_what_breaks_drivegates_own_code_while_loading_is_the_candidates_fault(attempt):
    fault = attempt(
        top="import drivegate.candidates.python.loading as l; l.PythonController = None; l.exception_fault = None"
    )
    assert isinstance(fault, Fault), fault
    assert (fault.kind, fault.phase) == (FaultKind.CRASH, "loading"), fault


CHANGED_PLANT = """
from dataclasses import replace
import drivegate_models.half_bridge.closed_loop as there
prepared = there.prepared_loop
def easier(inputs, controller, restarts):
    drive = inputs.drive._replace(inertia=100.0 * inputs.drive.inertia)
    return prepared(replace(inputs, drive=drive), controller, restarts)
there.prepared_loop = easier
"""


def test_another_plant_in_the_candidates_process_is_noticed(attempt):
    fault = attempt(top=CHANGED_PLANT)
    assert isinstance(fault, Fault)
    assert fault.kind is FaultKind.MEMORY, fault.message


def test_shared_memory_cannot_be_made_smaller(attempt, honest):
    shrink = """
for name in os.listdir("/proc/self/fd"):
    try:
        os.ftruncate(int(name), 0)
    except OSError:
        pass
for place in os.listdir("/proc/self/map_files") if os.path.isdir("/proc/self/map_files") else ():
    try:
        with open("/proc/self/map_files/" + place, "r+b") as file:
            if "drivegate" in os.readlink("/proc/self/map_files/" + place):
                os.ftruncate(file.fileno(), 0)
    except OSError:
        pass
"""
    assert attempt(shrink) == honest


def test_a_closed_connection_is_a_crash(attempt):
    fault = attempt("os.closerange(3, 64)")
    assert isinstance(fault, Fault)
    assert fault.kind is FaultKind.CRASH


def test_endless_deletion_is_a_hang(attempt):
    fault = attempt(deletion="while True: pass", target=digests_of_two)
    assert isinstance(fault, Fault)
    assert fault.kind is FaultKind.HANG
    assert fault.message == "no progress within 0.5 s of processor time in the deletion of an instance", fault


@pytest.mark.parametrize(
    "top",
    [
        "import atexit; atexit.register(time.sleep, 1e6)",
        "threading.Thread(target=time.sleep, args=(1e6,)).start()",
        "import signal; [signal.signal(n, signal.SIG_IGN) for n in (2, 15, 10)]",
    ],
    ids=["exit handler", "thread", "ignored signals"],
)
def test_what_does_not_end_by_itself_is_ended(attempt, honest, top):
    assert attempt(top=top) == honest


def test_folder_limits_and_environment_are_changed_for_itself_alone(attempt, honest):
    before = (Path.cwd(), dict(os.environ))
    top = (
        "import resource; os.chdir('/'); os.environ.clear(); "
        "resource.setrlimit(resource.RLIMIT_NOFILE, (16, 16)); resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))"
    )
    ended = attempt(top=top)
    assert ended == honest or (isinstance(ended, Fault) and ended.kind is FaultKind.CRASH)
    assert (Path.cwd(), dict(os.environ)) == before


@pytest.mark.parametrize("value", ["1.7e308", "-1.7e308", "5e-324", "1e200", "-0.0"])
@pytest.mark.parametrize("field", ["current_reference", "advance_angle", "input_power"])
def test_extreme_but_finite_commands_are_judged(attempt, field, value):
    fields = {"current_reference": "3.0", "advance_angle": "0.5", "input_power": "100.0"} | {field: value}
    answer = ", ".join(f"{name}={given}" for name, given in fields.items())
    margins = attempt(f"return Command({answer})", target=margins_of)
    assert not isinstance(margins, Fault), margins


def test_semaphores_and_shared_memory_go_with_the_candidate(attempt, honest):
    top = (
        "from multiprocessing import shared_memory, resource_tracker; import _multiprocessing as m\n"
        "block = shared_memory.SharedMemory(create=True, size=4096, name=f'left-{os.getpid()}')\n"
        "resource_tracker.unregister(block._name, 'shared_memory')\n"
        "m.SemLock(1, 1, 1, f'/left-{os.getpid()}', False)"
    )
    assert attempt(top=top) == honest


LOOKING = """
secrets = {"Scenario", "Conditions", "Course", "Profile", "Dwell", "Check", "Timing", "SpeedRange"}
found = {type(thing).__name__ for thing in gc.get_objects()} & secrets
found |= {type(part).__name__ for thing in gc.get_objects() if type(thing) is tuple for part in thing} & secrets
names = set()
for frame in [*frames(), *sys._current_frames().values()]:
    for name, value in frame.f_locals.items():
        if frame.f_code.co_name == "step":
            continue
        names.add(type(value).__name__)
        if isinstance(value, (tuple, list)):
            names |= {type(part).__name__ for part in value}
        if isinstance(value, bytes) and len(value) > 200:
            found.add("bytes")
found |= names & secrets
text = open("/proc/self/cmdline").read() + open("/proc/self/environ").read()
if "scenario" in text or "seed" in text:
    found.add("command line")
raise LookupError(f"found {sorted(found)}")
"""


def test_what_is_to_come_is_in_no_variable_and_no_object(attempt):
    fault = attempt(LOOKING)
    assert isinstance(fault, Fault)
    assert fault.message == "LookupError: found []", fault.message


def test_a_profiler_does_not_see_an_order_taken_apart(attempt):
    top = (
        "seen = set()\n"
        "def look(frame, event, what): seen.update(type(v).__name__ for v in frame.f_locals.values())\n"
        "sys.setprofile(look); threading.setprofile(look); sys.settrace(lambda *a: look(*a))"
    )
    step = "raise LookupError(f\"found {sorted(seen & {'Conditions', 'CloseLoop', 'CurrentLoopInputs', 'Load'})}\")"
    fault = attempt(step, top=top)
    assert isinstance(fault, Fault)
    assert fault.message == "LookupError: found []", fault.message


def test_whoever_kills_the_judge_does_not_pass(tmp_path, not_isolated):
    from drivegate.containment.pool import WorkerPool

    kill = """
parents, pid = {}, os.getpid()
while pid > 1:
    pid = int(open(f"/proc/{pid}/stat").read().rpartition(")")[2].split()[1])
    if b"judge" in open(f"/proc/{pid}/cmdline", "rb").read().split(bytes(1)):
        os.kill(pid, 9)
        break
time.sleep(30)
"""
    file = tmp_path / "mine.py"
    file.write_text(
        CANDIDATE.format(top="pass", deletion="        pass", step=indent(kill.strip(), " " * 12))
    )
    with WorkerPool(resolve_candidate(f"{file}:Mine"), workers=1, limits=LIMITS) as pool:
        (ended,) = pool.map([Job(digest_of, SCENARIO)])
    assert isinstance(ended, Fault)
    assert ended.kind is FaultKind.CRASH, ended
