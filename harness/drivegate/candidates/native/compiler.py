"""Compiling a candidate's C sources with the system's compiler.

The sources may be hostile, so the compiler runs within bounds. What it complains about becomes one sentence.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from drivegate.candidates.fault import bounded_line
from drivegate.candidates.native.bounded_command import COMPILATION, Bounds, Ended, run_bounded
from drivegate.isolation.layers import Places, isolated_command, requested_layers
from drivegate_cases.documents.wording import one_line
from drivegate_models import contract
from drivegate_models.errors import InputError

FLAGS: Final = ("-std=c11", "-O2", "-ffp-contract=off", "-fPIC", "-Wall", "-Wextra")
"""Flags of every compilation; a candidate's own come after them."""

_HOW_TO_GET_ONE: Final = (
    "install one (Debian and Ubuntu: apt install gcc; Fedora: dnf install gcc; macOS: xcode-select --install) "
    "or name it in the environment variable CC"
)
_LONGEST_MESSAGE: Final = 300
_ERROR = re.compile(
    r"^(?P<file>[^\s:][^:\n]*):(?P<line>\d+):(?:\d+:)?\s*(?:fatal\s+)?error:\s*(?P<message>.*)$", re.MULTILINE
)
_WARNING = re.compile(
    r"^(?P<file>[^\s:][^:\n]*):(?P<line>\d+):(?:\d+:)?\s*warning:\s*(?P<message>.*)$", re.MULTILINE
)
_LINKER = re.compile(
    r"^.*(?:undefined reference|multiple definition|cannot find|error|Error).*$", re.MULTILINE
)
_ESCAPED = re.compile(r"\\\s*\n|\\([ #])|\$(\$)")


@dataclass(frozen=True)
class Compilation:
    """What is compiled, and how."""

    folder: Path
    """Where the compiler runs; relative paths start from it."""
    sources: tuple[str, ...]
    """The C sources, as they are named to the compiler."""
    include: tuple[str, ...] = ()
    """Folders of headers."""
    flags: tuple[str, ...] = ()
    """The candidate's own flags."""
    further_files: tuple[Path, ...] = ()
    """Files that are not compiled, but on which the result depends."""
    bounds: Bounds = COMPILATION
    """What the compiler may use."""


class CompilationError(InputError):
    """The compiler refuses the sources."""

    def __init__(self, sentence: str, output: str) -> None:
        super().__init__(sentence)
        self.output = output


def include_folder() -> Path:
    """Find the folder of the headers `drivegate.h` and `drivegate_duty.h`."""
    return Path(contract.__file__).resolve().with_name("include")


def c_compiler() -> tuple[str, ...]:
    """Find the C compiler: the one that the environment variable `CC` names, or `cc`."""
    chosen = os.environ.get("CC", "").strip()
    try:
        words = shlex.split(chosen) or ["cc"]
    except ValueError as error:
        raise InputError(
            f"the environment variable CC is '{one_line(chosen)}', which is no command line: {error}"
        ) from error
    program = shutil.which(words[0])
    if program is None:
        named = (
            f"the environment variable CC names '{one_line(words[0])}', which is not there" if chosen else ""
        )
        raise InputError(
            f"{named or 'a candidate in C needs a C compiler, but there is no cc'}; {_HOW_TO_GET_ONE}"
        )
    return (program, *words[1:])


def require_working(compiler: Sequence[str], scratch: Path) -> None:
    """Refuse a compiler that cannot compile one line, such as a shim without a toolchain."""
    (scratch / "one.c").write_text("int one(void) { return 1; }\n", encoding="utf-8")
    try:
        compile_library(compiler, Compilation(scratch, ("one.c",)), scratch)
    except CompilationError as error:
        first = next(filter(None, map(str.strip, error.output.splitlines())), "it printed nothing")
        raise InputError(
            f"the C compiler '{one_line(shlex.join(compiler))}' does not work, it cannot compile a single line: "
            f"{_bounded(first)}; {_HOW_TO_GET_ONE}"
        ) from error


def compiler_version(compiler: Sequence[str]) -> str:
    """Request from a compiler its version."""
    ended = run_bounded([*compiler, "--version"], folder=Path.cwd(), environment={}, bounds=Bounds(10.0))
    return bounded_line(next(iter(ended.output.splitlines()), ""))


def used_files(compiler: Sequence[str], plan: Compilation, scratch: Path) -> tuple[Path, ...]:
    """Request from the compiler the files that the sources are made of, those of the system apart."""
    # Of several sources, each would overwrite what is reported of the one before.
    lists = (_used_by(source, compiler, plan, scratch / "dependencies") for source in plan.sources)
    return tuple(dict.fromkeys(file for files in lists for file in files))


