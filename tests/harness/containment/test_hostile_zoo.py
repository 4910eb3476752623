"""Candidates that do harm: each gets its verdict and a clear message, and leaves nothing behind."""

import json
import os
import re
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from textwrap import indent
from xml.etree import ElementTree

import pytest
from tests.harness import worker_jobs
from tests.harness.beside_templates import connections, copies

from drivegate.candidates.fault import LONGEST_MESSAGE, LONGEST_TRACEBACK, Fault, FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.commands.command_line import main
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate.containment.pool import WorkerPool
from drivegate.containment.watches import WorkerLimits
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.gate import engine
from drivegate.gate.plan import REPEATED, planned_work
from drivegate.gate.repetition import repeated_elsewhere
from drivegate.gate.shard import FixedRuns, run_fixed
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError

LIMITS = WorkerLimits(
    step_processor_seconds=0.3, start_processor_seconds=30.0, idle_seconds=30.0, memory_bytes=2**30
)
IMPATIENT = replace(LIMITS, idle_seconds=4.0)
HURRIED = replace(LIMITS, start_processor_seconds=2.0)
STEPS = 7
"""Steps of a run; what a candidate does to the harness it does in the fifth."""

PYTHON = """
import ctypes, math, os, resource, signal, socket, subprocess, sys, tempfile, threading, time
from drivegate import Command
{top}
class Mine:
    def reset(self, nameplate):
        self.count = 0
{reset}
    def step(self, sense):
        self.count += 1
        if self.count == 5:
{step}
        return Command(1.0, 0.5)
"""

PROGRAM = """
import json, os, signal, subprocess, sys, time
count = 0
def say(**answer):
    print(json.dumps(answer), flush=True)
for line in sys.stdin:
    message = json.loads(line)
    if "sense" in message:
        count += 1
        if count == 5:
{step}
        say(current_reference=1.0, advance_angle=0.5)
    elif "reset" in message:
{reset}
        say(ready=True)
    else:
{hello}
        say(drivegate=1)
"""

CLOSE_EVERYTHING = "os.closerange(0, 4096)"
WRITE_EVERYWHERE = """
for descriptor in map(int, os.listdir("/proc/self/fd")):
    try: os.write(descriptor, b"garbage" * 100)
    except OSError: pass
"""
OPEN_INSTEAD = "os.closerange(0, 4096); files = [open('/dev/zero', 'r+b', buffering=0) for _ in range(20)]"
# Their own in each process that runs tests, since others may run these tests beside it.
SLEEP = f"sleep {10**9 + os.getpid()}"
DAEMON = f"subprocess.Popen(['setsid', 'sh', '-c', '{SLEEP} & {SLEEP}'], env={{}}, start_new_session=True)"
COPIES = "os.fork(); os.fork()"
LEFTOVERS = """
folder = tempfile.mkdtemp()
open(folder + "/left", "w").close()
os.mkdir(folder + "/locked"); open(folder + "/locked/in", "w").close(); os.chmod(folder + "/locked", 0)
os.symlink("/", folder + "/root")
"""
HUGE_TEXT = "raise ValueError('<script>alert(1)</script>\\x1b[31m\\x07\\0[bold]' + 'x' * 2**20)"

