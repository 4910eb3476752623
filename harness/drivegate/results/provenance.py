"""Where a result comes from: the versions of everything that computes it."""

from __future__ import annotations

import hashlib
import importlib.metadata
import importlib.resources
import json
import os
import platform
import shutil
import subprocess
from collections.abc import Mapping
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from drivegate.version import __version__
from drivegate_models.compilation.target import requested_target

_PACKAGES = ("numba", "llvmlite", "numpy", "scipy", "hypothesis")
_OWN_PACKAGES = ("drivegate", "drivegate_cases", "drivegate_models")
_SOURCES = (".py", ".toml")
_NOT_HASHED = ("commit", "target", "content_hash")


def versions() -> dict[str, Any]:
    """Return the versions of everything that a result follows from; equal ones give equal results."""
    # It brings arrays, which a file that is refused at once does not need.
    from drivegate.checks.installed import installed_versions

    known = {
        "drivegate": __version__,
        "sources": _sources(),
        "python": platform.python_version(),
        "machine": platform.machine(),
        "packages": {name: importlib.metadata.version(name) for name in _PACKAGES},
    }
    # This imports what judges runs.

    installed = installed_versions()
    return known | {"checks": installed} if installed else known


def provenance() -> dict[str, Any]:
    """Return the versions of what computes a result, and where that is, on which the result does not depend."""
    return {**versions(), "commit": _commit(), "target": requested_target()}


def hash_of_content(content: Mapping[str, Any]) -> str:
    """Return a digest of a result: of what was judged, how, by which versions, and the outcome, but not of where."""
    stated_versions = {key: value for key, value in content["provenance"].items() if key not in _NOT_HASHED}
    hashed = {**content, "provenance": stated_versions}
    return hashlib.sha256(json.dumps(hashed, sort_keys=True).encode()).hexdigest()


def hash_of_scenario(scenario: Mapping[str, Any]) -> str:
    """Return a digest of a scenario, fully resolved: equal runs of equal drives have the same."""
    return hashlib.sha256(json.dumps(scenario, sort_keys=True).encode()).hexdigest()[:16]


@cache
def _sources() -> str:
    """Digest drivegate's own sources and cases, the same in a checkout and in a package."""
    digest = hashlib.sha256()
    for package in _OWN_PACKAGES:
        folder = Path(str(importlib.resources.files(package)))
        for file in sorted(path for path in folder.rglob("*") if path.suffix in _SOURCES):
            digest.update(f"{package}/{file.relative_to(folder).as_posix()}\0".encode())
            digest.update(file.read_bytes() + b"\0")
    return digest.hexdigest()[:16]


@cache
def machine() -> dict[str, Any]:
    """Return what kind of machine this is, as far as its speed goes."""
    model = platform.processor()
    with suppress(OSError):
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
        models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
        model = models[0] if models else model
    return {
        "system": f"{platform.system()} {platform.release()}",
        "processor": model,
        "processors": os.cpu_count(),
    }


@cache
def _commit() -> str | None:
    git = shutil.which("git")
    own = Path(__file__).resolve()
    if git is None:
        return None

    def git_output(*words: str) -> str | None:
        command = [git, "-C", str(own.parent), *words]
        try:
            ended = subprocess.run(command, capture_output=True, text=True, timeout=20.0, check=True)
        except (OSError, subprocess.SubprocessError):
            return None
        return ended.stdout.strip()

    # An installed copy may lie inside somebody else's working copy, which does not keep it.
    if git_output("ls-files", "--error-unmatch", own.name) is None:
        return None
    commit = git_output("rev-parse", "HEAD")
    return (
        f"{commit}+changes"
        if commit and git_output("status", "--porcelain", "--untracked-files=no")
        else commit
    )
