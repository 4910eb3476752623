"""What holds for every command: it answers at once, in one form, and ends in one of the documented ways."""

import importlib.util
import json
import os
import resource
import signal
import subprocess
import sys
from pathlib import Path

import click
import pytest

from drivegate import __version__
from drivegate.candidates.kinds import KINDS, MANIFEST_SUFFIX
from drivegate.commands.command_line import COMMANDS
from drivegate.commands.conduct import Outcome, conducted
from drivegate.output.result_reports import read_result
from drivegate_models.errors import HarnessFault, InputError, OutOfMemory

HEAVY = ("numba", "numpy", "pandas", "pint", "pydantic", "scipy", "hypothesis", "matplotlib", "rich")


def drivegate(*words, **options):
    program = "from drivegate.commands.command_line import main; main()"
    return subprocess.Popen(
        [sys.executable, "-c", program, *words],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        **options,
    )


def processor_seconds():
    """Tell the processor time of all processes that have ended, on which what else the machine does has no bearing."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def seconds_of(process):
    """Wait for a process that succeeds, and give its processor time beside what it printed."""
    before = processor_seconds()
    out, err = process.communicate()
    assert (process.returncode, err) == (0, "")
    return processor_seconds() - before, out


@pytest.mark.parametrize("words", [["--help"], ["check", "--help"]])
def test_help_answers_at_once(words):
    """Set against the start of the library that reads command lines, on however slow a machine.

    Two commands are timed. `test_help_loads_nothing_heavy` shows for every command that its help loads no more.
    """
    alone, helped = [], []
    for _ in range(4):
        imported = subprocess.Popen(
            [sys.executable, "-c", "import click"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        alone.append(seconds_of(imported)[0])
        seconds, out = seconds_of(drivegate(*words))
        helped.append(seconds)
        assert "Usage: drivegate" in out
    assert min(helped) < 3.5 * min(alone), f"help took {min(helped):.2f} s, and click {min(alone):.2f} s"


def test_help_loads_nothing_heavy():
    """One process prints all of them, since each would take longer to start than to print."""
    program = (
        "import sys\nfrom drivegate.commands.command_line import main\n"
        f"for words in {[['--help'], *([name, '--help'] for name in COMMANDS)]}:\n"
        "    try: main(words)\n"
        f"    except SystemExit: print('LOADED', *words, *sorted(set(sys.modules) & {set(HEAVY)}))"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    loaded = [line.split()[1:] for line in ended.stdout.splitlines() if line.startswith("LOADED")]
    assert loaded == [["--help"], *([name, "--help"] for name in COMMANDS)], (
        "help must not load what only the work needs"
    )


def test_what_is_refused_at_once_loads_no_arrays(tmp_path):
    missing = str(tmp_path / "missing.json")
    refused = [
        ["verify", missing],
        ["report", missing],
        ["replay", missing],
        ["drive", missing],
        ["diff", "--bad"],
    ]
    program = (
        "import sys\nfrom drivegate.commands.command_line import main\n"
        f"for words in {refused}:\n"
        "    try: main(words)\n"
        "    except SystemExit as ended: assert ended.code == 2, words\n"
        "    assert not {'numba', 'numpy'} & set(sys.modules), words"
    )
    subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)


def test_help_lists_every_command_and_the_version_is_reported(command):
    text = command("--help").out
    assert all(name in text for name in COMMANDS)
    assert command("--version").out == f"drivegate {__version__}\n"


def test_a_misspelt_command_is_named_with_the_nearest(refused):
    assert "'pint' is unknown, the nearest is 'point'" in refused("pint")


def test_without_a_command_the_help_is_printed(command):
    ended = command()
    assert (ended.code, ended.err) == (0, "")
    assert all(f"  {name} " in ended.out for name in COMMANDS)
    assert "a command is missing" in command("--json").document["error"]["message"]


def test_json_is_understood_before_and_after_the_command(command):
    assert command("--json", "cases").document == command("cases", "--json").document


def test_an_option_that_does_not_exist_is_named(refused):
    assert "--sped-rpm" in refused("point", "--sped-rpm", "3")


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (InputError("the key is wrong"), 2, "error: the key is wrong\n"),
        (click.UsageError("Missing\noption."), 2, "error: Missing option\n"),
        (
            HarnessFault("it broke: Traceback (most recent call last):\n  x\nValueError: 3"),
            3,
            "it broke: ValueError: 3",
        ),
        (ZeroDivisionError("division by zero"), 3, "drivegate itself failed"),
        (OSError(28, "No space left on device", "x.csv"), 2, "cannot write at x.csv: No space left"),
        (OSError(24, "Too many open files"), 2, "the system refuses to continue: Too many open files; raise"),
        (
            MemoryError(),
            3,
            "the machine has too little memory, which is no verdict on a candidate: an allocation",
        ),
        (OSError(12, "Cannot allocate memory"), 3, "or name fewer workers with --workers"),
        (OutOfMemory("the machine has too little memory"), 3, "error: the machine has too little memory\n"),
        (KeyboardInterrupt(), 130, "error: interrupted\n"),
    ],
)
def test_every_ending_has_its_exit_code_and_one_sentence(error, code, words, capsys):
    def work():
        raise error

    for as_json in (False, True):
        assert conducted(work, as_json=as_json) == code
        printed = capsys.readouterr()
        assert words in printed.err
        assert len(printed.err.splitlines()) == 1
        if as_json:
            message = printed.err.removeprefix("error: ").rstrip("\n")
            assert json.loads(printed.out) == {"schema": 1, "error": {"message": message, "exit_code": code}}
        else:
            assert printed.out == ""


def test_a_traceback_is_shown_only_when_it_is_requested(monkeypatch, capsys):
    def work():
        raise ZeroDivisionError

    monkeypatch.setenv("DRIVEGATE_DEBUG", "1")
    conducted(work, as_json=True)
    printed = capsys.readouterr()
    assert "Traceback" in printed.err
    assert json.loads(printed.out)["error"]["exit_code"] == 3


def test_numbers_that_json_cannot_write_become_null(capsys):
    document = {"schema": 1, "nan": float("nan"), "list": [float("inf"), (1.5,)]}
    assert conducted(lambda: Outcome(document, lambda _: None, 1), as_json=True) == 1
    assert json.loads(capsys.readouterr().out) == {"schema": 1, "nan": None, "list": [None, [1.5]]}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("words", [["cases"], ["cases", "--json"], ["checks"]])
def test_a_reader_that_leaves_changes_nothing(words):
    process = drivegate(*words)
    process.stdout.close()
    assert process.stderr.read() == ""
    assert process.wait() == 0
    process.stderr.close()


def test_a_working_folder_that_is_gone_is_named(tmp_path):
    gone = tmp_path / "gone"
    gone.mkdir()
    command = (
        "import os; os.rmdir(os.getcwd()); from drivegate.commands.command_line import main; "
        "main(['check', 'x.py:Y'])"
    )
    ended = subprocess.run(
        [sys.executable, "-P", "-c", command], cwd=gone, capture_output=True, text=True, check=False
    )
    assert (ended.returncode, ended.stderr) == (
        2,
        "error: the working folder no longer exists; change to another one with cd\n",
    )


def test_an_error_that_cannot_be_printed_has_its_exit_code():
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        ended = subprocess.run([sys.executable, "-m", "drivegate", "nonsense"], stderr=full, check=False)
    assert ended.returncode == 2


def test_a_console_without_the_characters_gets_escapes():
    process = drivegate("cases", env={**os.environ, "PYTHONIOENCODING": "ascii"})
    out, err = process.communicate()
    assert (process.returncode, err) == (0, "")
    assert r"N\xb7m" in out


def ended_by(ending, folder, *words):
    """End a check that has begun to run, and return the document that it printed."""
    # Whoever runs the tests may ignore SIGHUP, which a process inherits.
    process = drivegate(
        *("check", "reference", "--json", *words),
        cwd=folder,
        preexec_fn=lambda: signal.signal(ending, signal.SIG_DFL),
    )
    assert any("running" in line for line in iter(process.stderr.readline, ""))
    process.send_signal(ending)
    out, err = process.communicate()
    assert process.returncode == 130, err
    assert err.splitlines()[-1] == "error: interrupted"
    document = json.loads(out)
    assert document["error"]["exit_code"] == 130
    return document


@pytest.mark.nightly
def test_a_check_whose_terminal_is_closed_exits_with_130_and_leaves_nothing(tmp_path):
    ended_by(signal.SIGHUP, tmp_path)
    assert list(tmp_path.iterdir()) == [], "an interrupted check leaves no folder behind"


@pytest.mark.one_in(2)
@pytest.mark.parametrize("ending", [signal.SIGINT, signal.SIGTERM])
def test_a_check_that_is_terminated_exits_with_130_and_leaves_what_it_knows(tmp_path, ending):
    document = ended_by(ending, tmp_path, "--workers", "1")
    assert [path.name for path in tmp_path.iterdir()] == ["drivegate-report"], "nothing unfinished stays"
    folder = tmp_path / "drivegate-report"
    assert not list(folder.rglob("*.partial"))
    stored = read_result(folder / "result.json")
    assert {key: value for key, value in document.items() if key != "error"} == stored
    assert (stored["verdict"], stored["incomplete"]) == ("inconclusive", "interrupted")
    assert "incomplete, interrupted after" in (folder / "summary.md").read_text(encoding="utf-8")


def test_a_signal_that_is_ignored_stays_ignored():
    command = (
        "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN); from drivegate.commands.command_line "
        "import main; import atexit; atexit.register(lambda: print(signal.getsignal(signal.SIGHUP).name)); "
        "main(['--version'])"
    )
    ended = subprocess.run([sys.executable, "-c", command], capture_output=True, text=True, check=True)
    assert ended.stdout.splitlines()[-1] == "SIG_IGN", "nohup must go on working"


def test_the_package_is_a_program_too():
    ended = subprocess.run(
        [sys.executable, "-m", "drivegate", "--version"], capture_output=True, text=True, check=False
    )
    assert (ended.returncode, ended.stdout, ended.stderr) == (0, f"drivegate {__version__}\n", "")


def test_the_help_of_check_names_every_kind_of_candidate(command):
    shown = " ".join(command("check", "--help").out.split())
    for kind in KINDS.values():
        for mark in filter(None, (*kind.ways, *kind.prefixes)):
            assert mark in shown, f"a candidate may be written with '{mark}', which the help leaves out"
    for mark in ("file.py:Class", "module:Class", "file.py:name", MANIFEST_SUFFIX, "reference"):
        assert mark in shown, f"the help leaves out {mark}"


@pytest.mark.parametrize(
    ("words", "package"),
    [
        (["simulate", "reference", "--case", "lock-up", "--parquet", "trace.parquet"], "pyarrow"),
        (["campaign", "spread.toml"], "pyarrow"),
        (
            ["campaign", "spread.toml", "--backend", "dask", "--scheduler", "tcp://127.0.0.1:1"],
            "dask distributed",
        ),
    ],
)
def test_a_missing_package_is_named_as_pip_takes_it(refused, tmp_path, monkeypatch, words, package):
    spread = 'schema = 1\ncandidates = ["reference"]\ncases = ["lock-up"]\n'
    (tmp_path / "spread.toml").write_text(spread, encoding="utf-8")
    absent = set(package.split())
    found = importlib.util.find_spec

    def spec(name, *more):
        return None if name in absent else found(name, *more)

    for module in ("output.trace_files", "studies.campaign.folder", "containment.backend"):
        monkeypatch.setattr(f"drivegate.{module}.find_spec", spec)
    assert f"pip install {package}" in refused(*words)
