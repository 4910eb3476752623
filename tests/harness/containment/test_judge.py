"""Faults of a candidate stay in its process, each with its verdict; the next job works again."""

import contextlib
import os
import subprocess
import sys
import tempfile
import time

import psutil
import pytest
from tests.harness import worker_jobs
from tests.harness.beside_templates import template_files

from drivegate.candidates.fault import FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment import judge_process
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate.containment.pool import WorkerPool
from drivegate.containment.watches import WorkerLimits
from drivegate_models.compilation.kernels import kernel_digests, required_cache_folder
from drivegate_models.errors import HarnessFault, InputError

QUICK = WorkerLimits(
    step_processor_seconds=0.3, start_processor_seconds=20.0, idle_seconds=20.0, memory_bytes=2**30
)
BORN = "BORN = float(time.monotonic_ns())"
NORMAL, WITH_FAULT = 3, 7
"""Steps of a run that ends before the fault, and of one that comes to it."""


@pytest.fixture(autouse=True)
def surroundings(monkeypatch, tmp_path, no_process_left):
    """Hold the tests to leaving nothing behind."""
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(scratch))
    monkeypatch.setenv("TMPDIR", str(scratch))
    open_before = open_files()
    yield
    assert list(scratch.iterdir()) == [], "a temporary file is left"
    assert open_files() <= open_before, "a file is left open"


def open_files():
    """Count the open files, without connections to templates, which stay for the next test."""
    return psutil.Process().num_fds() - len(template_files())


@pytest.fixture
def candidate(tmp_path):
    """Make a candidate that counts its steps and does something particular in the fifth."""

    def make(fault="pass", *, reset="pass", top="pass", init="pass", answer="1.0"):
        file = tmp_path / "mine.py"
        file.write_text(
            f"""
import ctypes, math, os, subprocess, sys, time
from drivegate import Command
{top}
class Mine:
    def __init__(self):
        {init}
    def reset(self, nameplate):
        self.count = 0
        {reset}
    def step(self, sense):
        self.count += 1
        if self.count == 5:
            {fault}
        return Command({answer}, 0.5)
""",
            encoding="utf-8",
        )
        return resolve_candidate(f"{file}:Mine")

    return make


def worker_of(candidate, limits=QUICK):
    return Judge(candidate, limits=limits)


FAULTS_IN_STEP = {
    "raise": ("raise ValueError('gain')", FaultKind.EXCEPTION, "ValueError: gain"),
    "exit": ("sys.exit(3)", FaultKind.EXCEPTION, "SystemExit: 3"),
    "none": ("return None", FaultKind.INVALID_OUTPUT, "step returned None"),
    "nan": ("return Command(math.nan, 0.0)", FaultKind.INVALID_OUTPUT, "current_reference is nan"),
    "infinity": ("return Command(0.0, math.inf)", FaultKind.INVALID_OUTPUT, "advance_angle is inf"),
    "text": ("return Command('1', 0.0)", FaultKind.INVALID_OUTPUT, "current_reference is of type str"),
    "end": (
        "os._exit(5)",
        FaultKind.CRASH,
        "the process ended itself with exit status 5 after 4 completed steps",
    ),
    "end well": ("os._exit(0)", FaultKind.CRASH, "the process ended itself with exit status 0"),
    "segfault": (
        "ctypes.string_at(0)",
        FaultKind.CRASH,
        "the process was killed by SIGSEGV (Segmentation fault)",
    ),
    "abort": ("os.abort()", FaultKind.CRASH, "the process was killed by SIGABRT (Aborted)"),
    "loop": (
        "while True: pass",
        FaultKind.HANG,
        "no progress within 0.3 s of processor time after 4 completed",
    ),
    "memory": ("bytearray(10 * 2**30)", FaultKind.EXCEPTION, "MemoryError (a candidate may allocate 1 GiB)"),
    "leak": ("self.all = [bytes(2**20) for _ in range(10_000)]", FaultKind.EXCEPTION, "MemoryError"),
}


@pytest.mark.parametrize("fault", FAULTS_IN_STEP)
def test_a_fault_in_a_step_gets_its_verdict_and_the_next_job_works(candidate, fault):
    statement, kind, message = FAULTS_IN_STEP[fault]
    with worker_of(candidate(statement)) as worker:
        assert worker.run(Job(worker_jobs.drive, NORMAL)) == 3.0
        outcome = worker.run(Job(worker_jobs.drive, WITH_FAULT))
        assert worker.run(Job(worker_jobs.drive, NORMAL)) == 3.0
    assert (outcome.kind, outcome.phase) == (kind, "step")
    assert outcome.message.startswith(message)
    assert outcome.step == 4
    assert outcome.time == pytest.approx(4 * 0.0005)
    assert outcome.sense["phase_currents"] == (1.0,) * 5


