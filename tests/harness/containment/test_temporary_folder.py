"""A temporary folder goes with its process, at the latest when the next process starts."""

from __future__ import annotations

import errno
import os
import signal
import stat
import subprocess
import sys
import tempfile
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from drivegate.containment import judge_process
from drivegate.containment import temporary_folder as module
from drivegate.containment.messages import Refused
from drivegate.containment.temporary_folder import TemporaryFolder, temporary_folder
from drivegate_models.errors import InputError


@pytest.fixture(autouse=True)
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder for temporary files, into which this process has not looked yet."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.setattr(module, "_swept", set())
    return tmp_path


def test_it_belongs_to_its_owner_alone_and_goes_with_the_context(place: Path) -> None:
    with temporary_folder() as folder:
        assert stat.S_IMODE(folder.stat().st_mode) == 0o700
        (folder / "file").touch()
    assert list(place.iterdir()) == []


def test_it_needs_no_locks_of_its_file_system(place: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*_: int) -> None:
        raise OSError(errno.ENOLCK, os.strerror(errno.ENOLCK))

    monkeypatch.setattr(module.fcntl, "flock", fails)
    with temporary_folder() as folder:
        monkeypatch.setattr(module, "_swept", set())
        with temporary_folder():
            assert folder.is_dir(), "one in use was taken for abandoned"
    assert list(place.iterdir()) == []


_LEAVES_ONE = (
    "import sys, time; from drivegate.containment.temporary_folder import TemporaryFolder; "
    "folder = TemporaryFolder(); (folder.path / 'big').touch(); print(folder.path, flush=True); time.sleep(60)"
)


def test_what_a_killed_process_has_left_is_removed_and_nothing_else(place: Path) -> None:
    foreign = [place / "drivegate-results", place / ".drivegate-results", place / f".drivegate-{'a' * 16}"]
    for folder in foreign[:2]:
        folder.mkdir()
    foreign[2].symlink_to(foreign[0])
    process = subprocess.Popen(
        [sys.executable, "-c", _LEAVES_ONE],
        env={**os.environ, "TMPDIR": str(place)},
        stdout=subprocess.PIPE,
        text=True,
    )
    with process:
        assert process.stdout is not None
        left = Path(process.stdout.readline().strip())
        TemporaryFolder().remove()
        assert left.is_dir(), "the folder of a living process was removed"
        process.send_signal(signal.SIGKILL)
    module._swept.clear()
    TemporaryFolder().remove()
    assert sorted(place.iterdir()) == sorted(foreign)


@pytest.mark.parametrize(("of", "name"), [(module.fcntl, "flock"), (module.os, "open")])
def test_a_folder_that_vanishes_before_it_is_locked_is_made_again(
    place: Path, monkeypatch: pytest.MonkeyPatch, of: ModuleType, name: str
) -> None:
    called, taken = getattr(of, name), list[Path]()

    def call(what: Any, how: int) -> Any:
        if not taken:
            taken.extend(place.iterdir())
            taken[0].rmdir()
        return called(what, how)

    monkeypatch.setattr(of, name, call)
    folder = TemporaryFolder()
    assert folder.path.is_dir()
    assert folder.path not in taken
    folder.remove()


def test_a_place_that_cannot_be_written_is_refused_in_one_sentence(
    place: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(place / "absent"))
    with pytest.raises(
        InputError, match=r"no temporary folder can be made: No such file .* variable TMPDIR$"
    ):
        TemporaryFolder()


def test_a_full_disk_in_a_judge_is_refused_and_no_fault_of_drivegate() -> None:
    class OnAFullDisk:
        def once(self, job: object) -> None:
            raise OSError(28, "No space left on device", "kernel.nbc")

    outcome = judge_process._outcome(OnAFullDisk(), None)  # type: ignore[arg-type]
    assert isinstance(outcome, Refused)
    assert outcome.sentence.startswith("cannot write at kernel.nbc: No space left on device")
