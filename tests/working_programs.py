"""Whether a program that no Python package brings works here: it is tried, since a broken shim exists as well.

As a script it prints those of the given programs that do not work; it needs Python alone.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

_SECONDS = 60.0
_SOURCES = {
    "cc": ("one.c", "int one(void) { return 1; }\n"),
    "c++": ("one.cpp", "#include <memory>\nint one() { return *std::make_unique<int>(1); }\n"),
    "rustc": ("one.rs", "pub fn one() {}\n"),
}
_SHARED = {
    "cc": ("-shared", "-fPIC"),
    "c++": ("-shared", "-fPIC"),
    "rustc": ("--crate-type", "cdylib"),
}


def works(program: str) -> bool:
    """Return True if a compiler compiles one line, and if any other program prints its version.

    `llvm`: the tools of the LLVM that the Rust compiler is built with, as others do not read what it counts.
    """
    if program == "llvm":
        return _reads_what_rust_counts()
    path = shutil.which(program)
    if path is None:
        return False
    if program not in _SOURCES:
        return _ends_well([path, "--version"], Path.cwd())
    name, line = _SOURCES[program]
    with tempfile.TemporaryDirectory() as scratch:
        Path(scratch, name).write_text(line, encoding="utf-8")
        output = Path(scratch, "one.so")
        return (
            _ends_well([path, *_SHARED[program], "-o", output.name, name], Path(scratch)) and output.is_file()
        )


def _reads_what_rust_counts() -> bool:
    compiler = shutil.which("rustc")
    version = re.search(r"LLVM version: (\d+)", _printed([compiler, "-vV"])) if compiler else None
    if version is None:
        return False
    for tool in ("llvm-profdata", "llvm-cov"):
        names = (f"{tool}-{version[1]}", tool)
        found = [path for path in map(shutil.which, names) if path is not None]
        if not any(f"LLVM version {version[1]}." in _printed([path, "--version"]) for path in found):
            return False
    return True


def _printed(command: list[str]) -> str:
    try:
        return subprocess.run(command, capture_output=True, text=True, timeout=_SECONDS, check=False).stdout
    except (OSError, subprocess.TimeoutExpired):
        return ""


def _ends_well(command: list[str], folder: Path) -> bool:
    try:
        ended = subprocess.run(command, cwd=folder, capture_output=True, timeout=_SECONDS, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return False
    return ended.returncode == 0


if __name__ == "__main__":
    for named in sys.argv[1:]:
        if not works(named):
            sys.stdout.write(f"{named}\n")
