"""The library of a sanitizer, which must be in a process before anything else."""

from __future__ import annotations

import platform
import re
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from drivegate.candidates.native.bounded_command import asked
from drivegate.candidates.native.compiler import CPP, Language
from drivegate.candidates.native.second_build import is_clang
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

# What the address sanitizer takes for an error in Python and its libraries, and what keeps its reports short. Signals
# are its own, since Python's handler does not know lines of C. It forgets what was released longest ago, and what the
# harness releases for a run must not push out what the candidate's reset did.
ADDRESS_OPTIONS: Final = (
    "detect_leaks=0:alloc_dealloc_mismatch=0:detect_odr_violation=0:detect_stack_use_after_return=1:"
    "quarantine_size_mb=128:print_legend=0:color=never:handle_segv=2:handle_sigbus=2:handle_sigfpe=2:handle_sigill=2"
)


def preloaded(compiler: Sequence[str], language: Language, sanitizers: Sequence[str]) -> dict[str, str]:
    """Return the variables by which a process loads a compiler's runtime library of sanitizers."""
    if is_clang(compiler):
        # Other than gcc, it leaves all sanitizers of a shared library to the program.
        which = "asan" if "address" in sanitizers else "ubsan_standalone"
        names = [f"libclang_rt.{which}-{platform.machine()}.so", f"libclang_rt.{which}.so"]
    elif "address" in sanitizers:
        names = ["libasan.so"]
    else:
        return {}
    found = [file for file in (_file_of(compiler, name) for name in names) if file is not None]
    if not found:
        raise InputError(
            f"--sanitize needs the library {names[0]}, which {one_line(compiler[0])} does not have; install it "
            f"(Debian and Ubuntu: apt install {_package(compiler, language)}; Fedora: dnf install "
            f"{'compiler-rt' if is_clang(compiler) else 'libasan'})"
        )
    options = {"ASAN_OPTIONS": ADDRESS_OPTIONS} if "address" in sanitizers else {}
    return {"LD_PRELOAD": str(found[0]), **options, **_symbolizer(compiler)}


def _symbolizer(compiler: Sequence[str]) -> dict[str, str]:
    """Return the variable that names the program which finds lines for clang's library; gcc's finds them itself."""
    if not is_clang(compiler):
        return {}
    names = (f"llvm-symbolizer{_version(compiler)}", "llvm-symbolizer")
    program = next(filter(None, map(shutil.which, names)), None)
    return {} if program is None else {"ASAN_SYMBOLIZER_PATH": str(Path(program).resolve())}


def _version(compiler: Sequence[str]) -> str:
    """Return what a compiler's name ends with, such as -19."""
    found = re.search(r"-\d+$", compiler[0])
    return found[0] if found else ""


def _file_of(compiler: Sequence[str], name: str) -> Path | None:
    ended = asked([*compiler, f"-print-file-name={name}"])
    file = Path(ended.output.strip())
    return file.resolve() if ended.status == 0 and file.is_absolute() and file.exists() else None


def _package(compiler: Sequence[str], language: Language) -> str:
    if not is_clang(compiler):
        return "g++" if language is CPP else "gcc"
    return f"libclang-rt{_version(compiler)}-dev"
