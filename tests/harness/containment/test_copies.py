"""Copies of a template are what new processes are, with nothing of a template or of another copy in them."""

import json
import os
import resource
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import psutil
import pytest
from tests.harness import worker_jobs
from tests.harness.beside_templates import copies

from drivegate.candidates.fault import Fault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment import kept_process, templates
from drivegate.containment.judge import Judge
from drivegate.containment.keeper_process import CopiedKeeper
from drivegate.containment.messages import Job
from drivegate.containment.pool import WorkerPool
from drivegate.containment.templates import Preparation, Templates
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.gate.repetition import Repetition, repetition_job
from drivegate.gate.warm_up import judges_on
from drivegate.isolation.layers import ISOLATION_VARIABLE
from drivegate_cases.drive.drive_document import load_drive

LOOKING = """
import gc, json, os, random, resource, signal, sys, tempfile, threading
from pathlib import Path
import numpy as np
from drivegate import Command

def kind(number):
    try:
        return os.readlink(f"/proc/self/fd/{number}").split(":")[0], os.get_inheritable(number)
    except OSError:
        return None

# Not the number of threads: those of a library for linear algebra start when they are first used.
STATUS = ("Umask", "Uid", "Gid", "Groups", "SigBlk", "SigIgn", "SigCgt", "NoNewPrivs", "Cpus_allowed", "Seccomp",
    "Seccomp_filters", "CapInh", "CapPrm", "CapEff", "CapBnd", "CapAmb")
status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
own = {name for name, value in os.environ.items() if value.startswith(os.environ["TMPDIR"])}
seen = {
    "status": {name: status.get(name, "").strip() for name in STATUS},
    # That of memory is chosen by how much the process has.
    "limits": {name: resource.getrlimit(getattr(resource, name)) for name in dir(resource)
        if name.startswith("RLIMIT_") and name != "RLIMIT_DATA"},
    "priority": os.getpriority(os.PRIO_PROCESS, 0),
    "killing": Path("/proc/self/oom_score_adj").read_text(),
    "folder": os.getcwd(),
    "environment": {name: value for name, value in os.environ.items() if name not in own} | dict.fromkeys(own),
    "temporary": tempfile.gettempdir() == os.environ["TMPDIR"],
    "numba": sys.modules["numba"].config.CACHE_DIR == os.environ["NUMBA_CACHE_DIR"],
    "descriptors": sorted(map(str, filter(None, map(kind, map(int, os.listdir("/proc/self/fd")))))),
    "leads": os.getsid(0) == os.getpid() == os.getpgid(0),
    "handlers": {each.name: repr(signal.getsignal(each)).split(" at ")[0] for each in signal.Signals},
    "threads": [type(each).__name__ for each in threading.enumerate()],
    "path": sys.path, "flags": str(sys.flags), "writes no bytecode": sys.dont_write_bytecode,
    "streams": [(each.encoding, each.errors, each.line_buffering) for each in (sys.stdin, sys.stdout, sys.stderr)],
    "collects garbage": gc.isenabled(),
    "product": float((np.ones((400, 400)) @ np.ones((400, 400))).sum()),
}
print(json.dumps([seen, random.random(), float(np.random.random())]), flush=True)
os._exit(3)
"""
STEPPING = """
import os
from pathlib import Path
from drivegate import Command
{top}
class Mine:
    def reset(self, nameplate):
        pass
    def step(self, sense):
        {step}
        return Command({answer}, 0.0)
"""


@pytest.fixture(autouse=True)
def own_templates(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, no_process_left: None
) -> Iterator[Templates]:
    """Begin without a template, and leave none."""
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    own = Templates()
    assert copies() == []
    monkeypatch.setattr(kept_process, "TEMPLATES", own)
    yield own
    for template in own.started():
        template.end()


@pytest.fixture
def judge(tmp_path: Path) -> Iterator[Callable[..., Judge]]:
    """Make a judge of a candidate in Python from its source."""
    made: list[Judge] = []

    def make(source: str) -> Judge:
        file = tmp_path / "mine.py"
        file.write_text(source, encoding="utf-8")
        made.append(Judge(resolve_candidate(f"{file}:Mine")))
        return made[-1]

    yield make
    for each in made:
        each.kill()


@pytest.fixture
def look(judge: Callable[..., Judge]) -> Callable[[], tuple[dict[str, Any], list[float]]]:
    """Return what a candidate finds around it in the next process that is started, and what it draws."""

    def looked() -> tuple[dict[str, Any], list[float]]:
        fault = judge(LOOKING).once(Job(worker_jobs.drive, 1))
        assert isinstance(fault, Fault), fault
        seen, *drawn = json.loads(fault.traceback)
        return seen, drawn

    return looked


