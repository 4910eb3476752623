"""A machine with too little memory is no verdict on a candidate, and decides how many workers start."""

from __future__ import annotations

import os
import resource
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from tests.harness import worker_jobs

from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment import candidate_process, judge_process, machine_memory
from drivegate.containment.judge import Judge
from drivegate.containment.machine_memory import (
    BASE_BYTES,
    WORKER_BYTES,
    is_for_memory,
    killed_for_memory,
    memory_limit,
    usual_workers,
)
from drivegate.containment.messages import Job
from drivegate.containment.pool import WorkerPool
from drivegate_models.errors import OutOfMemory

GIBIBYTE = 2**30
ALLOWED = 4 * GIBIBYTE


@pytest.fixture
def machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A machine whose control groups are files of the test."""
    monkeypatch.setattr(machine_memory, "_CONTROL_GROUPS", tmp_path / "cgroup")
    monkeypatch.setattr(machine_memory, "_PROC", tmp_path / "proc")
    (tmp_path / "proc" / "self").mkdir(parents=True)
    (tmp_path / "proc" / "vmstat").write_text("pgfault 7\noom_kill 4\n", encoding="ascii")
    return tmp_path


def put_into(machine: Path, lines: str, folder: str, **files: str) -> None:
    (machine / "proc" / "self" / "cgroup").write_text(lines, encoding="ascii")
    place = machine / "cgroup" / folder
    place.mkdir(parents=True, exist_ok=True)
    for name, content in files.items():
        (place / name.replace("_", ".", 1)).write_text(content, encoding="ascii")


@pytest.mark.parametrize(
    ("lines", "folder", "limit", "events"),
    [
        ("0::/box/inner\n", "box", "memory_max", "memory_events"),
        ("0::/\n", ".", "memory_max", "memory_events"),
        (
            "4:cpu:/x\n3:memory:/box/inner\n0::/\n",
            "memory/box",
            "memory_limit_in_bytes",
            "memory_oom_control",
        ),
    ],
)
def test_the_control_groups_of_a_container_limit_the_memory(
    machine: Path, lines: str, folder: str, limit: str, events: str
) -> None:
    put_into(machine, lines, folder, **{limit: f"{GIBIBYTE}\n", events: "low 0\noom 3\noom_kill 2\n"})
    assert memory_limit() == GIBIBYTE
    assert killed_for_memory() == 2


def test_without_control_groups_the_machine_counts(machine: Path) -> None:
    assert memory_limit() > GIBIBYTE
    assert killed_for_memory() == 4
    put_into(machine, "0::/\n", ".", memory_max="max\n")
    assert memory_limit() > GIBIBYTE


@pytest.mark.parametrize(
    ("workers_of_memory", "workers"), [(0, 1), (1, 1), (3, 3), (10_000, os.cpu_count() or 1)]
)
def test_fewer_workers_start_where_the_memory_is_short(
    monkeypatch: pytest.MonkeyPatch, workers_of_memory: int, workers: int
) -> None:
    monkeypatch.setattr(os, "cpu_count", lambda: max(workers, 4) if workers_of_memory < 100 else workers)
    monkeypatch.setattr(machine_memory, "memory_limit", lambda: BASE_BYTES + workers_of_memory * WORKER_BYTES)
    assert usual_workers() == workers


def test_a_check_does_not_begin_where_the_memory_does_not_suffice(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(machine_memory, "memory_limit", lambda: 256 * 2**20)
    with pytest.raises(
        OutOfMemory, match=r"of 256 MB here; give it more, or name fewer workers with --workers"
    ):
        WorkerPool(resolve_candidate("foc"), workers=1)


@pytest.mark.parametrize(
    ("error", "message", "free", "for_memory"),
    [
        ("MemoryError", "MemoryError", GIBIBYTE, True),
        ("MemoryError", "MemoryError", ALLOWED, False),
        ("ImportError", "failed to map segment from shared object", GIBIBYTE, True),
        ("OSError", "[Errno 12] Cannot allocate memory", GIBIBYTE, True),
        ("SIGABRT", "terminate called: std::bad_alloc", GIBIBYTE, True),
        ("SIGSEGV", "the process was killed by SIGSEGV", 2**20, True),
        ("SIGSEGV", "the process was killed by SIGSEGV", GIBIBYTE, False),
        ("SIGSEGV", "the process was killed by SIGSEGV", ALLOWED, False),
        ("ValueError", "wrong", 2**20, False),
    ],
)
def test_only_a_machine_that_gives_less_than_is_allowed_excuses_a_fault(
    error: str, message: str, free: int, for_memory: bool
) -> None:
    fault = Fault(FaultKind.CRASH, message, "step", error=error)
    assert is_for_memory(fault, free, ALLOWED) is for_memory


CONTROLLER = """
import os, signal
from drivegate import Command