@pytest.mark.parametrize("fault", ["raise", "segfault", "loop"])
def test_the_place_of_a_fault_is_reported(candidate, fault):
    with worker_of(candidate(FAULTS_IN_STEP[fault][0])) as worker:
        outcome = worker.run(Job(worker_jobs.drive, WITH_FAULT))
    assert "mine.py" in outcome.traceback
    assert "in step" in outcome.traceback


@pytest.mark.parametrize(
    ("where", "statement", "kind", "phase"),
    [
        ("reset", "raise ValueError('gain')", FaultKind.EXCEPTION, "reset"),
        ("reset", "ctypes.string_at(0)", FaultKind.CRASH, "reset"),
        ("reset", "bytearray(10 * 2**30)", FaultKind.EXCEPTION, "reset"),
        ("init", "raise ValueError('gain')", FaultKind.EXCEPTION, "loading"),
        ("init", "os._exit(1)", FaultKind.CRASH, "loading"),
        ("top", "raise ValueError('gain')", FaultKind.EXCEPTION, "loading"),
        ("top", "sys.exit()", FaultKind.EXCEPTION, "loading"),
        ("top", "os.kill(os.getpid(), 9)", FaultKind.CRASH, "loading"),
        ("top", "block = bytearray(10 * 2**30)", FaultKind.EXCEPTION, "loading"),
    ],
)
def test_a_fault_before_the_first_step_gets_its_verdict(candidate, where, statement, kind, phase):
    with worker_of(candidate(**{where: statement})) as worker:
        outcome = worker.run(Job(worker_jobs.drive, NORMAL))
    assert (outcome.kind, outcome.phase) == (kind, phase)
    assert (outcome.step, outcome.time, outcome.sense) == (None, None, None)


def test_a_run_that_never_ends_is_a_hang(candidate):
    with worker_of(
        candidate(answer="time.sleep(1e-3) or 1.0"), WorkerLimits(order_seconds=6.0, order_step_seconds=0.0)
    ) as worker:
        outcome = worker.once(Job(worker_jobs.drive, 10**5))
    assert outcome.message.startswith("the run did not end within 6 s after")


def test_a_hang_is_tried_once_more(candidate, tmp_path, not_isolated):
    mark = tmp_path / "tried"
    once = f"if not os.path.exists({str(mark)!r}): open({str(mark)!r}, 'w').close(); time.sleep(1000)"
    with worker_of(candidate(once), WorkerLimits(idle_seconds=2.0)) as worker:
        assert worker.run(Job(worker_jobs.drive, WITH_FAULT)) == 7.0


def test_a_candidate_that_cannot_be_used_is_refused(candidate):
    with worker_of(candidate(top="import absent_module")) as worker:
        for _ in range(2):
            with pytest.raises(InputError, match="No module named 'absent_module'"):
                worker.run(Job(worker_jobs.drive, NORMAL))


def test_the_same_process_does_many_jobs_each_with_a_new_instance(candidate):
    once = "assert not hasattr(self, 'used'); self.used = True"
    with worker_of(candidate(top=BORN, reset=once, answer="BORN")) as worker:
        births = {worker.run(Job(worker_jobs.drive, 1)) for _ in range(5)}
    assert len(births) == 1
    assert "mine" not in sys.modules, "the candidate's code ran beside what judges it"


def test_what_a_candidate_prints_stays_out_of_the_output(candidate, capfd):
    loud = "for _ in range(300): print('x' * 1000); os.write(1, b'y' * 1000); os.write(2, b'z' * 1000)"
    with worker_of(candidate(loud)) as worker:
        assert worker.run(Job(worker_jobs.drive, WITH_FAULT)) == 7.0
    assert capfd.readouterr() == ("", "")


def test_a_candidate_that_closes_its_output_does_no_harm(candidate):
    with worker_of(candidate("os.close(1); os.close(2)")) as worker:
        assert worker.run(Job(worker_jobs.drive, WITH_FAULT)) == 7.0


def test_processes_that_a_candidate_starts_end_with_it(candidate):
    # No other process of this machine sleeps for as long.
    sleep = ["sleep", f"98765.{os.getpid()}"]
    with worker_of(candidate(f"subprocess.Popen({sleep}); os._exit(1)")) as worker:
        assert worker.run(Job(worker_jobs.drive, WITH_FAULT)).kind is FaultKind.CRASH
    commands = [process.info["cmdline"] for process in psutil.process_iter(["cmdline"])]
    assert sleep not in commands