@pytest.mark.one_in(2)
@pytest.mark.parametrize("isolation", ["auto", "none"])
def test_a_copy_finds_around_it_what_a_new_process_finds(
    look: Callable[[], Any], own_templates: Templates, monkeypatch: pytest.MonkeyPatch, isolation: str
) -> None:
    monkeypatch.setenv(ISOLATION_VARIABLE, isolation)
    opened, other = os.pipe()
    os.set_inheritable(opened, True)
    try:
        new, _ = look()
        assert not own_templates.started()
        copied, drawn = look()
        assert own_templates.started()
        assert copies() != [], "the template is not found, so that no copy would be"
        again, drawn_again = look()
    finally:
        os.close(opened)
        os.close(other)
    assert copied == new
    assert again == new
    assert not set(drawn) & set(drawn_again), "copies draw the same numbers"


@pytest.mark.nightly
def test_a_copy_has_what_the_harness_has_changed_since(look: Callable[[], Any]) -> None:
    look(), look()
    limits = resource.getrlimit(resource.RLIMIT_NOFILE)
    mask = os.umask(0o027)
    resource.setrlimit(resource.RLIMIT_NOFILE, (200, limits[1]))
    try:
        for _ in range(3):
            seen, _ = look()
            assert seen["status"]["Umask"] == "0027"
            assert seen["limits"]["RLIMIT_NOFILE"][0] == 200
    finally:
        os.umask(mask)
        resource.setrlimit(resource.RLIMIT_NOFILE, limits)


def test_a_judge_that_is_a_copy_finds_around_it_what_a_new_one_finds(
    own_templates: Templates, monkeypatch: pytest.MonkeyPatch
) -> None:
    def looked(jobs: int) -> list[object]:
        with WorkerPool(resolve_candidate("initial"), workers=jobs) as pool:
            return list(pool.map([Job(worker_jobs.surroundings, None)] * jobs))

    monkeypatch.setenv("SECRET", "first")
    (new,) = looked(1)
    assert not own_templates.started()
    (copied,) = looked(1)
    assert own_templates.started()
    assert copied == new
    monkeypatch.setenv("SECRET", "second")
    (later,) = looked(1)
    assert later == new | {"environment": dict(os.environ)}


def test_judges_that_start_together_are_copies(own_templates: Templates) -> None:
    with WorkerPool(resolve_candidate("initial"), workers=2) as pool:
        found = list(pool.map([Job(worker_jobs.surroundings, None)] * 2))
    assert len(own_templates.started()) == 1
    assert found[0] == found[1]


@pytest.mark.one_in(2)
@pytest.mark.parametrize("kind", ["own", "python"])
def test_a_judge_that_is_a_copy_has_what_was_prepared_before_it_started(
    own_templates: Templates, tmp_path: Path, kind: str
) -> None:
    (tmp_path / "mine.py").write_text(STEPPING.format(top="", step="pass", answer="1.0"), encoding="utf-8")
    candidate = resolve_candidate("initial" if kind == "own" else f"{tmp_path / 'mine.py'}:Mine")

    def prepared(what: str) -> object:
        preparation = Preparation(worker_jobs.__name__, "prepare", what)
        with WorkerPool(candidate, workers=1, preparation=preparation) as pool:
            started = [template.pid for template in own_templates.started()]
            (found,) = pool.map([Job(worker_jobs.prepared, None)])
            assert [template.pid for template in own_templates.started()] == started, "prepared too late"
        return found

    assert prepared("first") == [], "what nobody copies is not prepared"
    assert prepared("first") == ["first"]
    assert prepared("nothing") == ["first"], "what cannot be prepared ends no check"
    assert prepared("second") == ["first", "second"]
    assert prepared("first") == ["first", "second"], "it is prepared once"


def test_judges_of_a_check_have_its_kernels_before_they_start(own_templates: Templates) -> None:
    drive = load_drive("star-3-phase")
    candidate = resolve_candidate(contract_of(drive).usual_candidate)
    job = Job(worker_jobs.kernels_loaded, drive.kind)
    with WorkerPool(candidate, workers=2) as pool:
        assert all(found > 0 for found in pool.map([job] * 2)), "nothing has to be loaded"
    with WorkerPool(candidate, workers=2, preparation=judges_on(drive)) as pool:
        assert list(pool.map([job] * 2)) == [0, 0]


