"""A second build of a native candidate's sources, with what counts lines or looks for undefined behaviour."""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Final

from drivegate.candidates.native.build import cache_folder, key_of
from drivegate.candidates.native.compiler import (
    CPP,
    Compilation,
    Compilers,
    compile_library,
    compiler_version,
    found_compiler,
    used_files,
)
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

LIBRARY: Final = "library.so"
"""Name of the library in the folder of a second build."""

OUTPUT: Final = "output.txt"
"""Name of the file there with what the compiler printed."""

OWN_SOURCE: Final = Path(__file__).with_name("two_builds.c")
"""The function that steps two builds."""


def compilers_of(plan: Compilation) -> Compilers:
    return {language: found_compiler(language) for language in plan.languages}


def is_clang(compiler: Sequence[str]) -> bool:
    return "clang" in compiler_version(compiler)


def second_build(plan: Compilation, flags: Sequence[str]) -> Path:
    """Compile sources with further flags, or find what was; return the folder with the library and the notes on it."""
    compilers = compilers_of(plan)
    if not any(map(is_clang, compilers.values())):
        # Otherwise the two builds would share what C++ has once in a program.
        flags = (*flags, "-fno-gnu-unique")
    changed = replace(plan, flags=(*plan.flags, *flags))
    folder = cache_folder()
    try:
        with tempfile.TemporaryDirectory(prefix=".compiling-", dir=folder) as scratch:
            files = used_files(compilers, plan, Path(scratch))
            kept = folder / f"{key_of(compilers, changed, (*files, OWN_SOURCE))}.second"
            if not kept.is_dir():
                made = Path(scratch) / "made"
                made.mkdir()
                own = made / f"two_builds{'.cpp' if plan.languages[-1] is CPP else '.c'}"
                shutil.copy(OWN_SOURCE, own)
                # Whole paths, which tools find from any folder.
                sources = (*(str(plan.folder / source) for source in plan.sources), str(own))
                _, output = compile_library(compilers, replace(changed, sources=sources), made)
                # A new file: nothing that the compiler may have left there is written to.
                with (made / OUTPUT).open("x", encoding="utf-8") as stream:
                    stream.write(output)
                _keep(made, kept)
    except OSError as error:
        raise InputError(
            f"{shown_path(folder)} cannot be written: {error.strerror}; name a folder for compiled code in "
            "DRIVEGATE_CACHE"
        ) from error
    return kept


def _keep(made: Path, kept: Path) -> None:
    """Give a folder its name in the cache, unless another process has made the same one meanwhile."""
    try:
        made.rename(kept)
    except OSError:
        if not kept.is_dir():
            raise
