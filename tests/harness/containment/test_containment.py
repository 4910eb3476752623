"""What a worker process is given, and that nothing of it is left whatever becomes of the harness."""

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil
import pytest
from tests.harness import worker_jobs

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.kept_process import PASS_VARIABLE, worker_environment
from drivegate.containment.messages import Job
from drivegate.isolation.layers import ISOLATION_VARIABLE

MINE = """
import os, resource, subprocess, sys, tempfile, time
from pathlib import Path
from drivegate import Command
class Mine:
    def reset(self, nameplate):
        {reset}
    def step(self, sense):
        return Command({answer}, 0.5)
"""


@pytest.fixture
def scratch(monkeypatch, tmp_path):
    folder = tmp_path / "scratch"
    folder.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    return folder


@pytest.fixture
def answer(scratch, tmp_path):
    """Evaluate an expression in a candidate's step."""

    def evaluate(expression, reset="pass"):
        file = tmp_path / "mine.py"
        file.write_text(MINE.format(reset=reset, answer=expression), encoding="utf-8")
        with Judge(resolve_candidate(f"{file}:Mine")) as worker:
            return worker.run(Job(worker_jobs.drive, 1))

    return evaluate


def test_secrets_of_the_harness_do_not_reach_a_candidate(answer, monkeypatch):
    monkeypatch.setenv("CI_DEPLOY_TOKEN", "secret")
    assert answer("float('CI_DEPLOY_TOKEN' in os.environ)") == 0.0


def test_a_variable_is_passed_on_where_the_user_says_so(answer, monkeypatch):
    monkeypatch.setenv("LICENCE_SERVER", "7.5")
    monkeypatch.setenv(PASS_VARIABLE, "OTHER, LICENCE_SERVER")
    assert answer("float(os.environ['LICENCE_SERVER'])") == 7.5


def test_the_environment_is_a_short_list_and_names_folders_of_its_own():
    inherited = {"PATH": "/bin", "LC_ALL": "C", "AWS_SECRET_ACCESS_KEY": "x", "DRIVEGATE_CACHE": "kernels"}
    given = worker_environment(inherited, Path("/scratch"), Path("/kernels"))
    assert given == {
        "PATH": f"{Path(sys.executable).parent}:/bin",
        "LC_ALL": "C",
        "DRIVEGATE_KERNELS": "/kernels",
        "NUMBA_CACHE_DIR": "/scratch/numba",
        "PYTHONHASHSEED": "0",
        "TMPDIR": "/scratch",
        "TMP": "/scratch",
        "TEMP": "/scratch",
    }


def test_a_candidate_reads_what_lies_beside_it_by_a_relative_path(answer, tmp_path):
    (tmp_path / "table.txt").write_text("4.25", encoding="utf-8")
    assert answer("float(Path('table.txt').read_text())") == 4.25


def test_what_decides_how_numbers_are_computed_is_passed_on_but_no_input(answer, monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    monkeypatch.delenv("PYTHONHASHSEED", raising=False)
    assert answer("float(os.environ['OMP_NUM_THREADS'])") == 7.0
    assert answer("float(os.environ['PYTHONHASHSEED'] == '0' and sys.stdin.read() == '')") == 1.0


def test_a_worker_leaves_no_memory_dump(answer):
    assert answer("float(resource.getrlimit(resource.RLIMIT_CORE)[0])") == 0.0


def test_each_worker_has_a_temporary_folder_which_is_removed_with_it(answer, scratch):
    holds_it = f"float(Path(tempfile.gettempdir()).parent == Path({str(scratch)!r}))"
    assert answer(holds_it, reset="Path(tempfile.mkstemp()[1]).write_text('x')") == 1.0
    assert list(scratch.iterdir()) == []


DAEMON = "subprocess.Popen(['setsid', 'sleep', '65432'], env={}, start_new_session=True)"
HARNESS = """
from tests.harness import worker_jobs
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate.isolation.layers import ISOLATION_VARIABLE
with Judge(resolve_candidate({specification!r})) as worker:
    worker.run(Job(worker_jobs.drive, 7))
"""


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("ending", "isolation"),
    [(signal.SIGKILL, "auto"), (signal.SIGTERM, "auto"), (signal.SIGINT, "auto"), (signal.SIGKILL, "none")],
)
def test_nothing_is_left_when_the_harness_is_ended(scratch, tmp_path, ending, isolation):
    file = tmp_path / "mine.py"
    reset = f"{DAEMON}; time.sleep(1000)"
    file.write_text(MINE.format(reset=reset, answer="1.0"), encoding="utf-8")
    paths = os.pathsep.join(sys.path)
    harness = subprocess.Popen(
        [sys.executable, "-c", HARNESS.format(specification=f"{file}:Mine")],
        env={**os.environ, "PYTHONPATH": paths, "TMPDIR": str(scratch), ISOLATION_VARIABLE: isolation},
        stderr=subprocess.DEVNULL,
    )
    wait_until(
        lambda: any("65432" in command_line(process) for process in below(harness)),
        "the daemon did not begin",
    )
    kept = below(harness)
    harness.send_signal(ending)
    harness.wait(30)
    _, alive = psutil.wait_procs(kept, timeout=15)
    assert alive == [], "processes outlived the harness"
    wait_until(lambda: list(scratch.iterdir()) == [], "a temporary folder outlived the harness")


def below(harness):
    """List the processes that came from the harness, but those that have just ended."""
    return [
        each
        for each in psutil.Process(harness.pid).children(recursive=True)
        if each.is_running() and each.status() != psutil.STATUS_ZOMBIE
    ]


def command_line(process):
    """Return the words of a process; none of one that ends meanwhile."""
    try:
        return process.cmdline()
    except psutil.Error:
        return []


def wait_until(condition, otherwise):
    deadline = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < deadline, otherwise
        time.sleep(0.05)
