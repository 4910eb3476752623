"""A small candidate that works, written into a new folder as a place to start from."""

from __future__ import annotations

import base64
import hashlib
import io
import json
import re
import tempfile
import zipfile
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from datetime import date, timedelta
from importlib.metadata import distribution
from importlib.resources import files
from importlib.util import find_spec
from os.path import relpath
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from drivegate.candidates.contract import ANSWERS, ContractName
from drivegate.drives.kinds import DEFAULT_DRIVE, DEFAULT_DRIVES
from drivegate.laboratory import LABORATORY
from drivegate.output.new_file import refuse_new_file
from drivegate.output.new_pipeline import Pipeline, pipeline_for
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_cases.drive.data_sheet import copied
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.drive_file import drive_toml
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from importlib.resources.abc import Traversable

_FOLLOWING: Final = {"speed_tolerance_rpm": None, "settling_s": None, "point": ()}
"""Requirements that follow from the rating, as they are left out."""
_PACKAGES: Final = ("drivegate_models", "drivegate_cases", "drivegate", "drivegate_reports", LABORATORY)
_METADATA: Final = ("METADATA", "WHEEL", "entry_points.txt", "licenses/LICENSE")
_EARLIEST: Final = (1980, 1, 1, 0, 0, 0)
"""The one time of every file: equal sources give equal bytes."""
_SHARED_FILE: Final = 0o100644 << 16
WAIVED: Final = timedelta(days=90)
"""Time for which the exercise's failures are waived."""

WHEELS: Final = "vendor"
"""Folder of a new candidate that holds the drivegate it was written by, for its pipeline to install."""
REQUIREMENTS: Final = f"{WHEELS}/requirements.txt"
"""File of versions and hashes of what drivegate needs of others."""

_TEMPLATES: Final = "templates/new"
_COMMON: Final[Mapping[ContractName, tuple[str, ...]]] = MappingProxyType(
    {"current": ("every",), "duty": ("every", "every-duty")}
)
"""Folders of what all candidates of a contract have, a later one's files in place of an earlier one's."""
HOST_MANIFEST: Final = "host.toml"
"""Manifest of an image's sources, compiled for this machine; few templates have one."""
_QUICK: Final = "drivegate check --effort quick"
_FIRST: Final[Mapping[ContractName, str]] = MappingProxyType({"duty": f"{_QUICK} --only DEC-1"})
"""Command that has a verdict within a minute where all checks take longer."""
_NAME: Final = re.compile(r"[A-Za-z][A-Za-z0-9_-]{0,63}")
_IGNORED: Final = "gitignore"
"""Name of a template that means nothing to the tools of this repository."""
_JOINED: Final = (_IGNORED, "requirements.txt")
"""Files of which those of several folders are joined."""


@dataclass(frozen=True)
class Template:
    """A kind of candidate that there is a template of."""

    source: str
    """The file that the controller is in."""
    folders: Mapping[ContractName, tuple[str, ...]]
    """Folders of its files for each contract that it has one of, a later one's files in place of an earlier one's.
    The first contract is that of a candidate for which no drive is named."""
    unsensed: tuple[str, ...] = ()
    """Folders that a drive without a position sensor has as well; empty for a template that needs the sensor."""
    extra: str = ""
    """Optional dependencies of drivegate that the candidate needs; empty for none."""
    is_slow: bool = False
    """Whether steps of duty ratios take so long that a whole check at quick effort takes minutes."""


KINDS: Final = MappingProxyType(
    {
        "python": Template("controller.py", {"duty": ("python-duty",), "current": ("python",)}, is_slow=True),
        "numba": Template("controller.py", {"duty": ("numba-duty",), "current": ("numba",)}),
        "c": Template("controller.c", {"duty": ("c-duty",), "current": ("c",)}, unsensed=("c-sensorless",)),
        "c++": Template("controller.cpp", {"duty": ("cpp-duty",), "current": ("cpp",)}),
        "rust": Template("src/lib.rs", {"duty": ("rust-duty",), "current": ("rust",)}),
        "cortex-m": Template(
            "controller.c",
            {"duty": ("c-duty", "cortex-m-duty"), "current": ("c", "cortex-m")},
            extra="[elf]",
        ),
        "fmu": Template(
            "controller.c",
            {"duty": ("c-duty", "fmu", "fmu-duty"), "current": ("c", "fmu", "fmu-current")},
            extra="[fmu]",
            is_slow=True,
        ),
        "exec": Template("controller.py", {"duty": ("exec-duty",), "current": ("exec",)}, is_slow=True),
        "embedded-coder": Template(
            "adapter.c",
            {"duty": ("embedded-coder",)},
            unsensed=("c-sensorless", "embedded-coder-sensorless"),
        ),
    }
)
"""The kinds, by the name on the command line."""