# What the candidate does (in a step unless another place is named), the verdict, and how its message begins.
IN_PYTHON = {
    "segfault": ("ctypes.string_at(0)", FaultKind.CRASH, "the process was killed by SIGSEGV"),
    "abort": ("os.abort()", FaultKind.CRASH, "the process was killed by SIGABRT"),
    "endless loop": (
        "while True: pass",
        FaultKind.HANG,
        "no progress within 0.3 s of processor time after 4",
    ),
    "endless sleep": (
        "time.sleep(1e6)",
        FaultKind.HANG,
        "no progress within 4 s of waiting after 4 completed steps",
    ),
    "stops itself": (
        "os.kill(os.getpid(), signal.SIGSTOP)",
        FaultKind.HANG,
        "no progress within 4 s of waiting after 4",
    ),
    "ten gigabytes": (
        "bytearray(10 * 2**30)",
        FaultKind.EXCEPTION,
        "MemoryError (a candidate may allocate 1 GiB)",
    ),
    "nan": (
        "return Command(math.nan, 0.0)",
        FaultKind.INVALID_OUTPUT,
        "current_reference is nan, but must be finite",
    ),
    "infinity": (
        "return Command(0.0, -math.inf)",
        FaultKind.INVALID_OUTPUT,
        "advance_angle is -inf, but must be",
    ),
    "infinite power": (
        "return Command(0.0, 0.0, math.inf)",
        FaultKind.INVALID_OUTPUT,
        "input_power is inf, but must be finite, or NaN for no estimate",
    ),
    "wrong type": (
        "return [1.0, 0.5]",
        FaultKind.INVALID_OUTPUT,
        "step returned an object of type list, but must",
    ),
    "sys.exit": ("sys.exit('enough')", FaultKind.EXCEPTION, "SystemExit: enough"),
    "os._exit": (
        "os._exit(3)",
        FaultKind.CRASH,
        "the process ended itself with exit status 3 after 4 completed",
    ),
    "interrupt": ("raise KeyboardInterrupt", FaultKind.EXCEPTION, "KeyboardInterrupt"),
    "terminates itself": (
        "os.kill(os.getpid(), signal.SIGTERM)",
        FaultKind.CRASH,
        "the process was killed by SIGTERM",
    ),
    "kills its keeper": (
        "os.kill(os.getppid(), signal.SIGKILL); time.sleep(9)",
        FaultKind.CRASH,
        "the process was killed by SIGKILL",
    ),
    "huge hostile text": (HUGE_TEXT, FaultKind.EXCEPTION, "ValueError: <script>alert(1)</script>\\x1b[31m"),
    "exception that cannot be reported": (
        "raise type('Unspeakable', (Exception,), {'__str__': lambda self: 1 / 0})",
        FaultKind.EXCEPTION,
        "Unspeakable: (its text cannot be had: ZeroDivisionError)",
    ),
    "closes every descriptor": (
        CLOSE_EVERYTHING,
        FaultKind.CRASH,
        "the process closed its connection to the harness; a candidate must leave alone what it has not opened",
    ),
    "opens files in place of its descriptors": (
        OPEN_INSTEAD,
        FaultKind.CRASH,
        "the process closed its connection",
    ),
    "writes into every descriptor": (
        WRITE_EVERYWHERE,
        FaultKind.CRASH,
        "the process wrote into its connection to the harness",
    ),
    "ends a thread badly": (
        "threading.Thread(target=os.abort).start(); time.sleep(9)",
        FaultKind.CRASH,
        "the process was killed by SIGABRT",
    ),
}

HARMLESS = {
    "prints megabytes": "for _ in range(3000): print('x' * 1000); os.write(2, b'\\xff\\x1b[2J' * 200)",
    "closes its streams": "[os.close(number) for number in (0, 1, 2)]",
    "closes its Python streams": "sys.stdin.close(); sys.stdout.close(); sys.stderr.close()",
    "forks a process that outlives it": f"subprocess.Popen({SLEEP.split()})",
    "forks a daemon": DAEMON,
    "forks copies of itself": COPIES,
    "leaves files": LEFTOVERS,
    "ignores signals": "[signal.signal(number, signal.SIG_IGN) for number in (1, 2, 13, 15)]",
    "moves away": "os.chdir('/')",
    "leaves a thread": "threading.Thread(target=time.sleep, args=(1e6,), daemon=False).start()",
    "changes its environment": "os.environ.clear(); sys.path.clear(); sys.modules.pop('pickle', None)",
}

ELSEWHERE = {
    "loop in import": (
        {"top": "while True: pass"},
        FaultKind.HANG,
        "loading",
        "no progress within 2 s of processor time while loading",
    ),
    "loop in reset": (
        {"reset": "while True: pass"},
        FaultKind.HANG,
        "reset",
        "no progress within 2 s of processor time in reset",
    ),
    "exit in import": ({"top": "sys.exit(0)"}, FaultKind.EXCEPTION, "loading", "SystemExit: 0"),
    "end in import": (
        {"top": "os._exit(0)"},
        FaultKind.CRASH,
        "loading",
        "the process ended itself with exit",
    ),
    "segfault in import": (
        {"top": "ctypes.string_at(0)"},
        FaultKind.CRASH,
        "loading",
        "the process was killed by",
    ),
    "close in import": (
        {"top": CLOSE_EVERYTHING},
        FaultKind.CRASH,
        "loading",
        "the process closed its connection to the harness",
    ),
    "daemon in import": (
        {"top": f"{DAEMON}; os._exit(1)"},
        FaultKind.CRASH,
        "loading",
        "the process ended itself",
    ),
    "segfault in reset": (
        {"reset": "ctypes.string_at(0)"},
        FaultKind.CRASH,
        "reset",
        "the process was killed by",
    ),
}