def _used_by(source: str, compiler: Sequence[str], plan: Compilation, rule: Path) -> list[Path]:
    _run([*compiler, "-MM", "-MF", str(rule), *_options(plan), *_named([source])], plan, rule.parent)
    # The rule is `target: file file`, continued over lines.
    text = _ESCAPED.sub(lambda found: "\0" if found[1] == " " else found[1] or found[2] or " ", _text(rule))
    names = text.partition(": ")[2].split()
    return [(plan.folder / name.replace("\0", " ")).resolve() for name in names]


def compile_library(compiler: Sequence[str], plan: Compilation, scratch: Path) -> tuple[Path, str]:
    """Compile sources to a shared library."""
    library = scratch / "library.so"
    libraries = [flag for flag in plan.flags if flag.startswith("-l")]
    command = [*compiler, *_options(plan), "-shared", "-o", str(library), *_named(plan.sources)]
    output = _run([*command, *libraries, "-lm"], plan, scratch)
    return library, output


def warnings_in_words(output: str) -> str:
    """Sum up the warnings of a compiler."""
    found = list(_WARNING.finditer(output))
    if not found:
        return ""
    others = len(found) - 1
    more = f" (and {others} more warning{'s' if others > 1 else ''})" if others else ""
    return f"{_place(found[0])}: warning: {_bounded(found[0]['message'])}{more}"


def _options(plan: Compilation) -> list[str]:
    folders = [f"-I{folder}" for folder in (*plan.include, str(include_folder()))]
    return [*FLAGS, *folders, *(flag for flag in plan.flags if not flag.startswith("-l"))]


def _named(sources: Sequence[str]) -> list[str]:
    """Name the sources so that none is taken for an option or for another language."""
    return [
        "-x",
        "c",
        *(f"./{source}" if source.startswith("-") else source for source in sources),
        "-x",
        "none",
    ]


def _run(command: Sequence[str], plan: Compilation, scratch: Path) -> str:
    environment = {"LC_ALL": "C", "TMPDIR": str(scratch)}
    # Flags and sources may start programs, or take in any file.
    isolated = isolated_command(command, requested_layers(), _places(command[0], plan, scratch))
    ended = run_bounded(isolated, folder=plan.folder, environment=environment, bounds=plan.bounds)
    if ended.status != 0:
        raise CompilationError(_sentence(ended, plan, Path(command[0]).name), ended.output)
    return ended.output


def _places(compiler: str, plan: Compilation, scratch: Path) -> Places:
    """Return what a compiler may read: itself, and the folders of sources and headers; it writes into one folder."""
    sources = [(plan.folder / source).parent for source in plan.sources]
    headers = [plan.folder / folder for folder in plan.include]
    own = [Path(compiler).parent, *Path(compiler).resolve().parents[:2], include_folder()]
    readable = (plan.folder, *sources, *headers, *own)
    return Places(tuple(str(place.resolve()) for place in readable), (str(scratch),))


def _sentence(ended: Ended, plan: Compilation, compiler: str) -> str:
    sources = ", ".join(map(one_line, plan.sources))
    if ended.status is None:
        return f"{sources}: {compiler} did not come to an end; compiling a candidate may take {plan.bounds.in_words()}"
    errors = list(_ERROR.finditer(ended.output))
    if errors:
        others = len(errors) - 1
        more = f" (and {others} more error{'s' if others > 1 else ''})" if others else ""
        return (
            f"{_place(errors[0])}: {_bounded(errors[0]['message'])}{more}; "
            f"the sources must compile with {compiler} {' '.join(FLAGS[:1])}"
        )
    lines = [found[0] for found in _LINKER.finditer(ended.output)] or ended.output.strip().splitlines()
    reason = _bounded(lines[0]) if lines else f"it ended with status {ended.status} and reported nothing"
    bounds = plan.bounds.in_words()
    return f"{sources}: {compiler} does not compile it: {reason}; compiling a candidate may take {bounds}"


def _place(found: re.Match[str]) -> str:
    return f"{_bounded(found['file'])}, line {found['line']}"


def _bounded(text: str) -> str:
    line = bounded_line(text.strip())
    return line if len(line) <= _LONGEST_MESSAGE else line[: _LONGEST_MESSAGE - 1] + "…"


def _text(file: Path) -> str:
    return file.read_text(encoding="utf-8", errors="surrogateescape") if file.exists() else ""
