"""The two commands that run the tests, on a machine without a working browser or Rust compiler."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SUITE = """import pytest

def test_plain(): pass

@pytest.mark.needs("c++")
def test_object(): pass

@pytest.mark.needs("rustc")
def test_compiled(): pass

@pytest.mark.needs("arm-none-eabi-gcc")
def test_linked(): pass

@pytest.mark.needs("browser")
def test_shown(browser_path): assert browser_path
"""


@pytest.fixture
def suite(tmp_path: Path) -> Path:
    (tmp_path / "test_suite.py").write_text(SUITE, encoding="utf-8")
    (tmp_path / "pytest.ini").write_text("[pytest]\naddopts = -p tests.needed_programs\n", encoding="utf-8")
    return tmp_path


def stated(suite: Path, *words: str, path: Path) -> tuple[int, str]:
    ended = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-p", "no:xdist", *words],
        cwd=suite,
        env=os.environ
        | {"PATH": str(path), "PYTHONPATH": str(ROOT), "PLAYWRIGHT_BROWSERS_PATH": str(suite / "none")},
        capture_output=True,
        text=True,
        check=False,
    )
    return ended.returncode, ended.stdout


def test_what_cannot_run_is_left_out_and_reported(suite: Path) -> None:
    code, shown = stated(suite, path=suite)
    assert code == 0, shown
    assert "1 passed, 4 deselected" in shown
    assert [line.split(" (")[0] for line in shown.splitlines() if line.startswith("left out")] == [
        "left out: every test that needs a browser",
        "left out: every test that needs a C++ compiler",
        "left out: every test that needs the Rust compiler",
        "left out: every test that needs Rust's build system",
        "left out: every test that needs the tools of Rust's LLVM",
        "left out: every test that needs the reader of manual pages",
        "left out: every test that needs the compiler for Arm microcontrollers",
    ]
    assert "`tox -e programs`" in shown


# A compiler that compiles, as far as `works` looks, a browser that starts, and LLVM of one version.
WORKING = """#!/bin/sh
echo 'LLVM version: 9.0, LLVM version 9.0'
for word; do [ "$last" = -o ] && : > "$word"; last=$word; done
"""
BROKEN = "#!/bin/sh\necho 'error: no override and no default toolchain set' >&2\nexit 1\n"


def programs(tmp_path: Path, content: str) -> Path:
    folder = tmp_path / "programs"
    folder.mkdir()
    for name in (
        "c++",
        "rustc",
        "cargo",
        "chromium",
        "man",
        "arm-none-eabi-gcc",
        "llvm-profdata",
        "llvm-cov",
    ):
        (folder / name).write_text(content, encoding="utf-8")
        (folder / name).chmod(0o755)
    return folder


@pytest.mark.nightly
def test_nothing_is_left_out_where_everything_is_there(suite: Path, tmp_path: Path) -> None:
    path = programs(tmp_path, WORKING)
    code, shown = stated(suite, path=path)
    assert (code, "5 passed in" in shown, "left out" in shown) == (0, True, False), shown
    code, shown = stated(suite, "--require-programs", path=path)
    assert (code, "4 passed, 1 deselected" in shown) == (0, True), shown


def test_a_program_that_does_not_work_counts_as_missing(suite: Path, tmp_path: Path) -> None:
    path = programs(tmp_path, BROKEN)
    code, shown = stated(suite, path=path)
    assert (code, "1 passed, 4 deselected" in shown) == (0, True), shown
    assert shown.count("which is missing or does not work") == 7
    code, shown = stated(suite, "--require-programs", path=path)
    assert (code, "this test needs the Rust compiler (rustc)" in shown) == (1, True), shown


def test_continuous_integration_installs_what_does_not_work(tmp_path: Path) -> None:
    (tmp_path / "cc").write_text("#!/bin/sh\nexit 0\n", encoding="utf-8")
    (tmp_path / "cc").chmod(0o755)
    path = programs(tmp_path, BROKEN)
    ended = subprocess.run(
        [sys.executable, str(ROOT / "tests" / "working_programs.py"), "cc", "rustc", "chromium"],
        env={"PATH": f"{tmp_path}:{path}"},
        capture_output=True,
        text=True,
        check=True,
    )
    assert ended.stdout.split() == ["cc", "rustc", "chromium"], "a compiler that writes nothing does not work"
    assert "tests/working_programs.py" in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def test_what_is_requested_by_name_fails_in_one_sentence(suite: Path) -> None:
    code, shown = stated(suite, "--require-programs", path=suite)
    assert code == 1
    assert "this test needs a browser (" in shown
    assert "this test needs the Rust compiler (rustc)" in shown
    assert "Traceback" not in shown
