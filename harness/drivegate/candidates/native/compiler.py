"""Compiling a candidate's sources in C and C++ with the system's compilers.

The sources may be hostile, so the compiler runs within bounds. What it complains about becomes one sentence.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import sys
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePath
from typing import Final

from drivegate.candidates.fault import bounded_line, bounded_reason
from drivegate.candidates.native.bounded_command import COMPILATION, Bounds, Ended, run_bounded
from drivegate.candidates.native.compiler_wrappers import private_caches, without_wrapper
from drivegate.isolation.installations import installation_of
from drivegate.isolation.layers import Places, isolated_command, requested_layers, system_places
from drivegate_cases.documents.regular_file import made_content, require_made
from drivegate_cases.documents.wording import one_line
from drivegate_models import contract
from drivegate_models.errors import InputError

# Without fused multiplications and additions, results have the same bits on every processor. A candidate's own flags
# may allow them.
FLAGS: Final = ("-O2", "-ffp-contract=off", "-fPIC", "-Wall", "-Wextra")
"""Flags of every compilation, after those of the language; a candidate's own come after them."""


@dataclass(frozen=True)
class Language:
    name: str
    """Its name in sentences."""
    option: str
    """Its name in the compiler's option -x."""
    standard: str
    """Flag of the language's standard, unless the candidate has another."""
    standards: str
    """What the flags of this language's standards begin with, which no other language's compiler takes."""
    variable: str
    """Environment variable that names the compiler."""
    program: str
    """The compiler where the variable is not set."""
    packages: str
    """The package that has the compiler, by distribution."""


C: Final = Language(
    "C",
    "c",
    "-std=c11",
    "-std=(c|gnu)[^+]*",
    "CC",
    "cc",
    "Debian and Ubuntu: apt install gcc; Fedora: dnf install gcc",
)
CPP: Final = Language(
    "C++",
    "c++",
    "-std=c++17",
    r"-std=(c|gnu)\+\+.*",
    "CXX",
    "c++",
    "Debian and Ubuntu: apt install g++; Fedora: dnf install gcc-c++",
)
Compilers = Mapping[Language, Sequence[str]]
"""The command of each language's compiler."""

_ERROR = re.compile(
    r"^(?P<file>[^\s:][^:\n]*):(?P<line>\d+):(?:\d+:)?\s*(?:fatal\s+)?error:\s*(?P<message>.*)$", re.MULTILINE
)
_WARNING = re.compile(
    r"^(?P<file>[^\s:][^:\n]*):(?P<line>\d+):(?:\d+:)?\s*warning:\s*(?P<message>.*)$", re.MULTILINE
)
# GNU's linkers write undefined reference to `f', others undefined symbol: f.
_UNDEFINED: Final = re.compile(r"undefined (?:reference to|symbol:?) [`'\"]?(?P<name>[^\s`'\",;]+)")
_MOST_UNDEFINED: Final = 20
_LINKER = re.compile(
    r"^.*(?:undefined reference|multiple definition|cannot find|error|Error).*$", re.MULTILINE
)
_ESCAPED = re.compile(r"\\\s*\n|\\([ #])|\$(\$)")


@dataclass(frozen=True)
class Compilation:
    folder: Path
    """Where the compiler runs; relative paths start from it."""
    sources: tuple[str, ...]
    """The sources, as they are named to the compiler."""
    include: tuple[str, ...] = ()
    """Folders of headers."""
    flags: tuple[str, ...] = ()
    """The candidate's own flags."""
    further_files: tuple[Path, ...] = ()
    """Files that are not compiled, but on which the result depends."""
    bounds: Bounds = COMPILATION

    @property
    def languages(self) -> tuple[Language, ...]:
        """The languages of the sources, that which links them last."""
        used = {language_of(source) for source in self.sources}
        return tuple(language for language in (C, CPP) if language in used)


class CompilationError(InputError):
    """The compiler refuses the sources."""

    def __init__(self, sentence: str, output: str) -> None:
        super().__init__(sentence)
        self.output = output


def include_folder() -> Path:
    """Find the folder of the headers `drivegate.h` and `drivegate_duty.h`."""
    return Path(contract.__file__).resolve().with_name("include")


def language_of(source: str) -> Language:
    return C if PurePath(source).suffix.lower() == ".c" else CPP


