"""The wall around a candidate: what it holds against, what it lets through, and how it is requested."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import psutil
import pytest
from tests.harness import worker_jobs
from tests.harness.beside_templates import children
from tests.harness.containment.attacks import LEVELS, NAMES, ORDINARY, of_ordinary_user, outcomes, read_table

from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment import backend, judge_process, kept_process
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.pool import WorkerPool
from drivegate.containment.watches import WorkerLimits
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.drives.running import recorded
from drivegate.isolation import layers
from drivegate.isolation.layers import Layer, available_layers, layers_in_words, requested_layers
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.compilation.kernels import required_cache_folder
from drivegate_models.errors import InputError
from drivegate_models.half_bridge.periodic import least_conceivable


def digest_of(loaded: JudgedCandidate, scenario: Scenario) -> int:
    return int(recorded(loaded, scenario, loaded.controller()).run.digest)


def digest_beside_a_kernel(loaded: JudgedCandidate, scenario: Scenario) -> int:
    digest = digest_of(loaded, scenario)
    assert least_conceivable(scenario.drive.plant(), 5.0) > 0.0
    return digest


PAGE = Path(__file__).parents[3] / "docs" / "containment.md"
MINE = """
import ctypes, json, mmap, os, subprocess, sys, time
from pathlib import Path
from drivegate import Command
class Mine:
    def reset(self, nameplate):
        pass
    def step(self, sense):
        {step}
        return Command(1.0, 0.5)
"""


@pytest.fixture
def ending(tmp_path: Path) -> Callable[..., object]:
    """Return how a job with a candidate ends that does something in a step."""

    def ended(step: str, **options: object) -> object:
        file = tmp_path / "mine.py"
        file.write_text(MINE.format(step=step), encoding="utf-8")
        with Judge(resolve_candidate(f"{file}:Mine"), **options) as judge:
            return judge.once(Job(worker_jobs.drive, 2))

    return ended


def can_be_tried(level: str) -> bool:
    # Without the rights of root, many attacks fail on their own.
    return set(LEVELS[level]) <= set(available_layers()) and (level != "none" or os.getuid() == 0)


@pytest.mark.parametrize("level", [level for level in LEVELS if can_be_tried(level)])
def test_what_the_page_says_of_each_attack_is_so(level: str, no_process_left: None) -> None:
    stated = read_table(PAGE.read_text(encoding="utf-8"))
    assert set(stated) == set(NAMES)
    found = {name: "neither" if done else "prevented" for name, done in outcomes(LEVELS[level]).items()}
    assert found == {name: row[level] for name, row in stated.items()}


@pytest.mark.skipif(os.getuid() != 0, reason="becomes an ordinary user")
def test_what_the_page_says_of_an_ordinary_user_without_isolation_is_so(no_process_left: None) -> None:
    stated = read_table(PAGE.read_text(encoding="utf-8"))
    done = of_ordinary_user("none")
    assert done is not None
    assert {name for name in done if done[name]} == {
        name for name, row in stated.items() if row[ORDINARY] == "neither"
    }


@pytest.mark.parametrize("level", [level for level in LEVELS if LEVELS[level] and os.getuid() == 0])
def test_what_the_page_says_of_each_attack_is_so_for_an_ordinary_user(
    level: str, no_process_left: None
) -> None:
    """Root's candidate lacks the rights of root, so that it may fail where that of an ordinary user would not."""
    stated = read_table(PAGE.read_text(encoding="utf-8"))
    done = of_ordinary_user(level)
    if done is not None:
        assert {name for name in done if done[name]} == {
            name for name, row in stated.items() if row[level] == "neither"
        }


