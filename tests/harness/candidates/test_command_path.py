"""Which `python3` a candidate's commands find, in an environment that is not activated."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

from drivegate.candidates.candidate import Program
from drivegate.candidates.command_path import command_path
from drivegate.candidates.native.build_commands import ProjectBuild, built_artefact
from drivegate.candidates.resolution import resolve_candidate

OWN = Path(sys.executable).parent


@pytest.fixture
def shims(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Put another `python3` first, as a version manager does."""
    folder = tmp_path / "shims"
    folder.mkdir()
    shim = folder / "python3"
    shim.write_text("#!/bin/sh\nexit 1\n", encoding="utf-8")
    shim.chmod(0o755)
    monkeypatch.setenv("PATH", f"{folder}:/usr/bin:/bin")
    return folder


def test_the_python_of_drivegate_comes_first_where_another_one_would_be_found(shims: Path) -> None:
    assert command_path() == f"{OWN}:{shims}:/usr/bin:/bin"


@pytest.mark.parametrize("path", [str(OWN), f"/usr/games:{OWN}:/usr/bin"])
def test_a_path_with_it_keeps_its_order(path: str) -> None:
    assert command_path({"PATH": path}) == path


def test_a_build_starts_it(shims: Path, tmp_path: Path) -> None:
    source = tmp_path / "make.py"
    source.write_text("import numba, sys\nopen('made.so', 'w').write(sys.prefix)\n", encoding="utf-8")
    build = ProjectBuild("candidate.toml", tmp_path, ("python3 make.py",), (source,), "made.so")
    assert built_artefact(build).read_text(encoding="utf-8") == sys.prefix


def test_a_program_is_started_with_it(shims: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    details = resolve_candidate("exec:python3 controller.py").details
    assert isinstance(details, Program)
    assert details.executable == OWN / "python3"
    assert os.environ["PATH"].startswith(str(shims)), "the user's own environment stays as it is"
