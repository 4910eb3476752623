"""From the one string that names a candidate to what it is: its kind, entry, sources and declaration.

Nothing here runs a candidate's code. Whether the class exists and has its methods shows when a worker process
loads it.
"""

from collections.abc import Iterable
from dataclasses import replace
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from drivegate.candidates.builtin.candidates import BUILTIN_CANDIDATES, DUTY_CANDIDATES
from drivegate.candidates.candidate import Candidate
from drivegate.candidates.kinds import KINDS, MANIFEST_SUFFIX, WHOLE_FILE_SUFFIXES
from drivegate.isolation.layers import named_roots
from drivegate_cases.documents.reach import Reach
from drivegate_cases.documents.wording import nearest, one_line, shown_path
from drivegate_models.errors import InputError

ENTRY_POINT_GROUP = "drivegate.controllers"

_BUILTIN = (*BUILTIN_CANDIDATES, *DUTY_CANDIDATES)
_OTHER_TABLES = (".yaml", ".yml", ".json")

_WAYS = (
    f"{', '.join(way for kind in KINDS.values() for way in kind.ways)}, candidate{MANIFEST_SUFFIX} or the name of a "
    "built-in or installed controller"
)


def resolve_candidate(text: str) -> Candidate:
    """Find the candidate that a string names."""
    specification = text.strip()
    if not specification:
        raise InputError(f"the candidate's name is empty, but must be {_WAYS}")
    if "\0" in specification:
        raise InputError(
            f"the candidate '{one_line(specification)}' has a zero byte in it, but must be {_WAYS}"
        )
    # Prefixes come first: the command line after one may end like a file of any other kind.
    for kind in KINDS.values():
        if specification.startswith(kind.prefixes):
            return kind.from_text(specification)
    suffix = Path(specification).suffix.lower()
    if suffix == MANIFEST_SUFFIX:
        return _from_manifest(specification)
    for kind in KINDS.values():
        if suffix in kind.suffixes:
            return kind.from_text(specification)
    # A name is that of a known controller even where a folder is called the same.
    if suffix in _OTHER_TABLES or (
        _is_folder(specification) and specification not in (*_BUILTIN, *_installed())
    ):
        raise InputError(_instead_of(specification))
    if suffix == ".py" or ":" in specification:
        return KINDS["python"].from_text(specification)
    return _from_bare_name(specification)


def _installed() -> dict[str, EntryPoint]:
    return {point.name: point for point in entry_points(group=ENTRY_POINT_GROUP)}


def _instead_of(specification: str) -> str:
    """State what to write instead of a folder, or of a manifest in another language."""
    named = one_line(specification)
    if not _is_folder(specification):
        manifest = one_line(Path(specification).with_suffix(MANIFEST_SUFFIX).name)
        return f"the candidate '{named}' is no manifest that drivegate reads; write it as TOML, such as {manifest}"
    folder = Path(specification)
    endings = {".py", *WHOLE_FILE_SUFFIXES}
    try:
        files = sorted(path.name for path in folder.iterdir() if path.name != "pyproject.toml")
    except OSError:
        # The folder may not be listed; the sentence then names no file in it.
        files = []
    inside = [name for name in files if Path(name).suffix.lower() in endings]
    manifests = [name for name in inside if name.endswith(MANIFEST_SUFFIX)]
    chosen = next(iter([*manifests, *inside]), f"candidate{MANIFEST_SUFFIX}")
    ending = ":Class" if chosen.endswith(".py") else ""
    return (
        f"the candidate '{named}' is a folder, but must be a file in it or a name; write "
        f"{one_line(str(folder / chosen))}{ending}"
    )


def _is_folder(specification: str) -> bool:
    try:
        return Path(specification).is_dir()
    except OSError:
        # A name that is too long for any file.
        return False


def _from_bare_name(name: str) -> Candidate:
    if name in _BUILTIN:
        return KINDS["builtin"].from_text(name)
    installed = _installed()
    if name in installed:
        from drivegate.candidates.python.resolution import installed_candidate

        point = installed[name]
        return installed_candidate(name, f"{point.module}:{point.attr}")
    known = [*_BUILTIN, *sorted(installed)]
    raise InputError(
        f"the candidate '{one_line(name)}' is unknown, the nearest known one is "
        f"'{nearest(name, known)}'; known are {', '.join(known)}, or write {_WAYS}"
    )


def reach_of(manifest: Path, further: Iterable[str] = ()) -> Reach:
    """Return what a manifest may name; it may itself be a link to another one there."""
    roots = (*named_roots(), *further)
    file = Reach.of(manifest.parent, roots).place(manifest.name, "the manifest")
    return Reach.of(file.parent, roots)


def _from_manifest(specification: str) -> Candidate:
    # Reading a manifest needs pydantic, which takes longer to import than all the rest of this module.
    from drivegate.candidates.contract import ANSWERS
    from drivegate.candidates.contract_keys import refuse_other_keys
    from drivegate.candidates.manifest import Manifest
    from drivegate_cases.documents.document import read_document

    reach = reach_of(Path(specification))
    manifest = read_document(specification, Manifest, reach)
    candidate = KINDS[manifest.kind].from_manifest(manifest, specification, reach)
    stated, known = manifest.contract, candidate.contract
    if None not in (stated, known) and stated != known:
        raise InputError(
            f"{shown_path(specification)}: the key 'contract' is '{stated}', but the candidate answers with "
            f'{ANSWERS[str(known)]}; leave the key out, or write contract = "{known}"'
        )
    declaration = manifest.declaration()
    # Sources, a library or a name may show a contract that the manifest does not state.
    refuse_other_keys(declaration, known, f"{shown_path(specification)}: ")
    if manifest.requirements is not None:
        from drivegate_cases.requirements.file import read_requirements

        own = read_requirements(reach.file(manifest.requirements, "the key 'requirements'"))
        declaration = replace(declaration, requirements=own)
    # What every kind takes from its manifest in the same way.
    return replace(
        candidate,
        name=manifest.name,
        declaration=declaration,
        drive=manifest.drive,
        contract=known or stated,
    )
