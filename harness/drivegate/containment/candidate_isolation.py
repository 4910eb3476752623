"""What isolates a candidate's process, and the files that it may read all the same."""

from pathlib import Path

from drivegate.candidates.candidate import Candidate, NativeBuild, OuterLoop, Program, Target
from drivegate.candidates.kinds import KINDS
from drivegate.isolation.installations import installation_of
from drivegate.isolation.layers import Layer, named_roots, requested_layers


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
        if candidate.instrumented is not None:
            looking = candidate.instrumented
            places += filter(None, (looking.library, looking.reference, looking.stepper))
    elif isinstance(details, Target):
        places.append(details.image)
    elif isinstance(details, Program):
        named = [candidate.folder.resolve(), *map(Path, named_roots())]
        for program in (details.executable, details.executable.resolve()):
            # What is above a folder that the candidate is in, or that the user names, is not the candidate's.
            is_own = any(program.is_relative_to(place) for place in named)
            places += [program] if is_own else installation_of(program)
    elif isinstance(details, OuterLoop):
        places += _own_places(details.outer)
    return places


def written_places(candidate: Candidate) -> tuple[str, ...]:
    """Return the folders into which a candidate's process writes what was counted in it."""
    return () if candidate.instrumented is None else (str(candidate.instrumented.folder),)


def own_environment(candidate: Candidate) -> dict[str, str]:
    """Return the variables that a candidate's process starts with because of what looks into it."""
    return {} if candidate.instrumented is None else dict(candidate.instrumented.environment)