@pytest.mark.parametrize(
    ("target", "reason"), [("harness_error", "LookupError: a mistake"), ("unpicklable", "lambda")]
)
def test_an_error_of_the_harness_is_no_verdict_on_the_candidate(candidate, target, reason):
    with WorkerPool(candidate(), workers=1, limits=QUICK) as pool:
        with pytest.raises(HarnessFault, match=reason):
            list(pool.map([Job(getattr(worker_jobs, target), None)]))
        assert list(pool.map([Job(worker_jobs.drive, NORMAL)])) == [3.0]


def test_an_input_error_of_a_job_reaches_the_user(candidate):
    with worker_of(candidate()) as worker, pytest.raises(InputError, match="the scenario is wrong"):
        worker.run(Job(worker_jobs.user_error, None))


def test_a_judge_that_is_forgotten_ends(candidate):
    worker = worker_of(candidate())
    assert worker.run(Job(worker_jobs.drive, NORMAL)) == 3.0
    del worker


def test_a_candidate_has_its_garbage_collected_but_not_the_harness(candidate):
    collected = "float(gc.isenabled() and gc.get_freeze_count() > 10000)"
    with worker_of(candidate(top="import gc", answer=collected)) as worker:
        assert worker.run(Job(worker_jobs.drive, NORMAL)) == 3.0


def has_ended(process):
    try:
        return process.status() == psutil.STATUS_ZOMBIE
    except psutil.NoSuchProcess:
        return True


def test_a_judge_whose_idle_process_died_starts_another(candidate):
    with worker_of(candidate(top=BORN, answer="BORN")) as worker:
        first = worker.run(Job(worker_jobs.drive, 1))
        process = psutil.Process(worker._process._handle._kept.process_id)
        process.kill()
        deadline = time.monotonic() + 30
        while not has_ended(process):
            assert time.monotonic() < deadline, process
            time.sleep(0.01)
        second = worker.run(Job(worker_jobs.drive, 1))
        assert isinstance(second, float), second
        assert second > first


def keeps_a_candidate(process):
    with contextlib.suppress(psutil.NoSuchProcess):
        return "candidate" in process.cmdline()
    return False


def test_a_judge_in_an_endless_loop_dies_with_its_parent(candidate):
    script = (
        "from tests.harness import worker_jobs; from drivegate.candidates.resolution import resolve_candidate; "
        "from drivegate.containment.judge import Judge; from drivegate.containment.messages import Job; "
        f"candidate = resolve_candidate({candidate('while True: pass').specification!r}); "
        "Judge(candidate).run(Job(worker_jobs.drive, 7))"
    )
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    parent = subprocess.Popen([sys.executable, "-c", script], env=environment)
    deadline = time.monotonic() + 30
    children = []
    while not children and time.monotonic() < deadline:
        time.sleep(0.05)
        # Processes that try what the machine allows end by themselves.
        children = [child for child in psutil.Process(parent.pid).children() if keeps_a_candidate(child)]
    time.sleep(0.5)
    parent.kill()
    parent.wait()
    _, alive = psutil.wait_procs(children, timeout=10)
    assert children != []
    assert alive == [], "the worker outlived its parent"


def test_a_judge_that_stands_still_is_a_fault(candidate, monkeypatch):
    monkeypatch.setattr(judge_process, "_STILL_SECONDS", 0.5)
    with WorkerPool(candidate(), workers=1, limits=QUICK) as pool:
        (fault,) = pool.map([Job(worker_jobs.wait_for_the_system, None)])
    assert fault.kind is FaultKind.HANG
    assert "did nothing for" in fault.message


def test_kernels_that_a_candidate_changes_without_isolation_are_removed(candidate, tmp_path, not_isolated):
    folder = required_cache_folder()
    before = kernel_digests()
    top = f"open({str(folder / 'attack.nbi')!r}, 'w').write('x'); os._exit(1)"
    with WorkerPool(candidate(top=top), workers=1, limits=QUICK) as pool:
        (fault,) = pool.map([Job(worker_jobs.drive, NORMAL)])
        assert (folder / "attack.nbi").exists()
    assert fault.kind is FaultKind.CRASH
    assert not (folder / "attack.nbi").exists()
    after = kernel_digests()
    assert {name: after.get(name) for name in before} == before, "kernels that nobody changed were removed"