@dataclass(frozen=True)
class Written:
    """What has been written."""

    files: tuple[Path, ...]
    """From the new folder."""
    hint: str | None
    """What is left to do for the pipeline; None for nothing."""
    first_check: str
    """The command that has a verdict soonest."""


def write_candidate(
    kind: str,
    name: str,
    folder: Path,
    today: date,
    drive: str | None = None,
    service: str = "github",
    schemas: Mapping[str, bytes] = MappingProxyType({}),
) -> Written:
    """Write a new candidate, for a drive that is included or a copy of a file of one, with the schemas of its files.

    The drive decides what the controller answers with. Without one it is field-oriented control. In a repository, the
    pipeline is written where `service` looks for it: ``github``, ``gitlab`` or ``none``.
    """
    if not _NAME.fullmatch(name):
        raise InputError(
            f"the name '{one_line(name)}' must begin with a letter and have letters, digits, '-' and '_' after it, "
            "64 at most; a folder is named with --output"
        )
    occupied = folder.is_symlink() or (folder.exists() and not folder.is_dir())
    if occupied or (folder.is_dir() and any(folder.iterdir())):
        raise InputError(
            f"{shown_path(folder)} exists already, and nothing is ever overwritten; name another folder with --output"
        )
    template = KINDS[kind]
    contract, folders = next(iter(template.folders.items()))
    if drive is not None:
        contract, folders = _folders_for(template, drive, kind)
    pipeline = pipeline_for(service, folder, name)
    words = {
        "@name@": name,
        "@expires@": (today + WAIVED).isoformat(),
        "@source@": template.source,
        "@install@": f"{WHEELS}/{wheel_name()}{template.extra}",
        "@wheel@": f"{WHEELS}/{wheel_name()}",
        "@requirements@": REQUIREMENTS,
        "@here@": pipeline.here,
        "@pipeline@": pipeline.rows(),
    }
    texts = _texts_of((*_COMMON[contract], *folders), words)
    first_check = _first_check(template, contract, texts)
    if first_check != _QUICK:
        texts["README.md"] = texts["README.md"].replace(_QUICK, f"{first_check}\n{_QUICK}")
    contents = {place: text.encode() for place, text in texts.items() if place not in pipeline.left_out}
    contents[".gitignore"] = contents.pop(_IGNORED)
    contents[REQUIREMENTS] = contents.pop("requirements.txt")
    outside = _move_pipeline(contents, pipeline)
    contents[words["@wheel@"]] = _wheel_bytes()
    contents |= schemas
    usual = DEFAULT_DRIVES[contract]
    if drive is None and usual != DEFAULT_DRIVE:
        # Manifest and waivers that name none are for the default drive.
        drive = usual
    if drive is not None:
        _name_drive(contents, drive)
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{name}-", dir=folder.parent) as scratch:
            made = Path(scratch) / name
            for place, content in contents.items():
                target = made / place
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(content)
            made.rename(folder)
        for target, content in outside.items():
            target.parent.mkdir(parents=True, exist_ok=True)
            write_atomically(target, content.decode())
    except OSError as error:
        raise InputError(
            f"{shown_path(folder)} cannot be written: {one_line(error.strerror or str(error))}; name another folder "
            "with --output"
        ) from error
    above = [Path(relpath(target, folder.resolve())) for target in outside]
    return Written(tuple(sorted([*map(Path, contents), *above])), pipeline.hint, first_check)


def _texts_of(folders: Iterable[str], words: Mapping[str, str]) -> dict[str, str]:
    """Join the folders of a template, and fill in its words."""
    root = files("drivegate").joinpath(_TEMPLATES)
    texts: dict[str, str] = {}
    for part in folders:
        added = {place: data.decode() for place, data in _contents(root.joinpath(part))}
        texts |= added | {name: texts.get(name, "") + added.get(name, "") for name in _JOINED}
    for word, value in words.items():
        texts = {place: text.replace(word, value) for place, text in texts.items()}
    return texts


def _first_check(template: Template, contract: ContractName, texts: Mapping[str, str]) -> str:
    if HOST_MANIFEST in texts:
        return f"drivegate check {HOST_MANIFEST} --effort quick"
    return _FIRST.get(contract, _QUICK) if template.is_slow else _QUICK


def _move_pipeline(contents: dict[str, bytes], pipeline: Pipeline) -> dict[Path, bytes]:
    """Give the pipeline's files their names, and take out those that belong into the repository around the folder."""
    outside: dict[Path, bytes] = {}
    for template, place in pipeline.places.items():
        content = contents.pop(template)
        if place.is_absolute():
            outside[place] = content
        else:
            contents[str(place)] = content
    return outside


