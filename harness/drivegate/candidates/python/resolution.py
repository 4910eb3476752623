"""From the name of a Python class, or a manifest with it, to a candidate; its module is found, but not imported."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterable
from importlib.machinery import (
    EXTENSION_SUFFIXES,
    SOURCE_SUFFIXES,
    ExtensionFileLoader,
    FileFinder,
    ModuleSpec,
    SourceFileLoader,
)
from pathlib import Path
from typing import TYPE_CHECKING, Final

from drivegate.candidates.candidate import Candidate, hash_of
from drivegate.candidates.contract import ContractName
from drivegate_cases.documents.reach import existing_file
from drivegate_cases.documents.regular_file import regular_content
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.candidates.manifest import Manifest
    from drivegate_cases.documents.reach import Reach

_LONGEST_PARSED: Final = 4 * 2**20
_COMMANDS: Final[dict[str, ContractName]] = {"Command": "current", "DutyCommand": "duty"}


def module_sources(name: str, folder: Path, specification: str) -> tuple[Path, ...]:
    if not all(part.isidentifier() for part in name.split(".")):
        raise InputError(
            f"the candidate '{one_line(specification)}' names the module '{one_line(name)}', which is no "
            "name of a Python module; write module:Class or file.py:Class"
        )
    spec = _find(name, folder)
    if spec is None:
        raise InputError(
            f"the candidate '{one_line(specification)}' names the module '{name}', which is neither "
            f"installed nor in the folder {folder}; name a module that can be "
            "imported, or a file as file.py:Class"
        )
    if spec.submodule_search_locations is not None:
        return tuple(
            # The hash of the candidate depends on the order of its files.
            sorted(file for place in spec.submodule_search_locations for file in Path(place).rglob("*.py"))
        )
    return (Path(spec.origin),) if spec.has_location and spec.origin else ()


def _find(name: str, folder: Path) -> ModuleSpec | None:
    """Go down the packages part by part, since `importlib.util.find_spec` would import each on the way."""
    first, *inner = name.split(".")
    spec = _top_level(first, folder)
    for part in inner:
        if spec is None or spec.submodule_search_locations is None:
            return None
        spec = _inside(part, spec.submodule_search_locations)
    return spec


def _top_level(name: str, folder: Path) -> ModuleSpec | None:
    """Find a module as an import would: one without a file, a namespace package, comes last."""
    local = _inside(name, [str(folder)])
    if local is not None and local.loader is not None:
        return local
    installed = (finder.find_spec(name, None) for finder in sys.meta_path)
    return next((spec for spec in installed if spec is not None), local)


def _inside(name: str, places: Iterable[str]) -> ModuleSpec | None:
    loaders = ((ExtensionFileLoader, EXTENSION_SUFFIXES), (SourceFileLoader, SOURCE_SUFFIXES))
    specs = (FileFinder(place, *loaders).find_spec(name) for place in places)
    return next((spec for spec in specs if spec is not None), None)


def from_text(specification: str) -> Candidate:
    if Path(specification).suffix.lower() == ".py":
        raise InputError(
            f"the candidate '{one_line(specification)}' names no class; write {one_line(specification)}:Class"
        )
    # Without the folder, so that a waiver matches wherever the file is.
    source, _, attribute = specification.rpartition(":")
    return _candidate(f"{Path(source).name}:{attribute}", specification, specification, Path.cwd())


def installed_candidate(name: str, entry: str) -> Candidate:
    """Find the class that an installed distribution offers under a name."""
    return _candidate(name, name, entry, Path.cwd())


def from_manifest(manifest: Manifest, specification: str, reach: Reach) -> Candidate:
    if ":" not in manifest.entry:
        raise InputError(
            f"{shown_path(specification)}: the key 'entry' is '{one_line(manifest.entry)}', "
            "but must be module:Class or file.py:Class"
        )
    sources = manifest.source_files(reach)
    return _candidate(
        manifest.name, specification, manifest.entry, reach.folder, sources, manifest.contract, reach
    )


def _candidate(
    name: str,
    specification: str,
    entry: str,
    folder: Path,
    further_sources: tuple[Path, ...] = (),
    contract: ContractName | None = None,
    reach: Reach | None = None,
) -> Candidate:
    source, _, attribute = entry.rpartition(":")
    if not all(part.isidentifier() for part in attribute.split(".")):
        raise InputError(
            f"the candidate '{one_line(specification)}' names the class '{one_line(attribute)}', which is no "
            "name of a Python class; write module:Class or file.py:Class"
        )
    if source.endswith(".py"):
        file = existing_file(folder / source) if reach is None else reach.file(source, "the key 'entry'")
        found: tuple[Path, ...] = (file,)
        entry, folder = f"{file}:{attribute}", file.parent
    else:
        found = module_sources(source, folder, specification)
        if reach is not None:
            # Those of an installed package are the user's.
            found = tuple(
                reach.file(str(file), "a file of the key 'entry'") if file.is_relative_to(folder) else file
                for file in found
            )
    sources = tuple(dict.fromkeys((*found, *further_sources)))
    digest = hash_of(sources, attribute)
    contract = contract or (imported_contract(found[0]) if len(found) == 1 else None)
    return Candidate(name, "python", specification, entry, folder, sources, digest, contract=contract)


def imported_contract(file: Path) -> ContractName | None:
    """Return the contract whose command a file imports from drivegate; None where it imports both or neither."""
    try:
        tree = ast.parse(regular_content(file, _LONGEST_PARSED))
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        # Loading reports what is wrong.
        return None
    imported = {
        name.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module == "drivegate"
        for name in node.names
    }
    found = {contract for command, contract in _COMMANDS.items() if command in imported}
    return found.pop() if len(found) == 1 else None
