"""Building a candidate by the commands of its own project, such as ``cargo build --release``.

The commands see a copy of the sources that the manifest names, and nothing else of the project. So what they make
depends on the files that the candidate's hash covers, and is made again only when those or the commands change.
Commands run as compilers do: isolated, and within bounds.
"""

from __future__ import annotations

import logging
import os
import platform
import shlex
import shutil
import sysconfig
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Final

from drivegate.candidates.candidate import hash_of
from drivegate.candidates.command_path import command_path
from drivegate.candidates.fault import bounded_line
from drivegate.candidates.native.bounded_command import Bounds, Ended, run_bounded
from drivegate.candidates.native.build import cache_folder, digest_of
from drivegate.candidates.native.c_shims import FurtherFlags, write_shims
from drivegate.candidates.native.compiler import include_folder
from drivegate.candidates.native.compiler_wrappers import private_caches
from drivegate.candidates.native.rust_shim import write_shim
from drivegate.candidates.native.second_build import OWN_SOURCE
from drivegate.isolation.layers import Places, isolated_command, requested_layers
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

BUILD: Final = Bounds(600.0, 8 * 2**30, 2**30)
"""What all commands of a build may use together, and each of its processes."""

_LAST_LINES: Final = 4
_PROJECT: Final = "project"
"""Name of the copy's folder."""
TOOLS: Final = "tools"
"""Name of the folder next to it with programs in the places of compilers."""
_KEPT: Final = ".built-"
"""What the name of a folder begins with in which all that was made is kept."""
_INSTALLATION: Final = MappingProxyType(
    {
        "cargo": "install Rust from https://rustup.rs",
        "cmake": "apt install cmake, or pip install cmake",
        "make": "apt install make",
    }
)

_log = logging.getLogger("drivegate")


@dataclass(frozen=True)
class ProjectBuild:
    manifest: str
    """The manifest, as messages name it."""
    folder: Path
    """Its folder, in whose copy the commands run."""
    commands: tuple[str, ...]
    """Command lines, one after the other; no shell reads them."""
    sources: tuple[Path, ...]
    """The files that are copied."""
    artefact: str
    """Path of the file that the commands make, from the folder."""
    bounds: Bounds = BUILD
    rust_flags: tuple[str, ...] = ()
    """Further flags of Rust's compiler, whatever command starts it."""
    c_flags: FurtherFlags | None = None
    """Further flags of the compilers of C and C++."""


def built_artefact(build: ProjectBuild) -> Path:
    """Run the commands, or find what they made of the same sources before.

    Raises InputError if a command is missing or fails, or if the file is not made.
    """
    artefact, commands = _required(build)
    folder = cache_folder()
    kept = folder / f"{_key(build)}{artefact.suffix}"
    with _writing(build, folder):
        if not kept.exists():
            with tempfile.TemporaryDirectory(prefix=".building-", dir=folder) as scratch:
                # Renamed as a whole, so that another process finds either all of the file or none.
                _made(build, commands, Path(scratch).resolve()).replace(kept)
    return kept


def build_in_kept_folder(build: ProjectBuild) -> Path:
    """Do the same, but keep all that the commands make where they make it."""
    artefact, commands = _required(build)
    folder = cache_folder()
    place = folder / f"{_key(build)}.place"
    with _writing(build, folder):
        if not place.exists():
            scratch = Path(tempfile.mkdtemp(prefix=_KEPT, dir=folder)).resolve()
            try:
                _made(build, commands, scratch)
                write_atomically(place, scratch.name)
            except BaseException:
                shutil.rmtree(scratch)
                raise
        root = (folder / place.read_text(encoding="utf-8") / _PROJECT).resolve()
    return root / build.folder.relative_to(common_folder(build)) / artefact


def copy_around(made: Path) -> Path:
    """Return the copy of a project in whose kept folder a file was made."""
    return next(folder for folder in made.parents if folder.parent.name.startswith(_KEPT))


def _required(build: ProjectBuild) -> tuple[Path, tuple[list[str], ...]]:
    """Return the file that the commands make, and the words of each."""
    artefact = Path(build.artefact)
    if artefact.is_absolute() or ".." in artefact.parts:
        raise InputError(
            f"{build.manifest}: the key 'entry' is '{one_line(build.artefact)}', but with 'build' must be a path "
            "inside the manifest's folder"
        )
    return artefact, tuple(_words_of(command, build.manifest) for command in build.commands)