def test_a_candidate_reads_its_own_folder_and_what_the_user_names(
    ending: Callable[..., object],
    tmp_path: Path,
    tmp_path_factory: pytest.TempPathFactory,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    other = tmp_path_factory.mktemp("other")
    for folder in (tmp_path, other):
        (folder / "table.txt").write_text("1.5", encoding="utf-8")
    both = f"[Path('table.txt'), Path({str(other / 'table.txt')!r})]"
    step = f"return Command(sum(float(each.read_text()) for each in {both}), 0.5)"
    refused = ending(step)
    assert isinstance(refused, Fault)
    assert refused.error in ("FileNotFoundError", "PermissionError")
    assert "see --isolation and DRIVEGATE_READ" in refused.message
    monkeypatch.setenv(layers.READ_VARIABLE, str(other))
    assert ending(step) == 6.0


def test_processes_of_a_candidate_reach_each_other_by_a_local_port(ending: Callable[..., object]) -> None:
    step = (
        "import socket; server = socket.create_server(('127.0.0.1', 0)); "
        "socket.create_connection(server.getsockname()).send(b'x'); assert server.accept()[0].recv(1) == b'x'"
    )
    assert Layer.NAMESPACES not in available_layers() or ending(step) == 2.0


@pytest.mark.parametrize("missing", [None, Layer.NAMESPACES])
def test_layers_are_tried_one_by_one_only_where_not_all_work(
    monkeypatch: pytest.MonkeyPatch, missing: Layer | None
) -> None:
    every, tried = tuple(Layer), []

    def work(some: tuple[Layer, ...]) -> bool:
        tried.append(some)
        return missing not in some

    monkeypatch.setattr(layers, "_work", work)
    # The function itself: its answer is kept for the rest of the process.
    assert available_layers.__wrapped__() == tuple(layer for layer in every if layer != missing)
    assert tried == [every, *((layer,) for layer in every if missing is not None)]


def test_strict_refuses_where_a_layer_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(layers, "available_layers", lambda: (Layer.LANDLOCK, Layer.REFUSED_CALLS))
    monkeypatch.setenv(layers.ISOLATION_VARIABLE, "strict")
    with pytest.raises(InputError, match="needs namespaces, which this machine does not allow"):
        requested_layers()
    monkeypatch.setenv(layers.ISOLATION_VARIABLE, "auto")
    assert layers_in_words(requested_layers()) == "isolated by Landlock and seccomp"
    monkeypatch.setenv(layers.ISOLATION_VARIABLE, "none")
    assert layers_in_words(requested_layers()) == "not isolated"
    monkeypatch.setenv(layers.ISOLATION_VARIABLE, "some")
    with pytest.raises(InputError, match='is "some", but must be auto, strict or none'):
        requested_layers()


FORGED = """
import os, sys
from pathlib import Path
from drivegate import Command
class Forgery:
    def __reduce__(self):
        # The candidate's own process loads kernels, too.
        return exec, ("import sys; 'judge' in sys.argv and open({forged!r}, 'w').close()",)
import pickle
for file in Path({kernels!r}).rglob("*.nb[ic]"):
    # To compile the closed loop again takes the judge long.
    if not file.name.startswith("loop_kernel."):
        file.write_bytes(pickle.dumps(Forgery()))
        Path({changed!r}).touch()
class Mine:
    def reset(self, nameplate):
        pass
    def step(self, sense):
        return Command(1.0, 0.5)
"""


def test_a_judge_loads_no_kernel_that_a_candidate_has_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, not_isolated: None
) -> None:
    kernels = tmp_path / "cache"
    folder = required_cache_folder()
    scenario = fixed_scenarios(load_drive("paper-5-phase"))[0].model_copy(update={"duration_s": 0.05})
    assert least_conceivable(scenario.drive.plant(), 5.0) > 0.0, "it is kept from now on"
    for module in folder.glob("drivegate_models.*"):
        # Another test may store a kernel meanwhile.
        shutil.copytree(module, kernels / folder.name / module.name, ignore=shutil.ignore_patterns("*.tmp.*"))
    monkeypatch.setenv("DRIVEGATE_CACHE", str(kernels))
    file = tmp_path / "mine.py"
    places = {"kernels": kernels, "forged": tmp_path / "forged", "changed": tmp_path / "changed"}
    file.write_text(FORGED.format(**{name: str(place) for name, place in places.items()}), encoding="utf-8")
    with WorkerPool(resolve_candidate(f"{file}:Mine"), workers=1) as pool:
        (ended,) = pool.map([Job(digest_beside_a_kernel, scenario)])
    assert places["changed"].exists(), "the candidate has changed nothing"
    changed = [each for each in kernels.rglob("*.nb[ic]") if b"/forged" in each.read_bytes()]
    # A function called by address, and one called from Python.
    for needed in ("loop/step_recording.playing_step.", "half_bridge/periodic.least_conceivable-"):
        stored = set(kernels.glob(f"*/drivegate_models.{needed}*.nbi"))
        assert stored, f"{needed} is not kept"
        assert not stored.intersection(changed), f"the judge has to compile and store {needed} again"
    assert not places["forged"].exists(), "the judge executed what the candidate wrote"
    assert isinstance(ended, int), ended


@pytest.mark.parametrize("isolation", ["strict", "none"])
def test_a_worker_of_a_cluster_isolates_as_the_user_requests(
    monkeypatch: pytest.MonkeyPatch, isolation: str
) -> None:
    monkeypatch.setenv(layers.ISOLATION_VARIABLE, "auto")

    def task(_package: bytes, name: str) -> str:
        return os.environ[name]

    done = backend._kept(task, b"", layers.ISOLATION_VARIABLE, None, isolation)
    assert done == (layers.ISOLATION_VARIABLE, isolation)


@pytest.mark.parametrize("before", [None, "auto"])
def test_a_command_requests_isolation_for_itself_alone(
    monkeypatch: pytest.MonkeyPatch, before: str | None
) -> None:
    monkeypatch.delenv(layers.ISOLATION_VARIABLE, raising=False)
    if before is not None:
        monkeypatch.setenv(layers.ISOLATION_VARIABLE, before)
    with layers.isolation_requested("none"):
        assert requested_layers() == ()
    assert os.environ.get(layers.ISOLATION_VARIABLE) == before


