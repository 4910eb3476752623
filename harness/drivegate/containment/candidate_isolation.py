"""What isolates a candidate's process, and the files that it may read all the same."""

from pathlib import Path

from drivegate.candidates.candidate import Candidate, NativeBuild, OuterLoop, Program, Target
from drivegate.candidates.kinds import KINDS
from drivegate.isolation.layers import Layer, requested_layers


def isolating_layers(candidate: Candidate) -> tuple[Layer, ...] | None:
    """Return what isolates a candidate's process; None for a built-in controller, which has no process."""
    return None if KINDS[candidate.kind].is_included else requested_layers()


def own_places(candidate: Candidate) -> tuple[str, ...]:
    """Return the files and folders that a candidate consists of, with what a program of an installation needs."""
    return tuple(str(place.absolute()) for place in _own_places(candidate))


def _own_places(candidate: Candidate) -> list[Path]:
    places = [candidate.folder, *candidate.sources]
    details = candidate.details
    if isinstance(details, NativeBuild):
        places.append(details.library)
    elif isinstance(details, Target):
        places.append(details.image)
    elif isinstance(details, Program):
        places += map(_installation_of, (details.executable, details.executable.resolve()))
    elif isinstance(details, OuterLoop):
        places += _own_places(details.outer)
    return places


def _installation_of(program: Path) -> Path:
    """Return the folder with a program's libraries, or with what a version manager's shim starts."""
    folder = program.parent
    # The folder above /bin is the whole file system, which is no installation.
    is_part = folder.name in ("bin", "shims") and folder.parent != Path(folder.anchor)
    return folder.parent if is_part else program
