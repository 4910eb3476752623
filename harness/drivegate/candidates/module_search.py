"""Finding the source files of a module without importing it or any package around it."""

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

from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError


def module_sources(name: str, folder: Path, specification: str) -> tuple[Path, ...]:
    """Find the files that a module consists of."""
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
