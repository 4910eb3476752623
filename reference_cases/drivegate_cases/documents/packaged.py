"""Finding the documents that come with drivegate, by their bare names."""

from collections.abc import Callable, Iterable
from importlib.resources import as_file, files
from pathlib import Path

from drivegate_cases.documents.document import DocumentT, read_document
from drivegate_cases.documents.reach import Reach
from drivegate_cases.documents.reading import SUFFIXES
from drivegate_cases.documents.wording import nearest, one_line
from drivegate_models.errors import InputError


def packaged_names(folder: str) -> tuple[str, ...]:
    entries = (files("drivegate_cases") / folder).iterdir()
    return tuple(
        sorted(entry.name.removesuffix(".toml") for entry in entries if entry.name.endswith(".toml"))
    )


def load_named(
    name_or_path: str | Path,
    model: type[DocumentT],
    folder: str,
    noun: str,
    *,
    relative_to: Path | None = None,
    reach: Reach | None = None,
    further: Callable[[], Iterable[str]] = tuple,
) -> DocumentT:
    """Load a document of the package by its name, or any other by its path, within the reach of what names it.

    `further`: lists other names that exist, for the sentence about one that does not.
    """
    name = str(name_or_path)
    is_path = "/" in name or "\\" in name or name.lower().endswith(SUFFIXES)
    if isinstance(name_or_path, Path) or is_path:
        path = Path(name_or_path)
        if reach is not None:
            return read_document(reach.place(name, f"the path of the {noun}"), model, reach)
        return read_document(path if relative_to is None else relative_to / path, model)
    known = packaged_names(folder)
    if name not in known:
        raise InputError(
            f"no {noun} is called '{one_line(name)}', the nearest is '{nearest(name, (*known, *further()))}'; "
            f"there are {', '.join(known)}, or a path that ends in .toml or .json"
        )
    with as_file(files("drivegate_cases") / folder / f"{name}.toml") as path:
        return read_document(path, model)