@pytest.mark.parametrize("workers", [1, 2, 3])
def test_a_pool_gives_results_in_the_order_of_its_jobs(candidate, workers):
    with WorkerPool(candidate(), workers=workers, limits=QUICK) as pool:
        assert list(pool.map(Job(worker_jobs.sleep_by_turns, index) for index in range(9))) == list(range(9))


def test_a_pool_goes_on_after_crashes_and_hangs(candidate):
    fault = "os._exit(1)"
    steps = [NORMAL, WITH_FAULT, NORMAL, WITH_FAULT, NORMAL]
    with WorkerPool(candidate(fault), workers=2, limits=QUICK) as pool:
        outcomes = list(pool.map([Job(worker_jobs.drive, number) for number in steps]))
    assert outcomes[::2] == [3.0] * 3
    assert [outcome.kind for outcome in outcomes[1::2]] == [FaultKind.CRASH] * 2


def test_a_pool_gives_a_hang_in_the_second_try_to_all_jobs_that_wait(candidate):
    steps = [NORMAL, WITH_FAULT, NORMAL, NORMAL]
    with WorkerPool(candidate("while True: pass"), workers=1, limits=QUICK) as pool:
        outcomes = list(pool.map([Job(worker_jobs.drive, number) for number in steps]))
        later = list(pool.map([Job(worker_jobs.drive, NORMAL)]))
    assert outcomes[0] == 3.0
    assert outcomes[1].kind is FaultKind.HANG
    assert outcomes[2:] == [outcomes[1]] * 2, "nobody waits for the same hang again"
    assert later == [outcomes[1]], "neither does a later part of the same check"


def test_a_pool_tries_a_hang_again_with_nothing_beside_it(candidate, tmp_path, not_isolated):
    mark = tmp_path / "tried"
    once = f"while not os.path.exists({str(mark)!r}) or self.looping: self.looping = open({str(mark)!r}, 'w')"
    steps = [WITH_FAULT, NORMAL, NORMAL, NORMAL]
    hanging = candidate(once, reset="self.looping = None")
    with WorkerPool(hanging, workers=2, limits=QUICK) as pool:
        (total, began, ended), *others = pool.map([Job(worker_jobs.drive_slowly, number) for number in steps])
    assert total == 7.0
    assert [other[0] for other in others] == [3.0] * 3
    beside = [(start, end) for _, start, end in others if start < ended and end > began]
    assert beside == [], "other jobs ran while the suspected one was tried again"


def test_a_pool_gives_a_fault_while_loading_to_all_jobs_without_repeating_it(
    candidate, tmp_path, not_isolated
):
    top = f"open({str(tmp_path / 'loads')!r}, 'a').write('x'); os._exit(1)"
    with WorkerPool(candidate(top=top), workers=2, limits=QUICK) as pool:
        outcomes = list(pool.map([Job(worker_jobs.drive, NORMAL)] * 20))
    assert {(outcome.kind, outcome.phase) for outcome in outcomes} == {(FaultKind.CRASH, "loading")}
    assert len(outcomes) == 20
    assert len((tmp_path / "loads").read_text(encoding="utf-8")) <= 2


def test_a_pool_may_be_left_early_and_used_again(candidate):
    with WorkerPool(candidate("time.sleep(1000)"), workers=2) as pool:
        results = pool.map([Job(worker_jobs.drive, number) for number in (NORMAL, WITH_FAULT, WITH_FAULT)])
        assert next(results) == 3.0
        results.close()
        assert list(pool.map([Job(worker_jobs.drive, NORMAL)] * 3)) == [3.0] * 3


def test_a_pool_without_jobs_starts_nothing(candidate):
    with WorkerPool(candidate(), workers=2) as pool:
        assert list(pool.map([])) == []


def test_a_slow_run_is_reported_while_it_runs(candidate):
    # Its steps take 50 ms, and the 150th raises, which no wait for a hang comes after.
    slow = candidate(answer="1.0 / (self.count < 150) + (time.sleep(0.05) or 0.0)")
    limits = WorkerLimits(order_seconds=100.0, order_step_seconds=0.0)
    stated = []
    with WorkerPool(slow, workers=2, limits=limits, on_slow=stated.append) as pool:
        endings = list(pool.map([Job(worker_jobs.drive, 4000), Job(worker_jobs.drive, 4000)]))
    assert [ending.error for ending in endings] == ["ZeroDivisionError"] * 2
    (run,) = stated
    assert (run.steps, run.allowed_seconds) == (4000, 100.0)
    # Steps are counted in whole ones between two looks, so the pace is known to one step in some.
    assert run.seconds > 150.0, "a step takes 50 ms and what a busy machine adds"