def found_compiler(language: Language) -> tuple[str, ...]:
    """Find a language's compiler: the one that the environment variable names, or the usual one; without a cache."""
    chosen = os.environ.get(language.variable, "").strip()
    try:
        words = shlex.split(chosen) or [language.program]
    except ValueError as error:
        raise InputError(
            f"the environment variable {language.variable} is '{one_line(chosen)}', which is no command line: {error}"
        ) from error
    name, *flags = without_wrapper(words)
    program = shutil.which(name)
    if program is None:
        named = (
            f"the environment variable {language.variable} names '{one_line(name)}', which is not there"
            if chosen
            else f"a candidate in {language.name} needs a {language.name} compiler, but there is no {language.program}"
        )
        raise InputError(f"{named}; {_how_to_get(language)}")
    return (program, *flags)


def _how_to_get(language: Language) -> str:
    return (
        f"install one ({language.packages}; macOS: xcode-select --install) or name it in the environment variable "
        f"{language.variable}"
    )


def require_working(language: Language, compiler: Sequence[str], scratch: Path) -> None:
    """Refuse a compiler that cannot compile one line, such as a shim without a toolchain."""
    source = f"one.{language.option}"
    (scratch / source).write_text("int one(void) { return 1; }\n", encoding="utf-8")
    try:
        compile_library({language: compiler}, Compilation(scratch, (source,)), scratch)
    except CompilationError as error:
        first = next(filter(None, map(str.strip, error.output.splitlines())), "it printed nothing")
        raise InputError(
            f"the {language.name} compiler '{one_line(shlex.join(compiler))}' does not work, it cannot compile a "
            f"single line: {bounded_reason(first)}; {_how_to_get(language)}"
        ) from error


def compiler_version(compiler: Sequence[str]) -> str:
    ended = run_bounded([*compiler, "--version"], folder=Path.cwd(), environment={}, bounds=Bounds(10.0))
    return bounded_line(next(iter(ended.output.splitlines()), ""))


def used_files(compilers: Compilers, plan: Compilation, scratch: Path) -> tuple[Path, ...]:
    """Request from the compilers the files that the sources are made of, those of the system apart."""
    # Of several sources, each would overwrite what is reported of the one before.
    lists = (_used_by(source, compilers, plan, scratch / "dependencies") for source in plan.sources)
    found = tuple(dict.fromkeys(file for files in lists for file in files))
    if requested_layers():
        # The candidate may read these, and a compiler that its files have taken over may list any.
        names = [
            name for compiler in compilers.values() for name in _places(compiler[0], plan, scratch).readable
        ]
        places = [Path(name).resolve() for name in (*names, *system_places())]
        for file in found:
            if not any(file.is_relative_to(place) for place in places):
                raise InputError(
                    f"{', '.join(map(one_line, plan.sources))}: the compiler lists '{one_line(str(file))}' among the "
                    "files that it read, which is out of its reach; remove the flags that change this list"
                )
    return found


def _used_by(source: str, compilers: Compilers, plan: Compilation, rule: Path) -> list[Path]:
    _run(["-MM", "-MF", str(rule), *_named(source)], language_of(source), compilers, plan, rule.parent)
    own = (plan.folder / source).resolve()
    try:
        listed = made_content(rule).decode("utf-8", errors="surrogateescape")
    except OSError:
        return [own]
    # The rule is `target: file file`, continued over lines.
    text = _ESCAPED.sub(lambda found: "\0" if found[1] == " " else found[1] or found[2] or " ", listed)
    names = text.partition(": ")[2].split()
    return [own, *((plan.folder / name.replace("\0", " ")).resolve() for name in names)]


def compile_library(compilers: Compilers, plan: Compilation, scratch: Path) -> tuple[Path, str]:
    """Compile sources, each in its language, and link them to a shared library."""
    library, objects, output = scratch / "library.so", [], ""
    deadline = time.monotonic() + plan.bounds.seconds
    for number, source in enumerate(plan.sources):
        objects.append(str(scratch / f"{number}.o"))
        left = replace(plan, bounds=replace(plan.bounds, seconds=max(deadline - time.monotonic(), 0.1)))
        output += _run(
            ["-c", "-o", objects[-1], *_named(source)], language_of(source), compilers, left, scratch
        )
    libraries = [flag for flag in plan.flags if flag.startswith("-l")]
    # Libraries come after the objects: a linker searches each once, for what is missing by then.
    linked = [
        "-shared",
        *_reporting_all_undefined(plan.flags),
        "-o",
        str(library),
        *objects,
        *libraries,
        "-lm",
    ]
    output += _run(linked, plan.languages[-1], compilers, plan, scratch)
    # A link would open the file that it leads to for the candidate.
    for made in (library, *scratch.glob("*.gcno")):
        try:
            require_made(made)
        except OSError as error:
            raise InputError(
                f"{', '.join(map(one_line, plan.sources))}: the compiler made '{one_line(made.name)}', but "
                f"{error.strerror}; remove the flags that run programs of your own in it"
            ) from error
    return library, output


