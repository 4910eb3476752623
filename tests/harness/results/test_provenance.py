"""What a result states of its origin, and what of that its content hash covers."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import drivegate
import drivegate_cases
import drivegate_models
from drivegate.results.provenance import hash_of_content, provenance, versions
from drivegate_models.compilation.target import stated_target

PACKAGES = (drivegate, drivegate_cases, drivegate_models)


def test_a_result_names_its_target(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES"):
        monkeypatch.delenv(name, raising=False)
    assert provenance()["target"] == stated_target()
    monkeypatch.setenv("NUMBA_CPU_NAME", "generic")
    monkeypatch.setenv("NUMBA_CPU_FEATURES", "")
    assert provenance()["target"] == "generic"


@pytest.mark.parametrize("key", ["commit", "target"])
def test_where_it_was_computed_is_outside_of_the_hash(key: str) -> None:
    stated = provenance()
    elsewhere = {**stated, key: "another"}
    assert hash_of_content({"runs": 1, "provenance": stated}) == hash_of_content(
        {"runs": 1, "provenance": elsewhere}
    )


@pytest.mark.parametrize("key", ["drivegate", "sources", "python", "machine", "packages"])
def test_versions_are_inside_of_the_hash(key: str) -> None:
    stated: dict[str, Any] = versions()
    assert hash_of_content({"provenance": stated}) != hash_of_content(
        {"provenance": {**stated, key: "another"}}
    ), f"two results of different versions ({key}) would have one hash"


def _sources_of_copy(folder: Path) -> str:
    command = "from drivegate.results.provenance import versions; print(versions()['sources'])"
    done = subprocess.run(
        [sys.executable, "-c", command], cwd=folder, capture_output=True, text=True, check=True, timeout=120
    )
    return done.stdout.strip()


def test_a_copy_of_the_sources_is_the_same_version_and_a_changed_one_is_not(tmp_path: Path) -> None:
    for package in PACKAGES:
        folder = Path(package.__file__).parent
        shutil.copytree(folder, tmp_path / folder.name, ignore=shutil.ignore_patterns("__pycache__"))
    assert _sources_of_copy(tmp_path) == versions()["sources"]
    drive = next((tmp_path / "drivegate_cases").rglob("paper-5-phase.toml"))
    drive.write_text(drive.read_text(encoding="utf-8") + "\n# another\n", encoding="utf-8")
    assert _sources_of_copy(tmp_path) != versions()["sources"]
