"""Compilers and readers of counters that a candidate's files have taken over: what they leave opens no other file."""

from __future__ import annotations

import os
import shutil
import signal
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from tests.harness.candidates.native.linker_plugin import manifest, with_plugin
from tests.harness.candidates.native.test_code_coverage import GLOBAL

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.kinds import KINDS
from drivegate.candidates.native.compiler import Compilation
from drivegate.candidates.native.sanitizing import _suspects
from drivegate.candidates.native.second_build import OUTPUT
from drivegate.candidates.resolution import resolve_candidate
from drivegate.candidates.sanitizers import read_report
from drivegate_models.errors import InputError

PATIENCE = 20


@pytest.fixture(autouse=True)
def _at_once() -> Iterator[None]:
    """End a test that waits for what it has opened."""
    signal.alarm(PATIENCE)
    yield
    signal.alarm(0)


@pytest.fixture
def secret(tmp_path: Path) -> Path:
    file = tmp_path / "user" / "secret.txt"
    file.parent.mkdir()
    file.write_text("mine", encoding="utf-8")
    return file


@pytest.fixture
def own(tmp_path: Path) -> Path:
    folder = tmp_path / "own"
    folder.mkdir()
    (folder / "mine.c").write_text(GLOBAL, encoding="utf-8")
    return folder


def test_a_library_that_is_a_link_is_refused(own: Path, secret: Path) -> None:
    with pytest.raises(
        InputError, match=r"made 'library\.so', but it is not a regular file; remove the flags"
    ):
        resolve_candidate(with_plugin(own, "library.so", secret))


def test_no_output_is_written_through_a_link(own: Path, secret: Path, tmp_path: Path) -> None:
    candidate = resolve_candidate(with_plugin(own, OUTPUT, secret))
    with pytest.raises(InputError):
        KINDS["c"].counted_candidate(candidate, tmp_path)
    assert secret.read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("flag", ["-Wp,-MT,mine", "-Wp,-MMD,list", "-Wl,-plugin,./mine.so"])
def test_flags_that_change_the_list_of_files_or_run_programs_are_refused(own: Path, flag: str) -> None:
    with pytest.raises(InputError, match="what the compiler writes and runs is for drivegate to say"):
        resolve_candidate(manifest(own, f'"{flag}"'))


def compiler_that_lists(folder: Path, listed: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Have a compiler write a list of the files that it read."""
    script = folder / "compiler"
    script.write_text(
        '#!/bin/sh\nfor word; do [ "$last" = -MF ] && list=$word; last=$word; done\n'
        f'if [ "$list" ]; then printf "%s" "{listed}" >"$list"; else exec cc "$@"; fi\n'
    )
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))


def test_a_list_with_a_file_of_the_users_is_refused(
    own: Path, secret: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    compiler_that_lists(own, f"x: mine.c {secret}", monkeypatch)
    with pytest.raises(InputError, match=r"lists '.*secret\.txt' among the files that it read"):
        resolve_candidate(manifest(own))


def test_a_list_without_the_source_leaves_it_in_the_hash(own: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compiler_that_lists(own, "", monkeypatch)
    first = resolve_candidate(manifest(own))
    (own / "mine.c").write_text(f"{GLOBAL}int more;\n", encoding="utf-8")
    assert first.sources == (own / "mine.c",)
    assert first.content_hash != resolve_candidate(manifest(own)).content_hash


@pytest.fixture
def counted(own: Path, tmp_path: Path) -> Candidate:
    folder = tmp_path / "counted"
    folder.mkdir()
    return KINDS["c"].counted_candidate(resolve_candidate(manifest(own)), folder)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("make", [lambda file: file.symlink_to("/dev/zero"), os.mkfifo, Path.mkdir])
def test_counters_that_are_no_files_are_refused(
    counted: Candidate, tmp_path: Path, make: Callable[[Path], None]
) -> None:
    assert counted.instrumented is not None
    place = counted.instrumented.folder / "made"
    place.mkdir()
    # What the process makes first takes nothing away from the tools.
    (counted.instrumented.folder / "work").mkdir()
    make(place / "0.gcda")
    with pytest.raises(InputError, match=r"0\.gcda, which --coverage reads, cannot be copied: it is "):
        KINDS["c"].measured_files(counted, tmp_path)


def spent(act: Callable[[], object]) -> float:
    began = time.process_time()
    act()
    return time.process_time() - began


def test_a_report_of_one_long_line_is_read_at_once(tmp_path: Path) -> None:
    printed = f"==1==ERROR: AddressSanitizer: x\n  #0 0x1 in {' /' * 10_000}"
    assert spent(lambda: read_report(printed, tmp_path, ())) < 2.0


def test_warnings_of_one_long_line_are_read_at_once(
    own: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / OUTPUT).write_text(f"a:1:1: warning: uninitialized{' ' * 40_000}", encoding="utf-8")
    monkeypatch.setattr("drivegate.candidates.native.sanitizing.second_build", lambda *_: tmp_path)
    assert shutil.which("cc")
    assert spent(lambda: _suspects(Compilation(own, ("mine.c",)), own)) < 2.0