PROGRAM_DEADLINE = 0.4
"""Time that a program has for a step which it does not end (s)."""
PATIENT_DEADLINE = 4.0
"""Time that it has for any other, on a busy machine too; what it leaves behind may use it up (s)."""
IN_PROGRAM = {
    "late": ("time.sleep(9)", FaultKind.HANG, "the program gave no answer within 0.4 s"),
    "endless loop": ("while True: pass", FaultKind.HANG, "the program gave no answer within 0.4 s"),
    "half a line": (
        "print('{\"current_', end='', flush=True); time.sleep(9)",
        FaultKind.HANG,
        "the program wrote only a part of a line within 0.4 s",
    ),
    "half a line, then the end": (
        "print('{\"current_', end='', flush=True); os._exit(0)",
        FaultKind.CRASH,
        "the program ended itself with exit status 0 in the middle of a line",
    ),
    "garbage": (
        "print('garbage', flush=True); continue",
        FaultKind.INVALID_OUTPUT,
        "the answer 'garbage' is not JSON",
    ),
    "bytes": (
        "os.write(1, b'\\xff\\x00\\n'); continue",
        FaultKind.INVALID_OUTPUT,
        "the answer '\\xff\\x00' is not UTF-8 at byte 1, but must be JSON",
    ),
    "deep": ("print('[' * 60000, flush=True); continue", FaultKind.INVALID_OUTPUT, "the answer '[[[["),
    "blank line": ("print(flush=True); continue", FaultKind.INVALID_OUTPUT, "the answer '' is not JSON"),
    "list": (
        "print('[1]', flush=True); continue",
        FaultKind.INVALID_OUTPUT,
        "the answer '[1]' is not a JSON object",
    ),
    "nan": (
        "say(current_reference=float('nan'), advance_angle=0.5); continue",
        FaultKind.INVALID_OUTPUT,
        'the answer \'{"current_reference": NaN, "advance_angle": 0.5}\' holds NaN, which JSON does not have',
    ),
    "infinity": (
        "say(current_reference=1.0, advance_angle=-1e999); continue",
        FaultKind.INVALID_OUTPUT,
        "the answer '",
    ),
    "overflow": (
        'print(\'{"current_reference": 1e999, "advance_angle": 0}\', flush=True); continue',
        FaultKind.INVALID_OUTPUT,
        "current_reference is inf, but must be finite",
    ),
    "huge integer": (
        "say(current_reference=10**400, advance_angle=0); continue",
        FaultKind.INVALID_OUTPUT,
        "'current_reference' is an integer of 1329 bits, which is too large for a 64-bit float",
    ),
    "wrong type": (
        "say(current_reference='1.0', advance_angle=0.5); continue",
        FaultKind.INVALID_OUTPUT,
        "'current_reference' is \"1.0\", but must be a number",
    ),
    "true": (
        "say(current_reference=1.0, advance_angle=True); continue",
        FaultKind.INVALID_OUTPUT,
        "'advance_angle' is true, but must be a number",
    ),
    "missing key": (
        "say(current_reference=1.0); continue",
        FaultKind.INVALID_OUTPUT,
        "the answer '{\"current_reference\": 1.0}' has no key 'advance_angle'",
    ),
    "unknown key": (
        "say(current_reference=1.0, advance_angle=0.5, input_powr=1.0); continue",
        FaultKind.INVALID_OUTPUT,
        "the answer has the unknown key \"input_powr\"; the nearest known one is 'input_power'",
    ),
    "two lines": (
        "say(current_reference=1.0, advance_angle=0.5)",
        FaultKind.INVALID_OUTPUT,
        "the program ",
    ),
    "two lines, and late from then on": (
        "say(current_reference=1.0, advance_angle=0.5); plain = say\n"
        "def say(**answer): time.sleep(0.005); plain(**answer)",
        FaultKind.INVALID_OUTPUT,
        "the program ",
    ),
    "endless line": (
        "[os.write(1, b'x' * 4096) for _ in range(10**6)]",
        FaultKind.INVALID_OUTPUT,
        "the answer is longer than 65536 bytes",
    ),
    "end": ("sys.exit(3)", FaultKind.CRASH, "the program ended itself with exit status 3"),
    "exception": ("1 / 0", FaultKind.CRASH, "the program ended itself with exit status 1"),
    "signal": ("os.kill(os.getpid(), signal.SIGSEGV)", FaultKind.CRASH, "the program was killed by SIGSEGV"),
    "stop": (
        "os.kill(os.getpid(), signal.SIGSTOP)",
        FaultKind.HANG,
        "the program gave no answer within 0.4 s",
    ),
    "closes its output": (
        "os.close(1); time.sleep(9)",
        FaultKind.INVALID_OUTPUT,
        "the program closed its standard output",
    ),
    "ten gigabytes": (
        "bytearray(10 * 2**30)",
        FaultKind.CRASH,
        "the program ended itself with exit status 1",
    ),
    "kills its parent": (
        "os.kill(os.getppid(), signal.SIGKILL); time.sleep(9)",
        FaultKind.CRASH,
        "the process was killed by SIGKILL",
    ),
    "daemon": (f"{DAEMON}; sys.exit(1)", FaultKind.CRASH, "the program ended itself with exit status 1"),
}