class Mine:
    def reset(self, nameplate):
        pass

    def step(self, sense):
        {statement}
        return Command(1.0, 0.5)
"""

COMPILED = """
#include "drivegate.h"
#include <stdio.h>
#include <stdlib.h>

int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }

int64_t drivegate_state_size(void) { return 8; }

int drivegate_reset(void *state, const drivegate_nameplate *nameplate) {
    char *table = malloc((size_t)3990 << 20);
    if (!table) {
        fputs("out of memory", stderr);
        abort();
    }
    *(char *)state = table[0];
    return 0;
}

void drivegate_step(void *state, const drivegate_sense *sense, drivegate_command *command) {
    command->current_reference = 1.0;
}
"""


def python(folder: Path, statement: str) -> str:
    file = folder / "mine.py"
    file.write_text(CONTROLLER.format(statement=statement), encoding="utf-8")
    return f"{file}:Mine"


@contextmanager
def limited_addresses(size: int) -> Iterator[None]:
    before = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, before)


def test_a_candidate_that_the_system_kills_for_memory_is_not_accused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DRIVEGATE_ISOLATION", "none")
    killed = python(tmp_path, "os.kill(os.getpid(), signal.SIGKILL)")
    with Judge(resolve_candidate(killed)) as judge:
        fault = judge.run(Job(worker_jobs.drive, 3))
    assert isinstance(fault, Fault)
    assert fault.kind is FaultKind.CRASH, "nothing shows that memory was short"
    counts = iter((0, 1))
    monkeypatch.setattr(candidate_process, "killed_for_memory", lambda: next(counts))
    with Judge(resolve_candidate(killed)) as judge, pytest.raises(OutOfMemory, match="the system killed"):
        judge.run(Job(worker_jobs.drive, 3))


def test_a_judge_that_the_system_kills_for_memory_accuses_nobody(monkeypatch: pytest.MonkeyPatch) -> None:
    counts = iter((0, 1))
    monkeypatch.setattr(judge_process, "killed_for_memory", lambda: next(counts))
    with (
        WorkerPool(resolve_candidate("reference"), workers=1) as pool,
        pytest.raises(OutOfMemory, match="the system killed a worker"),
    ):
        list(pool.map([Job(worker_jobs.kill_this_process, None)]))


@pytest.mark.parametrize("code", ["python", "compiled"])
def test_a_limit_of_addresses_is_no_fault_of_a_candidate(tmp_path: Path, code: str) -> None:
    file = tmp_path / "mine.c"
    file.write_text(COMPILED, encoding="utf-8")
    named = str(file) if code == "compiled" else python(tmp_path, "bytearray(3990 * 2**20)")
    with (
        limited_addresses(4 * GIBIBYTE),
        Judge(resolve_candidate(named)) as judge,
        pytest.raises(OutOfMemory, match=r"refused an allocation .*4096 MB of addresses or data"),
    ):
        judge.run(Job(worker_jobs.drive, 3))
