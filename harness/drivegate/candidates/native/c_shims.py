"""Programs in the places of compilers of C and C++ that add flags, whatever starts them: make, cmake or a script."""

from __future__ import annotations

import os
import platform
import re
import shlex
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from drivegate.candidates.command_path import command_path
from drivegate.candidates.native.second_build import OWN_SOURCE

_COMPILER: Final = re.compile(
    rf"(?:{re.escape(platform.machine())}-[\w-]+-)?(?:cc|gcc|c\+\+|g\+\+|clang|clang\+\+)(?:-\d+(?:\.\d+)*)?"
)
# Flags come last, so that they win over those of the build. A shared library gets the function that steps two builds.
_SHIM: Final = """#!/bin/sh
for word do
    if [ "$word" = -shared ]; then set -- "$@" {linked}; break; fi
done
exec {compiler} "$@" {flags}
"""


@dataclass(frozen=True)
class FurtherFlags:
    compiled: tuple[str, ...]
    linked: tuple[str, ...] = ()


def write_shims(folder: Path, further: FurtherFlags) -> None:
    """Write the programs into a folder of PATH."""
    own = shutil.copy(OWN_SOURCE, folder)
    for name, compiler in _compilers():
        language = "c++" if "++" in name else "c"
        linked = shlex.join(["-fPIC", "-w", "-x", language, str(own), "-x", "none", *further.linked])
        shim = folder / name
        words = {"linked": linked, "compiler": shlex.quote(compiler), "flags": shlex.join(further.compiled)}
        shim.write_text(_SHIM.format(**words), encoding="utf-8")
        shim.chmod(0o755)


def _compilers() -> list[tuple[str, str]]:
    """Return the names and paths of all compilers, as a build finds them."""
    folders = filter(Path.is_absolute, map(Path, command_path().split(os.pathsep)))
    names = {
        file.name
        for folder in folders
        if folder.is_dir()
        for file in folder.iterdir()
        if _COMPILER.fullmatch(file.name)
    }
    found = ((name, shutil.which(name, path=command_path())) for name in sorted(names))
    return [(name, program) for name, program in found if program is not None]
