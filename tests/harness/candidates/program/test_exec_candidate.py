"""A candidate that is a program: what its command line names, and what passes between it and the harness."""

import ctypes
import json
import math
import os
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest

from drivegate.candidates.candidate import Program
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.program.loading import ProgramProcess
from drivegate.candidates.program.protocol import (
    HELLO,
    LONGEST_LINE,
    command_of,
    reset_message,
    sense_message,
)
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.drives.running import run_scenario
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.contract.current.records import command_record, sense_record
from drivegate_models.contract.current.signals import Command, Nameplate, Sense
from drivegate_models.errors import InputError

ROOT = Path(__file__).parents[4]
TEMPLATE = ROOT / "harness/drivegate/templates/new/exec/controller.py"
NAMEPLATE = Nameplate(
    *(5, 11, 48.0, 52.36, 1500.0, 26.0, 0.0005, 0.25, 0.08, 0.00288, 0.339, 0.05),
    *(1, 2.513, 4.0, 0.576, 0.00417, 157.08),
)
SENSE = Sense(0.1 + 0.2, 100.0, math.nextafter(99.0, 0.0), (1e-300, -0.0, 2 / 3, 1e22, 5e-324), 1 / 3, 48.0)
SHELL = """
read hello; echo '{"drivegate": 1}'
while read line; do
  case "$line" in
    *reset*) echo '{"ready": true}';;
    *) echo '{"current_reference": 2, "advance_angle": 0.25}';;
  esac
done
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def written(file: Path, text: str, mode: int = 0o644) -> Path:
    file.write_text(text, encoding="utf-8")
    file.chmod(mode)
    return file


def manifest(folder: Path, entry: str, further: str = "") -> str:
    text = f'schema = 1\nname = "mine"\nkind = "exec"\nentry = {json.dumps(entry)}\n{further}'
    return str(written(folder / "candidate.toml", text))


def test_a_command_line_has_words_and_quotes(folder):
    written(folder / "my program.py", "pass")
    candidate = resolve_candidate("exec:sh 'my program.py' --gain 2")
    assert (candidate.kind, candidate.name, candidate.folder) == (
        "exec",
        "exec:sh 'my program.py' --gain 2",
        folder,
    )
    assert candidate.details.arguments == ("sh", "my program.py", "--gain", "2")
    assert candidate.details.executable == Path(shutil.which("sh"))
    assert candidate.sources == (folder / "my program.py",)


def test_the_name_leaves_out_folders_so_that_waivers_match(folder):
    file = written(folder / "mine.py", "pass")
    assert resolve_candidate(f"exec:sh {file} a/b").name == "exec:sh mine.py a/b"


def test_the_hash_covers_the_command_line_and_the_files_on_it(folder):
    file = written(folder / "mine.py", "pass")
    first = resolve_candidate("exec:sh mine.py").content_hash
    assert resolve_candidate("exec:sh mine.py").content_hash == first
    assert resolve_candidate("exec:sh mine.py -x").content_hash != first
    file.write_text("other", encoding="utf-8")
    assert resolve_candidate("exec:sh mine.py").content_hash != first


def test_a_manifest_says_what_a_program_is_made_of(folder):
    inside = folder / "inside"
    inside.mkdir()
    written(inside / "mine.sh", SHELL, 0o755)
    written(inside / "table.txt", "1")
    text = 'sources = ["table.txt"]\nstep_deadline_s = 2.5\nestimates_power = true\n'
    candidate = resolve_candidate(manifest(inside, "./mine.sh --fast", text))
    assert (candidate.name, candidate.folder) == ("mine", inside)
    assert candidate.details.step_deadline == 2.5
    assert candidate.details.executable == inside / "mine.sh"
    assert candidate.sources == (inside / "mine.sh", inside / "table.txt")
    assert candidate.declaration.estimates_power


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("exec:", "names no program; write exec:python3 controller.py"),
        ("exec:''", "names no program"),
        ("exec:sh 'mine", "has a quote that is not closed"),
        ("exec:sh mine\\", "has a backslash at its end"),
        ("exec:no-such-program-anywhere", "'no-such-program-anywhere', which is no program in PATH"),
        ("exec:beside.sh", "name an installed program, or ./beside.sh for the file there"),
        ("exec:./absent", "/absent, which does not exist; name an existing program"),
        ("exec:./beside.sh", "which is not executable; set its permission with chmod"),
    ],
)
def test_a_program_that_cannot_be_is_refused_in_one_sentence(folder, text, reason):
    written(folder / "beside.sh", SHELL)
    if os.geteuid() == 0 and "not executable" in reason:
        assert not os.access(folder / "beside.sh", os.X_OK)
    with pytest.raises(InputError) as refused:
        resolve_candidate(text)
    assert reason in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_program_that_the_system_cannot_start_is_refused(folder):
    written(folder / "mine", "no program at all", 0o755)
    with pytest.raises(InputError, match="cannot be started: Exec format error; it must be executable"):
        load_controller(resolve_candidate("exec:./mine"))


@pytest.mark.parametrize("value", ["0", "31.0", "-1.0"])
def test_a_deadline_out_of_range_is_refused(folder, value):
    with pytest.raises(InputError, match="step_deadline_s"):
        resolve_candidate(manifest(folder, "sh mine.sh", f"step_deadline_s = {value}\n"))


def test_a_deadline_is_for_programs_only(folder):
    text = 'schema = 1\nname = "mine"\nkind = "builtin"\nentry = "initial"\nstep_deadline_s = 1.0\n'
    with pytest.raises(
        InputError, match="'step_deadline_s' is for the kind 'exec', but the kind is 'builtin'"
    ):
        resolve_candidate(str(written(folder / "candidate.toml", text)))


def test_numbers_cross_without_rounding():
    sensed = json.loads(sense_message(SENSE))["sense"]
    assert Sense(**{**sensed, "phase_currents": tuple(sensed["phase_currents"])}) == SENSE
    assert math.copysign(1.0, sensed["phase_currents"][1]) == -1.0
    assert Nameplate(**json.loads(reset_message(NAMEPLATE))["reset"]) == NAMEPLATE
    answer = {"current_reference": SENSE.speed, "advance_angle": 5e-324, "input_power": 1 / 3}
    assert command_of(json.dumps(answer).encode()) == Command(SENSE.speed, 5e-324, 1 / 3)


@pytest.mark.parametrize("line", [sense_message(SENSE), reset_message(NAMEPLATE)])
def test_a_message_is_one_line_of_plain_text(line):
    assert line.endswith(b"\n")
    assert line.count(b"\n") == 1
    assert line.isascii()


@pytest.mark.parametrize("power", ["", ', "input_power": null'])
def test_a_program_may_make_no_estimate(power):
    command = command_of(f'{{"current_reference": 1, "advance_angle": 0{power}}}\r\n'.encode())
    assert command[:2] == (1.0, 0.0)
    assert math.isnan(command.input_power)


def stepped(controller, sense):
    step = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)(controller.step_address)
    currents, command = np.zeros(len(sense.phase_currents)), command_record()
    record = sense_record(sense, currents)
    step(controller.state_address, record.ctypes.data, command.ctypes.data)
    assert controller.fault is None, controller.fault
    return command[0]


def test_a_shell_script_is_a_controller(folder):
    written(folder / "mine.sh", SHELL)
    controller = load_controller(resolve_candidate("exec:sh mine.sh"))
    for _ in range(3):
        controller.reset(NAMEPLATE)
        command = stepped(controller, SENSE)
        assert (command["current_reference"], command["advance_angle"]) == (2.0, 0.25)
        assert math.isnan(command["input_power"])


def test_a_long_line_within_the_bound_is_taken(folder):
    answer = '{"current_reference": 2, "advance_angle": 0.25}'
    padding = " " * (LONGEST_LINE - len(answer) - 2)
    written(folder / "mine.sh", SHELL.replace(answer, answer + padding))
    controller = load_controller(resolve_candidate("exec:sh mine.sh"))
    controller.reset(NAMEPLATE)
    assert stepped(controller, SENSE)["current_reference"] == 2.0


def test_a_program_sees_no_descriptor_but_its_own(folder):
    listing = "import os; print({'drivegate': 1, 'name': ' '.join(os.listdir('/proc/self/fd'))})"
    written(folder / "mine.py", f"{listing.replace('print(', 'import json; print(json.dumps(')})")
    program = Program(Path(sys.executable), (sys.executable, "mine.py"))
    with Path(os.devnull).open() as secret:
        os.set_inheritable(secret.fileno(), True)
        process = ProgramProcess(program, folder)
        seen = json.loads(process.request(HELLO, 30.0))["name"].split()
        process.end()
    # The fourth is the folder that is being listed.
    assert seen == ["0", "1", "2", "3"], "a descriptor of the harness reached the program"


def test_each_instance_is_a_process_that_ends_with_it(folder):
    written(folder / "mine.sh", SHELL)
    candidate = resolve_candidate("exec:sh mine.sh")
    first, second = load_controller(candidate), load_controller(candidate)
    processes = [controller.instance._process._process for controller in (first, second)]
    assert processes[0].pid != processes[1].pid
    del first
    assert processes[0].returncode is not None, "the program outlived its controller"
    assert processes[1].poll() is None
    del second
    assert processes[1].returncode is not None


def short(scenario: Scenario) -> Scenario:
    return scenario.model_copy(update={"duration_s": 1.0})


def test_the_template_gives_the_commands_of_the_same_algorithm_in_the_harness():
    scenario = short(fixed_scenarios(load_drive("paper-5-phase"))[1])
    program = load_controller(resolve_candidate(f"exec:{sys.executable} {TEMPLATE}"))
    builtin = load_controller(resolve_candidate("initial"))
    for _ in range(2):
        assert run_scenario(scenario, program).digest == run_scenario(scenario, builtin).digest