def processes_of(scratch: Path) -> list[str]:
    """Find processes whose temporary folder is in the scratch folder, as that of every worker is, and copies."""
    mark = f"TMPDIR={scratch}/".encode()
    found = [f"copy {number}" for number in copies()]
    for place in Path("/proc").glob("[0-9]*"):
        try:
            command = (place / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
            if mark in (place / "environ").read_bytes() or SLEEP in command:
                found.append(command)
        except OSError:
            continue
    return found


@pytest.fixture(autouse=True)
def scratch(monkeypatch, tmp_path, no_process_left):
    """Hold every candidate to leaving neither processes nor files nor open descriptors."""
    folder = tmp_path / "scratch"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    connections_before = set(connections())
    yield folder
    assert processes_of(folder) == [], "a process outlived its worker"
    assert list(folder.iterdir()) == [], "a temporary file is left"
    assert set(connections()) <= connections_before, "a connection to a worker is left open"


@pytest.fixture
def python_candidate(tmp_path):
    """Make a Python candidate that does something particular at one place."""

    def make(step="pass", *, reset="pass", top="pass"):
        file = tmp_path / "mine.py"
        source = PYTHON.format(top=top, reset=indent(reset, " " * 8), step=indent(step.strip(), " " * 12))
        file.write_text(source, encoding="utf-8")
        return resolve_candidate(f"{file}:Mine")

    return make


@pytest.fixture
def program(tmp_path):
    """Make a program that does something particular at one place."""

    def make(step="pass", *, reset="pass", hello="pass", deadline=PATIENT_DEADLINE):
        places = {
            "step": indent(step, " " * 12),
            "reset": indent(reset, " " * 8),
            "hello": indent(hello, " " * 8),
        }
        (tmp_path / "mine.py").write_text(PROGRAM.format(**places), encoding="utf-8")
        (tmp_path / "candidate.toml").write_text(
            f'schema = 1\nname = "mine"\nkind = "exec"\nentry = "{sys.executable} mine.py"\n'
            f"step_deadline_s = {deadline}\n",
            encoding="utf-8",
        )
        return resolve_candidate(str(tmp_path / "candidate.toml"))

    return make


def outcome_of(candidate, limits=LIMITS):
    with Judge(candidate, limits=limits) as worker:
        # Once: test_judge.py shows that a hang is tried again.
        return worker.once(Job(worker_jobs.drive, STEPS))


def assert_well_reported(fault):
    assert isinstance(fault, Fault), f"the candidate was taken for a good one: {fault}"
    assert fault.message.isprintable()
    assert len(fault.message) <= LONGEST_MESSAGE
    assert len(fault.traceback) <= LONGEST_TRACEBACK
    assert fault.traceback.replace("\n", "").isprintable()


@pytest.mark.one_in(3)
@pytest.mark.parametrize("harm", IN_PYTHON)
def test_harm_in_a_step_of_a_python_candidate(python_candidate, harm):
    statement, kind, message = IN_PYTHON[harm]
    limits = IMPATIENT if "of waiting" in message else LIMITS
    fault = outcome_of(python_candidate(statement), limits)
    assert_well_reported(fault)
    assert (fault.kind, fault.phase) == (kind, "step")
    assert fault.message.startswith(message)


@pytest.mark.parametrize("harm", ELSEWHERE)
def test_harm_before_the_first_step_of_a_python_candidate(python_candidate, harm):
    places, kind, phase, message = ELSEWHERE[harm]
    fault = outcome_of(python_candidate(**places), HURRIED if kind is FaultKind.HANG else LIMITS)
    assert_well_reported(fault)
    assert (fault.kind, fault.phase) == (kind, phase)
    assert fault.message.startswith(message)


@pytest.mark.parametrize("mischief", HARMLESS)
def test_mischief_that_is_no_harm_does_not_reach_the_harness(python_candidate, mischief, capfd):
    assert outcome_of(python_candidate(HARMLESS[mischief])) == float(STEPS)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("method", ["reset", "step"])
def test_a_candidate_without_a_method_is_refused(tmp_path, method):
    file = tmp_path / "mine.py"
    other = {"reset": "step", "step": "reset"}[method]
    file.write_text(f"class Mine:\n def {other}(self, sense): pass\n", encoding="utf-8")
    with pytest.raises(InputError, match=f"the class 'Mine' in mine.py has no method '{method}'"):
        outcome_of(resolve_candidate(f"{file}:Mine"))


@pytest.mark.one_in(4)
@pytest.mark.parametrize("harm", IN_PROGRAM)
def test_harm_in_a_step_of_a_program(program, harm):
    statement, kind, message = IN_PROGRAM[harm]
    deadline = PROGRAM_DEADLINE if kind is FaultKind.HANG else PATIENT_DEADLINE
    fault = outcome_of(program(statement, deadline=deadline))
    assert_well_reported(fault)
    assert (fault.kind, fault.phase) == (kind, "step")
    assert fault.message.startswith(message)
    assert fault.sense["phase_currents"] == (1.0,) * 5


@pytest.mark.parametrize(
    ("places", "kind", "phase", "message"),
    [
        (
            {"hello": "sys.exit('no licence')"},
            FaultKind.CRASH,
            "loading",
            "the program ended itself with exit status 1",
        ),
        ({"hello": "print('Welcome!')"}, FaultKind.INVALID_OUTPUT, "loading", "the "),
        (
            {"hello": "say(drivegate='1'); continue"},
            FaultKind.INVALID_OUTPUT,
            "loading",
            "'drivegate' is \"1\", but",
        ),
        (
            {"hello": "say(name='x'); continue"},
            FaultKind.INVALID_OUTPUT,
            "loading",
            'the answer \'{"name": "x"}\' has',
        ),
        ({"reset": "sys.exit(4)"}, FaultKind.CRASH, "reset", "the program ended itself with exit status 4"),
        (
            {"reset": "say(ready=False); continue"},
            FaultKind.INVALID_OUTPUT,
            "reset",
            "'ready' is false, but must be true",
        ),
    ],
)
def test_harm_before_the_first_step_of_a_program(program, places, kind, phase, message):
    fault = outcome_of(program(**places))
    assert_well_reported(fault)
    assert (fault.kind, fault.phase) == (kind, phase)
    assert fault.message.startswith(message)


def test_what_a_program_printed_is_reported_with_its_fault(program):
    chatter = "print('x' * 10**6, '\\x1b[31mno such table', file=sys.stderr, flush=True); sys.exit(3)"
    fault = outcome_of(program(chatter))
    assert_well_reported(fault)
    assert fault.traceback.endswith("\\x1b[31mno such table\n")


def test_a_program_of_another_version_is_refused(program):
    with pytest.raises(InputError, match="speaks version 2 of the protocol, but must speak version 1"):
        outcome_of(program(hello="say(drivegate=2); continue"))


def test_a_program_that_stays_after_its_input_ends_is_killed(program):
    late = "import atexit; atexit.register(time.sleep, 1e6)"
    assert outcome_of(program(late)) == float(STEPS)


UNSTEADY = {
    "time": "time.time() % 1",
    "process id": "(os.getpid() % 1000) / 1000",
    "chance": "random.random()",
    "earlier runs": "Mine.runs",
}


@pytest.mark.one_in(2)
@pytest.mark.parametrize("source", UNSTEADY)
def test_an_answer_that_depends_on_anything_else_is_non_deterministic(tmp_path, source, not_isolated):
    file = tmp_path / "mine.py"
    file.write_text(
        "import os, random, time\nfrom drivegate import Command\n"
        "class Mine:\n runs = 0\n def reset(self, nameplate): Mine.runs += 1\n"
        f" def step(self, sense): return Command(1.0 + sense.time * ({UNSTEADY[source]}), 0.0)\n",
        encoding="utf-8",
    )
    scenario = fixed_scenarios(load_drive("paper-5-phase"))[0].model_copy(update={"duration_s": 0.5})
    with WorkerPool(resolve_candidate(f"{file}:Mine"), workers=1) as pool:
        (outcome,) = pool.map([Job(run_fixed, FixedRuns((scenario,), repeat=True))])
        (run,) = repeated_elsewhere(pool, outcome.runs)
    (margin,) = [margin for margin in run.margins if margin.check == REPEATED]
    assert not margin.met, f"what depends on {source} was taken for deterministic: {margin.measured}"
    stated = r"differs from step 1 on, at 0\.0005 s: current reference \S+ against \S+ A"
    assert re.search(stated, margin.measured), margin.measured


def test_a_steady_answer_is_deterministic_in_another_process_too():
    scenario = fixed_scenarios(load_drive("paper-5-phase"))[0].model_copy(update={"duration_s": 0.5})
    with WorkerPool(resolve_candidate("initial"), workers=1) as pool:
        (outcome,) = pool.map([Job(run_fixed, FixedRuns((scenario,), repeat=True))])
        (run,) = repeated_elsewhere(pool, outcome.runs)
    assert [margin.value for margin in run.margins if margin.check == REPEATED] == [1.0]


def harmful(folder: Path, name: str, step: str) -> str:
    source = PYTHON.format(top="", reset="        pass", step=indent(step, " " * 12))
    (folder / f"{name}.py").write_text(source, encoding="utf-8")
    return f"{folder / name}.py:Mine"


@pytest.mark.nightly
def test_candidates_beside_a_harmful_one_have_their_usual_results(tmp_path, monkeypatch, capfd):
    monkeypatch.setattr(engine, "planned_work", lambda *given, **named: planned_work(*given, **named)[:2])
    chosen = [
        "initial",
        harmful(tmp_path, "teller", HUGE_TEXT),
        harmful(
            tmp_path, "crasher", f"{DAEMON}; print('\\x1b[31m<script>alert(1)</script>'); ctypes.string_at(0)"
        ),
        "initial",
    ]
    output = tmp_path / "report"
    with pytest.raises(SystemExit) as ended:
        main(["check", *chosen, "--effort", "quick", "--output", str(output)])
    printed = "".join(capfd.readouterr())
    assert ended.value.code == 1, printed
    assert printed.replace("\n", "").isprintable(), "hostile text reached the terminal"
    # Four tables of all checks and their progress; the hostile text alone has a million characters.
    assert len(printed) < 60_000
    first, second = (
        json.loads((output / name / "result.json").read_text()) for name in ("initial", "initial-2")
    )
    assert first["faults"] == second["faults"] == []
    assert first["provenance"] == second["provenance"], (
        "the result after the harmful candidates is another one"
    )
    kinds = {}
    for name in ("teller.py-Mine", "crasher.py-Mine"):
        document = json.loads((output / name / "result.json").read_text())
        kinds[name] = document["verdict"]
        ElementTree.parse(output / name / "junit.xml")
    assert kinds == {"teller.py-Mine": "exception", "crasher.py-Mine": "crash"}
    pages = [*output.rglob("*.html"), *output.rglob("*.md")]
    assert pages != []
    for page in pages:
        text = page.read_text(encoding="utf-8")
        assert "<script>alert" not in text, f"hostile text is code in {page.name}"
        assert "\x1b" not in text, f"hostile text is a control character in {page.name}"
