"""Where a result comes from: the versions of everything that computes it."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import shutil
import subprocess
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from drivegate.version import __version__

_PACKAGES = ("numba", "numpy", "scipy", "hypothesis")


def provenance() -> dict[str, Any]:
    """Tell the versions of what computes a result."""
    return {
        "drivegate": __version__,
        "commit": _commit(),
        "python": platform.python_version(),
        "machine": platform.machine(),
        "packages": {name: importlib.metadata.version(name) for name in _PACKAGES},
    }


@cache
def machine() -> dict[str, Any]:
    """Tell what kind of machine this is, as far as its speed goes."""
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
    """Tell the commit of drivegate's sources."""
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
