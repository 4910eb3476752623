"""Compiled candidates and where they are kept.

A candidate's sources in C and C++ are compiled where it is resolved, in the parent process, before any worker starts:
once for all workers, and what does not compile is refused before anything runs. Compiling runs the compiler, never the
candidate; the library is only loaded in a worker process.

The library's name in the cache is a hash of all that it is made of, so one that is there is never out of date.
"""

from __future__ import annotations

import hashlib
import logging
import platform
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from drivegate.candidates.candidate import hash_of
from drivegate.candidates.native.compiler import (
    FLAGS,
    Compilation,
    CompilationError,
    Compilers,
    compile_library,
    compiler_version,
    found_compiler,
    include_folder,
    require_working,
    used_files,
    warnings_in_words,
)
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

FOLDER: Final = "candidates"
"""Folder of compiled candidates, inside that of the compiled kernels."""

_log = logging.getLogger("drivegate")


def built_library(plan: Compilation) -> tuple[Path, tuple[Path, ...]]:
    """Compile sources, or find what was compiled of the same ones before.

    The compiler's first warning is logged, when it compiles.
    """
    compilers = {language: found_compiler(language) for language in plan.languages}
    folder = cache_folder()
    complete_output = folder / f"{digest_of(str(plan.folder), *plan.sources)}.txt"
    try:
        with tempfile.TemporaryDirectory(prefix=".compiling-", dir=folder) as scratch:
            try:
                return _built(compilers, plan, folder, Path(scratch), complete_output)
            except CompilationError:
                # Only now, since it takes a compilation of its own: the compiler itself may be the reason.
                for language, compiler in compilers.items():
                    require_working(language, compiler, Path(scratch))
                raise
    except CompilationError as error:
        if not error.output:
            raise
        write_atomically(complete_output, error.output)
        raise InputError(f"{error}; its output is in {shown_path(complete_output)}") from error
    except OSError as error:
        raise InputError(
            f"{shown_path(folder)} cannot be written: {error.strerror}; name a folder for compiled code in "
            "DRIVEGATE_CACHE"
        ) from error


def _built(
    compilers: Compilers, plan: Compilation, folder: Path, scratch: Path, complete_output: Path
) -> tuple[Path, tuple[Path, ...]]:
    files = used_files(compilers, plan, scratch)
    library = folder / f"{key_of(compilers, plan, files)}.so"
    if not library.exists():
        compiled, output = compile_library(compilers, plan, scratch)
        warnings = warnings_in_words(output)
        if warnings:
            write_atomically(complete_output, output)
            _log.warning("%s; the compiler's output is in %s", warnings, shown_path(complete_output))
        # Renamed as a whole, so that another process finds either all of the library or none.
        compiled.replace(library)
    own = include_folder()
    return library, tuple(file for file in files if own not in file.parents)


def key_of(compilers: Compilers, plan: Compilation, files: Sequence[Path]) -> str:
    """Hash all that decides on the compiled code; with `-march=native`, that is the processor too."""
    from llvmlite.binding import get_host_cpu_name

    machine = (platform.machine(), get_host_cpu_name())
    places = (str(plan.folder), *plan.sources, *plan.include)
    tools = [
        word
        for language, compiler in compilers.items()
        for word in (compiler_version(compiler), *compiler, language.standard)
    ]
    words = (*tools, *FLAGS, *plan.flags, *machine, *places)
    return hash_of((*files, *plan.further_files), digest_of(*words))[:32]


def digest_of(*words: str) -> str:
    joined = "\0".join(words)
    return hashlib.sha256(joined.encode(errors="surrogateescape")).hexdigest()[:32]


def cache_folder() -> Path:
    from drivegate_models.compilation.kernels import required_cache_folder

    folder = required_cache_folder() / FOLDER
    folder.mkdir(exist_ok=True)
    return folder
