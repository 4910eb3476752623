"""Files of compiled kernels, and the lock of those who compile them: nobody who can read them stops drivegate."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from drivegate_models.compilation import cache_lock, kernel_files

LOCKS = "import fcntl; fcntl.lockf(file, fcntl.LOCK_SH)"
LEASES = (
    "import fcntl, signal; signal.signal(signal.SIGIO, lambda *_: 0); fcntl.fcntl(file, 1024, fcntl.F_WRLCK)"
)


@contextmanager
def another_process(path: Path, code: str) -> Iterator[None]:
    """Have another process do something with a file that it can only read, and keep it open."""
    lines = f"import time; file = open({str(path)!r}); {code}; print(flush=True); time.sleep(60)"
    with subprocess.Popen([sys.executable, "-c", lines], stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"\n"
        try:
            yield
        finally:
            process.send_signal(signal.SIGKILL)


def test_a_lease_on_a_kernel_keeps_nobody_waiting(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Other tests of this process may have restricted it to certain files.
    monkeypatch.setattr(kernel_files, "_trusted", [])
    path = tmp_path / "kernel.nbi"
    path.write_bytes(b"code")
    began = time.monotonic()
    with another_process(path, LEASES):
        assert kernel_files.trusted_content(tmp_path, str(path)) is None
        assert kernel_files.digests_in(tmp_path) == {}
    assert time.monotonic() - began < 20.0
    assert kernel_files.trusted_content(tmp_path, str(path)) == b"code"


def test_what_is_not_known_is_removed_and_the_rest_stays(tmp_path: Path) -> None:
    for name in ("same.nbi", "changed.nbc", "made/own.nbi", "notes.txt"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("code", encoding="utf-8")
    before = kernel_files.digests_in(tmp_path)
    own = {"made/own.nbi": kernel_files.digest_of(b"new")}
    (tmp_path / "made" / "own.nbi").write_text("new", encoding="utf-8")
    (tmp_path / "changed.nbc").write_text("attack", encoding="utf-8")
    (tmp_path / "added.nbi").write_text("attack", encoding="utf-8")
    assert kernel_files.remove_changed(tmp_path, [before, own]) == 2
    left = {str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.*")}
    assert left == {"same.nbi", "made/own.nbi", "notes.txt"}


def test_a_lock_that_is_held_for_ever_is_waited_for_a_bounded_time_altogether(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = str(tmp_path / "kernels")
    monkeypatch.setattr(cache_lock, "_left", [0.3])
    with cache_lock.alone("warm", folder):
        pass
    (lock,) = tmp_path.iterdir()
    assert not lock.is_relative_to(folder), "a candidate reads that folder"
    assert lock.stat().st_mode & 0o077 == 0
    done = []
    with another_process(lock, LOCKS):
        for task in range(50):
            began = time.monotonic()
            with cache_lock.alone(str(task), folder):
                done.append(time.monotonic() - began)
    assert 0.3 <= sum(done) < 5.0


def test_others_are_locked_out_while_a_task_is_done(tmp_path: Path) -> None:
    with cache_lock.alone("task", str(tmp_path / "kernels")):
        (lock,) = tmp_path.iterdir()
        tries = f"import fcntl; fcntl.lockf(open({str(lock)!r}, 'r+'), fcntl.LOCK_EX | fcntl.LOCK_NB)"
        tried = subprocess.run([sys.executable, "-c", tries], capture_output=True, text=True, check=False)
    assert "BlockingIOError" in tried.stderr