def _reporting_all_undefined(flags: Sequence[str]) -> list[str]:
    """Return the option by which a linker lists all functions that are nowhere; loading would report the first."""
    # What checks code as it runs, such as clang's sanitizers, may define its functions only in the program.
    is_checked = any(flag.startswith("-fsanitize") or "-undefined" in flag for flag in flags)
    return [] if is_checked or sys.platform == "darwin" else ["-Wl,--no-undefined"]


def warnings_in_words(output: str) -> str:
    found = list(_WARNING.finditer(output))
    return _complaint(found, "warning", "warning: ") if found else ""


def _options(plan: Compilation, language: Language) -> list[str]:
    folders = [f"-I{folder}" for folder in (*plan.include, str(include_folder()))]
    own = [flag for flag in plan.flags if not flag.startswith("-l")]
    # A standard of the other language is a warning in this one.
    own = [flag for flag in own if not flag.startswith("-std=") or re.fullmatch(language.standards, flag)]
    return [language.standard, *FLAGS, *folders, *own]


def _named(source: str) -> list[str]:
    """Name a source so that it is not taken for an option or for another language."""
    return ["-x", language_of(source).option, f"./{source}" if source.startswith("-") else source]


def _run(
    words: Sequence[str], language: Language, compilers: Compilers, plan: Compilation, scratch: Path
) -> str:
    compiler = compilers[language]
    environment = {"LC_ALL": "C", "TMPDIR": str(scratch), **private_caches(scratch)}
    # Flags and sources may start programs, or take in any file.
    command = [*compiler, *_options(plan, language), *words]
    isolated = isolated_command(command, requested_layers(), _places(command[0], plan, scratch))
    ended = run_bounded(isolated, folder=plan.folder, environment=environment, bounds=plan.bounds)
    if ended.status != 0:
        raise CompilationError(_sentence(ended, plan, language, Path(command[0]).name), ended.output)
    return ended.output


def _places(compiler: str, plan: Compilation, scratch: Path) -> Places:
    """Return what a compiler may read: itself, and the folder of sources and headers; it writes into one folder."""
    # Sources and headers elsewhere are in roots that the user names, which every program may read.
    files = (Path(compiler), Path(compiler).resolve())
    tools = [place for file in files for place in (file.parent, *installation_of(file))]
    readable = (plan.folder, *tools, include_folder())
    return Places(tuple(str(place.resolve()) for place in readable), (str(scratch),))


def _sentence(ended: Ended, plan: Compilation, language: Language, compiler: str) -> str:
    sources = ", ".join(map(one_line, plan.sources))
    if ended.status is None:
        return f"{sources}: {compiler} did not come to an end; compiling a candidate may take {plan.bounds.in_words()}"
    errors = list(_ERROR.finditer(ended.output))
    if errors:
        return f"{_complaint(errors, 'error')}; the sources must compile with {compiler} {language.standard}"
    undefined = list(dict.fromkeys(found["name"] for found in _UNDEFINED.finditer(ended.output)))
    if undefined:
        more = len(undefined) - _MOST_UNDEFINED
        named = ", ".join(map(bounded_reason, undefined[:_MOST_UNDEFINED])) + (
            f" and {more} more" if more > 0 else ""
        )
        return (
            f"{sources}: nothing defines {named}; add the sources or libraries that do, or define them yourself, for "
            "example as functions that do nothing"
        )
    lines = [found[0] for found in _LINKER.finditer(ended.output)] or ended.output.strip().splitlines()
    reason = (
        bounded_reason(lines[0]) if lines else f"it ended with status {ended.status} and reported nothing"
    )
    bounds = plan.bounds.in_words()
    return f"{sources}: {compiler} does not compile it: {reason}; compiling a candidate may take {bounds}"


def _complaint(found: Sequence[re.Match[str]], what: str, prefix: str = "") -> str:
    """Quote the first complaint, and count the others."""
    first, others = found[0], len(found) - 1
    more = f" (and {others} more {what}{'s' if others > 1 else ''})" if others else ""
    place = f"{bounded_reason(first['file'])}, line {first['line']}"
    return f"{place}: {prefix}{bounded_reason(first['message'])}{more}"
