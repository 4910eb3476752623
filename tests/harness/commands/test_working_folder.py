"""A stranger's files in the folder that drivegate starts in do not run, and no candidate may read them."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = (
    "import json; from drivegate.isolation.layers import system_places; print(json.dumps(system_places()))"
)


@pytest.mark.one_in(2)
@pytest.mark.parametrize("words", ["drivegate --version", "drivegate.gate.warm_up"])
def test_a_module_imports_nothing_from_the_present_folder(words: str, tmp_path: Path) -> None:
    for name in ("click", "drivegate_models", "hashlib", "json", "numba", "sitecustomize"):
        (tmp_path / f"{name}.py").write_text(
            f"raise SystemExit('{name} of the checkout ran')", encoding="utf-8"
        )
    ended = subprocess.run(
        [sys.executable, "-m", *words.split()],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stderr


def places(folder: Path, **variables: str) -> set[str]:
    """Return what a candidate may read where ``python -m`` is started in a folder."""
    (folder / "program.py").write_text(PROGRAM, encoding="utf-8")
    ended = subprocess.run(
        [sys.executable, "-m", "program"],
        cwd=folder,
        env=os.environ | variables,
        capture_output=True,
        text=True,
        check=True,
    )
    return set(json.loads(ended.stdout))


def test_the_present_folder_is_readable_only_where_it_is_named(tmp_path: Path) -> None:
    assert str(tmp_path) not in places(tmp_path)
    stated = os.pathsep.join(filter(None, (str(tmp_path), os.environ.get("PYTHONPATH"))))
    assert str(tmp_path) in places(tmp_path, PYTHONPATH=stated)


def test_paths_start_from_the_folder_of_the_option(command, refused, tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "there").mkdir()
    monkeypatch.chdir(tmp_path)
    assert command("-C", "there", "new", "c", "mine").code == 0
    assert (tmp_path / "there" / "mine" / "controller.c").is_file()
    monkeypatch.chdir(tmp_path)
    assert "the folder none of -C cannot be entered: No such file" in refused("-C", "none", "cases")
