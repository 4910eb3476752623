"""From a manifest of the kind ``compose`` to a candidate: a built-in controller with blocks of its own."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Final

from drivegate.candidates.builtin.candidates import BUILTIN_CANDIDATES
from drivegate.candidates.candidate import Candidate, Composition, existing_file, hash_of
from drivegate.candidates.python.resolution import module_sources
from drivegate.version import __version__
from drivegate_cases.documents.wording import nearest, one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.manifest import Manifest

BLOCKS: Final = ("angle_model", "speed_regulator", "search")
"""The blocks of the paper's Fig. 2, by their keys in a manifest."""


def from_manifest(manifest: Manifest, specification: str, folder: Path) -> Candidate:
    """Find the candidate that a manifest composes."""
    where = shown_path(specification)
    if manifest.entry not in BUILTIN_CANDIDATES:
        raise InputError(
            f"{where}: the key 'entry' is '{one_line(manifest.entry)}', but of the kind 'compose' it must name the "
            f"built-in controller that gives the other blocks; the nearest is "
            f"'{nearest(manifest.entry, BUILTIN_CANDIDATES)}' of {', '.join(BUILTIN_CANDIDATES)}"
        )
    given = {name: getattr(manifest.blocks, name) for name in BLOCKS}
    found = {name: _found(where, name, entry, folder) for name, entry in given.items() if entry is not None}
    further = manifest.source_files(folder)
    sources = tuple(dict.fromkeys((*(file for _, files in found.values() for file in files), *further)))
    names = (f"{name}={entry.rpartition(':')[2]}" for name, (entry, _) in found.items())
    identity = " ".join((f"drivegate {__version__} {manifest.entry}", *names))
    return Candidate(
        manifest.name,
        "compose",
        specification,
        manifest.entry,
        folder,
        sources,
        hash_of(sources, identity),
        # The last step of every composed controller is the built-in estimate.
        replace(manifest.declaration(), estimates_power=True),
        Composition(manifest.entry, tuple((name, entry) for name, (entry, _) in found.items())),
    )


def _found(where: str, block: str, entry: str, folder: Path) -> tuple[str, tuple[Path, ...]]:
    source, _, attribute = entry.rpartition(":")
    if not source or not all(part.isidentifier() for part in attribute.split(".")):
        raise InputError(
            f"{where}: the key '{block}' is '{one_line(entry)}', but must be file.py:name or module:name"
        )
    if source.endswith(".py"):
        file = existing_file(folder / source)
        return f"{file}:{attribute}", (file,)
    return entry, module_sources(source, folder, entry)