def _folders_for(template: Template, drive: str, kind: str) -> tuple[ContractName, tuple[str, ...]]:
    """Return the contract of a named drive, which the template must have, and the folders for it."""
    from drivegate_cases.drive.drive_document import load_drive

    named = load_drive(drive)
    for contract in template.folders:
        if contract == named.contract:
            return contract, (*template.folders[contract], *_unsensed(template, named, kind))
    others = ", ".join(other for other, known in KINDS.items() if named.contract in known.folders)
    own = " or ".join(ANSWERS[contract] for contract in template.folders)
    raise InputError(
        f"the drive '{one_line(named.name)}' of the kind '{named.kind}' takes {ANSWERS[named.contract]}, but the "
        f"template '{kind}' answers with {own}; take one of {others}, or name another drive"
    )


def _unsensed(template: Template, named: DriveDocument, kind: str) -> tuple[str, ...]:
    """Return the folders more for a drive without a position sensor, which the template must have for it."""
    if named.position != "none":
        return ()
    if not template.unsensed:
        able = " or ".join(other for other, known in KINDS.items() if known.unsensed)
        raise InputError(
            f"the drive '{one_line(named.name)}' has no position sensor, but the template '{kind}' needs one; take "
            f"{able}, or name another drive"
        )
    return template.unsensed


def _name_drive(contents: dict[str, bytes], drive: str) -> None:
    """Have manifest and waivers name a drive, with a copy of its file next to them."""
    from drivegate_cases.drive.drive_document import is_included, load_drive

    name = load_drive(drive).name
    if not is_included(drive):
        place = f"drive{Path(drive).suffix.lower()}"
        contents[place], drive = Path(drive).read_bytes(), place
    manifests = [file for file in ("candidate.toml", HOST_MANIFEST) if file in contents]
    for file, before, value in (
        *((manifest, "\nkind", drive) for manifest in manifests),
        ("waivers.toml", "\nreason", name),
    ):
        line = f"\ndrive = {json.dumps(value, ensure_ascii=False)}{before}"
        contents[file] = contents[file].replace(before.encode(), line.encode())


def wheel_name() -> str:
    return f"drivegate-{distribution('drivegate').version}-py3-none-any.whl"


def _wheel_bytes() -> bytes:
    """Pack the packages that are installed, or that a working tree has, into a wheel; the laboratory may be missing."""
    place = f"drivegate-{distribution('drivegate').version}.dist-info"
    packages = [name for name in _PACKAGES if name != LABORATORY or find_spec(name)]
    contents = {f"{name}/{path}": data for name in packages for path, data in _contents(files(name))}
    contents |= {
        f"{place}/{name}": text.encode()
        for name in _METADATA
        if (text := distribution("drivegate").read_text(name))
    }
    record = "".join(f"{path},{_digest(data)},{len(data)}\n" for path, data in sorted(contents.items()))
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for path, data in [
            *sorted(contents.items()),
            (f"{place}/RECORD", f"{record}{place}/RECORD,,\n".encode()),
        ]:
            entry = zipfile.ZipInfo(path, _EARLIEST)
            entry.external_attr = _SHARED_FILE
            archive.writestr(entry, data, zipfile.ZIP_DEFLATED, 9)
    return packed.getvalue()


def _contents(folder: Traversable, prefix: str = "") -> Iterator[tuple[str, bytes]]:
    for entry in folder.iterdir():
        if entry.is_dir():
            if entry.name != "__pycache__":
                yield from _contents(entry, f"{prefix}{entry.name}/")
        elif not entry.name.endswith((".pyc", ".nbc", ".nbi")):
            yield f"{prefix}{entry.name}", entry.read_bytes()


def _digest(data: bytes) -> str:
    return "sha256=" + base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()


def write_drive(file: Path, drive: DriveDocument) -> None:
    """Write a drive's file; nothing is ever overwritten."""
    refuse_new_file(file, "a drive's")
    write_atomically(file, drive_toml(drive))


def drive_to_edit(name: str, start: DriveDocument) -> DriveDocument:
    """Return a drive with the values of another, without those that follow: of other values they would be wrong."""
    known = type(start.requirements).model_fields
    following = {key: value for key, value in _FOLLOWING.items() if key in known}
    values = start.to_mapping()
    # Each value is stated to be the other drive's, until somebody changes it.
    provenance = {
        table: {
            key: copied(start.name[:200], values[table].get(key))
            for key in sentences
            if key not in _FOLLOWING
        }
        for table, sentences in start.provenance.items()
        if table != "advance"
    }
    return start.replaced(name=name, advance=None, provenance=provenance, **following)