UNSTEADY = {
    # Of an object that the template has. Where a copy puts its own ones depends on when messages arrive.
    "addresses": "(id(Path) >> 12) % 65521 / 65521",
    "layout": "int(Path('/proc/self/maps').read_text()[:12], 16) / 4096 % 65521 / 65521",
    "hashes": "hash('x') % 65521 / 65521",
}


@pytest.mark.nightly
@pytest.mark.parametrize("source", UNSTEADY)
def test_what_copies_share_does_not_pass_for_deterministic(
    judge: Callable[..., Judge], monkeypatch: pytest.MonkeyPatch, source: str
) -> None:
    monkeypatch.setenv("PYTHONHASHSEED", "random")
    scenario = fixed_scenarios(load_drive("paper-5-phase"))[0].model_copy(update={"duration_s": 0.1})
    answer = f"1.0 + sense.time * ({UNSTEADY[source]})"
    checked = judge(STEPPING.format(top="", step="pass", answer=answer))

    def digest(job: Job[Repetition], *, is_copy: bool) -> int:
        checked.kill()
        ending = checked.once(job)
        assert isinstance(ending, Repetition), ending
        assert isinstance(checked._process._handle._kept.keeper, CopiedKeeper) is is_copy
        return ending.digest

    repetition = repetition_job(scenario)
    run = replace(repetition, afresh=False)
    digest(run, is_copy=False)
    first, second = digest(run, is_copy=True), digest(run, is_copy=True)
    assert first == second, "copies do not share it, so that this shows nothing"
    repeated = [digest(repetition, is_copy=False) for _ in range(2)]
    assert len({first, *repeated}) == 3


@pytest.mark.nightly
@pytest.mark.parametrize("harm", [signal.SIGKILL, signal.SIGSTOP])
def test_without_its_template_a_candidate_has_a_new_process(
    judge: Callable[..., Judge], own_templates: Templates, monkeypatch: pytest.MonkeyPatch, harm: int
) -> None:
    judged = judge(STEPPING.format(top="", step="pass", answer="1.0"))
    for _ in range(2):
        assert judged.once(Job(worker_jobs.drive, 2)) == 2.0
        judged.kill()
    (template,) = own_templates.started()
    monkeypatch.setattr(templates, "_PATIENCE", 2.0)
    os.kill(template.pid, harm)
    for _ in range(3):
        assert judged.once(Job(worker_jobs.drive, 2)) == 2.0
        judged.kill()
    assert not own_templates.started()


HARNESS = """
import sys
from pathlib import Path
from tests.harness import worker_jobs
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
with Judge(resolve_candidate(sys.argv[1])) as judge:
    judge.run(Job(worker_jobs.drive, 1))
    judge.kill()
    Path(sys.argv[2]).touch()
    judge.run(Job(worker_jobs.drive, 1))
"""


@pytest.mark.one_in(2)
@pytest.mark.parametrize("ending", [signal.SIGKILL, signal.SIGTERM])
def test_a_template_and_its_copies_end_with_the_harness(tmp_path: Path, ending: int) -> None:
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    file = tmp_path / "mine.py"
    daemon = (
        "import subprocess, time; subprocess.Popen(['setsid', 'sleep', '65431'], env={}); time.sleep(1000)"
    )
    step = f"if Path({str(tmp_path / 'now')!r}).exists(): {daemon}"
    file.write_text(STEPPING.format(top="", step=step, answer="1.0"), encoding="utf-8")
    words = [sys.executable, "-c", HARNESS, f"{file}:Mine", str(tmp_path / "now")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path), "TMPDIR": str(scratch)}
    harness = subprocess.Popen(words, env=environment)

    def below() -> list[psutil.Process]:
        return psutil.Process(harness.pid).children(recursive=True)

    until = time.monotonic() + 60.0
    while not any("65431" in _words(each) for each in below()):
        assert time.monotonic() < until, "the daemon did not begin"
        time.sleep(0.05)
    kept = below()
    assert any("offer_copies" in word for each in kept for word in _words(each))
    harness.send_signal(ending)
    harness.wait(30)
    _, alive = psutil.wait_procs(kept, timeout=15)
    assert alive == [], "processes outlived the harness"
    assert list(scratch.iterdir()) == [], "a temporary folder outlived the harness"


def _words(process: psutil.Process) -> list[str]:
    try:
        return process.cmdline()
    except psutil.Error:
        return []