def test_a_source_in_c_takes_in_no_file_of_the_machine(
    tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    secret = tmp_path_factory.mktemp("other") / "secret.h"
    secret.write_text("the secret\n", encoding="utf-8")
    source = tmp_path / "mine.c"
    source.write_text(f'#include "{secret}"\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"mine\.c, line 1: ") as refused:
        resolve_candidate(str(source))
    assert "the secret" not in str(refused.value)


@pytest.mark.parametrize("level", ["auto", "none"])
def test_shared_memory_counts_as_memory(
    ending: Callable[..., object], monkeypatch: pytest.MonkeyPatch, level: str
) -> None:
    monkeypatch.setenv(layers.ISOLATION_VARIABLE, level)
    step = (
        "self.kept = [mmap.mmap(-1, 2**28) for _ in range(6)]; "
        "[each.write(b'x' * 2**28) for each in self.kept]; time.sleep(30)"
    )
    fault = ending(step, limits=WorkerLimits(memory_bytes=2**30))
    assert isinstance(fault, Fault)
    assert fault.kind is FaultKind.CRASH
    assert fault.message.startswith("the candidate's processes used more than 1 GiB of memory"), fault.message


def test_a_stopped_judge_is_a_fault_with_a_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, no_process_left: None
) -> None:
    monkeypatch.setattr(judge_process, "_STOPPED_SECONDS", 0.5)
    file = tmp_path / "mine.py"
    file.write_text(MINE.format(step="time.sleep(0.05)"), encoding="utf-8")
    with WorkerPool(resolve_candidate(f"{file}:Mine"), workers=1) as pool:
        ended = pool.map([Job(worker_jobs.drive, 2), Job(worker_jobs.drive, 10**6)])
        assert next(ended) == 2.0
        # A stopped template would not reap its copies.
        for process in children():
            # One that has just ended has no command line.
            with suppress(psutil.Error):
                if "judge" in process.cmdline():
                    process.send_signal(signal.SIGSTOP)
        began = time.monotonic()
        (fault,) = ended
    assert isinstance(fault, Fault)
    assert fault.message == "a process of the harness that watched the candidate was stopped"
    assert time.monotonic() - began < 30.0


def test_what_a_stopped_keeper_keeps_ends_with_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, not_isolated: None, no_process_left: None
) -> None:
    monkeypatch.setattr(kept_process, "_KEEPER_PATIENCE", 0.5)
    # The daemon stops its keeper again and again.
    daemon = "import os, signal, sys, time\nwhile True:\n os.kill(int(sys.argv[1]), signal.SIGSTOP)\n time.sleep(0.001)"
    step = f"subprocess.Popen([sys.executable, '-c', {daemon!r}, str(os.getppid())], start_new_session=True)"
    file = tmp_path / "mine.py"
    file.write_text(MINE.format(step=step), encoding="utf-8")
    with Judge(resolve_candidate(f"{file}:Mine")) as judge:
        assert judge.once(Job(worker_jobs.drive, 1)) == 1.0
        time.sleep(0.5)


# The first process of a table is late, as on a busy machine, and its parent has nothing more to do.
_LATE = """
import os, time
from drivegate.isolation import namespaces
in_time = namespaces.die_with_parent
def late():
    time.sleep(0.3)
    in_time()
namespaces.die_with_parent = late
namespaces.enter_process_namespace()
"""


@pytest.mark.parametrize("signal_number", [0, signal.SIGKILL])
def test_the_first_process_of_a_table_never_outlives_its_parent(
    signal_number: int, no_process_left: None
) -> None:
    process = subprocess.Popen([sys.executable, "-c", _LATE], stderr=subprocess.DEVNULL)
    if signal_number:
        while process.poll() is None and not psutil.Process(process.pid).children():
            time.sleep(0.01)
        process.send_signal(signal_number)
    process.wait(20.0)


def test_an_isolated_tool_ends_with_the_process_that_started_it(no_process_left: None) -> None:
    starts = (
        "import subprocess; from drivegate.isolation.layers import *; "
        "subprocess.run(isolated_command(['sleep', '60'], available_layers(), Places((), ())))"
    )
    process = subprocess.Popen([sys.executable, "-c", starts])
    own = psutil.Process(process.pid)
    while not [child for child in own.children(recursive=True) if child.name() == "sleep"]:
        assert process.poll() is None
        time.sleep(0.05)
    process.kill()
    process.wait()


@pytest.mark.parametrize(
    "source",
    ["int nothing", "int nowhere(void);\nint drivegate_step(void) { return nowhere(); }"],
    ids=["not compiled", "not loaded"],
)
def test_no_process_is_left_of_a_candidate_that_cannot_be_loaded(
    tmp_path: Path, source: str, no_process_left: None
) -> None:
    (tmp_path / "mine.c").write_text(f"{source}\n", encoding="utf-8")
    with (
        pytest.raises(InputError),
        Judge(resolve_candidate(str(tmp_path / "mine.c"))) as judge,
    ):
        judge.once(Job(worker_jobs.drive, 2))