@contextmanager
def _writing(build: ProjectBuild, folder: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise InputError(
            f"{build.manifest}: its sources cannot be copied to {shown_path(folder)} and built there: "
            f"{error.strerror}; name another folder in DRIVEGATE_CACHE"
        ) from error


def _words_of(command: str, manifest: str) -> list[str]:
    """Split a command line, and require its program."""
    try:
        words = shlex.split(command)
    except ValueError as error:
        raise InputError(
            f"{manifest}: the key 'build' has '{one_line(command)}', which is no command line: {error}"
        ) from error
    if not words:
        raise InputError(f"{manifest}: the key 'build' has an empty command; write one such as 'make'")
    if os.sep not in words[0] and shutil.which(words[0], path=command_path()) is None:
        program = one_line(words[0])
        how = _INSTALLATION.get(words[0], "install it, or add its folder to PATH")
        raise InputError(
            f"{manifest}: the key 'build' needs the program '{program}', which is missing; {how}"
        )
    return words


def _key(build: ProjectBuild) -> str:
    """Hash all that decides on the artefact; other tools are found along another PATH."""
    places = [os.path.relpath(source, build.folder) for source in build.sources]
    # Such a build names the files themselves, for reports.
    flags = (*build.rust_flags, str(build.folder)) if build.rust_flags else ()
    if build.c_flags:
        own = OWN_SOURCE.read_text(encoding="utf-8")
        flags = (*flags, *build.c_flags.compiled, *build.c_flags.linked, own)
    return hash_of(
        build.sources,
        digest_of(
            *(*build.commands, build.artefact, platform.machine(), command_path()),
            *flags,
            *places,
        ),
    )[:32]


def _made(build: ProjectBuild, commands: tuple[list[str], ...], scratch: Path) -> Path:
    """Build in a copy, and return the file that was made there."""
    _log.info("building %s for %s", one_line(build.artefact), build.manifest)
    root, common = scratch / _PROJECT, common_folder(build)
    here = _copy_of(build, root, common)
    (scratch / "temporary").mkdir()
    environment = _environment(scratch)
    tools = scratch / TOOLS
    tools.mkdir()
    environment["PATH"] = os.pathsep.join((str(tools), environment["PATH"]))
    if build.rust_flags:
        environment |= write_shim(tools, build.rust_flags, root, common)
    if build.c_flags:
        write_shims(tools, build.c_flags)
    deadline = time.monotonic() + build.bounds.seconds
    for words, command in zip(commands, build.commands, strict=True):
        # All commands share the time; one without any left starts all the same, and is reported as out of time.
        left = replace(build.bounds, seconds=max(deadline - time.monotonic(), 0.1))
        ended = run_bounded(
            isolated_command(words, requested_layers(), Places(tuple(_readable()), (str(scratch),))),
            folder=here,
            environment=environment,
            bounds=left,
        )
        if ended.status != 0:
            raise InputError(_failure(build, command, ended))
    # A link must not lead out of the copy.
    made = (here / build.artefact).resolve()
    if not (made.is_file() and made.is_relative_to(scratch)):
        raise InputError(
            f"{build.manifest}: the commands of 'build' made no file '{one_line(build.artefact)}'; name in 'entry' the "
            "file that they make"
        )
    return made


def common_folder(build: ProjectBuild) -> Path:
    """Return the folder that the manifest's and all sources are in."""
    return Path(os.path.commonpath((build.folder, *(source.parent for source in build.sources))))


def _copy_of(build: ProjectBuild, root: Path, common: Path) -> Path:
    """Copy the sources, those outside of the folder at the same places relative to it; return the folder's copy."""
    here = root / build.folder.relative_to(common)
    here.mkdir(parents=True)
    for source in build.sources:
        target = root / source.relative_to(common)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(source, target)
    return here


def _environment(scratch: Path) -> dict[str, str]:
    """Return what the commands find in the environment: `drivegate include-dir` too, and no network for cargo."""
    path = os.pathsep.join((command_path(), sysconfig.get_path("scripts")))
    temporary = scratch / "temporary"
    own = {"LC_ALL": "C", "TMPDIR": str(temporary), "PATH": path, "CARGO_NET_OFFLINE": "true"}
    return own | private_caches(temporary)


def _readable() -> Iterator[str]:
    """Return what tools may read, besides the system: programs, headers, Rust's compilers and the crates at hand."""
    yield from filter(os.path.isabs, command_path().split(os.pathsep))
    yield str(include_folder())
    home = Path.home()
    yield os.environ.get("RUSTUP_HOME", str(home / ".rustup"))
    cargo = Path(os.environ.get("CARGO_HOME", home / ".cargo"))
    # Next to these it has the tokens of registries.
    yield from (str(cargo / part) for part in ("bin", "registry", "git"))


def _failure(build: ProjectBuild, command: str, ended: Ended) -> str:
    where = f"{build.manifest}: the build command '{one_line(command)}'"
    rules = f"a build has the files of 'sources', no network and {build.bounds.in_words()}"
    if ended.status is None:
        return f"{where} did not come to an end; {rules}"
    lines = [line.strip() for line in ended.output.splitlines() if line.strip()][-_LAST_LINES:]
    if not lines:
        return f"{where} ended with status {ended.status} and printed nothing; {rules}"
    output = cache_folder() / f"{digest_of(str(build.folder), build.artefact)}.txt"
    write_atomically(output, ended.output)
    return (
        f"{where} ended with status {ended.status}: {bounded_line(' | '.join(lines))}; "
        f"its output is in {shown_path(output)}; {rules}"
    )
