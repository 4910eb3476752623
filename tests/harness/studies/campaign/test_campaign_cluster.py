"""A campaign on a dask cluster of real worker processes, one of which is killed while it works."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest


def wait_until(condition, process) -> None:
    deadline = time.monotonic() + 120.0
    while not condition():
        assert process.poll() is None, "it ended too early"
        assert time.monotonic() < deadline, "it makes no progress"
        time.sleep(0.02)


@pytest.fixture
def cluster(folder: Path):
    """A scheduler and two workers on the loopback interface."""
    place = folder / "scheduler.json"
    processes = []

    def begin(*words: object) -> "subprocess.Popen[bytes]":
        command = [sys.executable, "-m", *map(str, words)]
        log = (folder / f"process-{len(processes)}.log").open("wb")
        process = subprocess.Popen(command, cwd=folder, stdout=log, stderr=log)
        log.close()
        processes.append(process)
        return process

    scheduler = begin(
        "distributed.cli.dask_scheduler",
        *("--host", "127.0.0.1", "--port", 0, "--no-dashboard", "--scheduler-file", place),
    )
    wait_until(place.exists, scheduler)
    worker = ("distributed.cli.dask_worker", "--scheduler-file", place, "--no-dashboard", "--no-nanny")
    workers = [begin(*worker, "--nthreads", 1, "--host", "127.0.0.1") for _ in range(2)]
    yield json.loads(place.read_text(encoding="utf-8"))["address"], workers
    for process in processes:
        process.kill()
        process.wait()


@pytest.mark.nightly
def test_a_killed_worker_costs_no_result_and_the_bytes_are_the_local_ones(
    write, start, finish, folder, cluster, bytes_of
):
    address, workers = cluster
    file = write(
        candidates=["reference", "controllers.py:Counting"],
        cases=["fig5-search"],
        draws=4,
        runs_per_file=2,
        checks=["CMD-1", "ROB-1"],
    )
    finish(file, "local")
    process = start("campaign", file, "--output", "out", "--backend", "dask", "--scheduler", address)
    wait_until(lambda: any((folder / "out").rglob("*.parquet")), process)
    os.kill(workers[0].pid, signal.SIGKILL)
    assert len(list((folder / "out").rglob("*.parquet"))) < 4, "it was killed when all was done"
    _, err = process.communicate(timeout=200)
    assert process.returncode == 0, err
    local, out = bytes_of(folder / "local"), bytes_of(folder / "out")
    assert out == local, f"these differ: {[name for name in local if out.get(name) != local[name]]}"


@pytest.mark.nightly
def test_no_scheduler_is_one_sentence(write, refused, monkeypatch):
    monkeypatch.setattr("drivegate.containment.backend._CONNECTION_SECONDS", 1.0)
    sentence = refused(write(), "--backend", "dask", "--scheduler", "tcp://127.0.0.1:9")
    assert "no dask scheduler answers at tcp://127.0.0.1:9" in sentence
