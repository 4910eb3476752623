"""Compiled kernels that are kept between processes."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import drivegate_models
from drivegate_models.compilation import kernels as compilation
from drivegate_models.machine.winding_current import phi4


def test_every_kernel_is_kept_in_files_named_by_content() -> None:
    assert isinstance(phi4._cache, compilation._KernelCache)  # type: ignore[attr-defined]


def test_processes_that_compile_at_once_never_share_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def files() -> compilation._FilesNamedByContent:
        return compilation._FilesNamedByContent(str(tmp_path), "kernel", "stamp")

    first, second = ("signature", "processor", "one"), ("signature", "processor", "two")
    # Both processes read the index before either has written it.
    with monkeypatch.context() as patched:
        patched.setattr(compilation._FilesNamedByContent, "_load_index", lambda self: {})
        files().save(first, "code one")
        files().save(second, "code two")
    files().save(first, "code one")
    assert files().load(first) == "code one"
    assert files().load(second) == "code two"


def _key_of_package_at(folder: Path) -> str:
    command = "from drivegate_models.compilation.kernels import cache_key; print(cache_key())"
    done = subprocess.run(
        [sys.executable, "-c", command], cwd=folder, capture_output=True, text=True, check=True, timeout=120
    )
    return done.stdout.strip()


def test_two_installations_keep_their_kernels_apart(tmp_path: Path) -> None:
    package = Path(drivegate_models.__file__).parent
    for name in ("one", "two"):
        shutil.copytree(package, tmp_path / name / package.name, ignore=shutil.ignore_patterns("__pycache__"))
    keys = {_key_of_package_at(tmp_path / name) for name in ("one", "two", "one")}
    assert len(keys) == 2, (
        "numba looks kernels up by source path, so each place needs its own folder and marker"
    )


def test_the_cache_folder_holds_where_numba_was_imported_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv(compilation.CACHE_VARIABLE, str(tmp_path))
    command = "import numba; from drivegate_models.machine.winding_current import phi4; print(phi4._cache.cache_path)"
    done = subprocess.run(
        [sys.executable, "-c", command], capture_output=True, text=True, check=True, timeout=120
    )
    assert Path(done.stdout.strip()).is_relative_to(tmp_path), done.stdout
