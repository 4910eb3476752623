"""A program in the place of Rust's compiler that adds flags, whatever starts it: cargo, make or a script."""

from __future__ import annotations

import shlex
import shutil
from collections.abc import Sequence
from pathlib import Path


def found_rustc() -> str | None:
    return shutil.which("rustc")


def write_shim(folder: Path, flags: Sequence[str], copied: Path, original: Path) -> dict[str, str]:
    """Write the program into a folder of PATH, and return the variable by which builds find it too.

    `copied`, `original`: folder in which a build runs, and the one that it is a copy of, which messages name.
    """
    compiler = found_rustc() or "rustc"
    words = [compiler, f"--remap-path-prefix={copied}={original}"]
    shim = folder / "rustc"
    # Flags come last, so that they win over those of the build.
    shim.write_text(f'#!/bin/sh\nexec {shlex.join(words)} "$@" {shlex.join(flags)}\n', encoding="utf-8")
    shim.chmod(0o755)
    return {"RUSTC": str(shim)}
