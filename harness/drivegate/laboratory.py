"""What drivegate's laboratory adds: commands and controllers that prove drivegate itself, found by entry points.

The laboratory is a package of its own, which nothing here imports by name. An installation without it checks candidates
as any other does.
"""

from __future__ import annotations

from importlib.metadata import entry_points
from typing import Any, Final

from drivegate_models.errors import InputError

COMMAND_GROUP: Final = "drivegate.commands"
"""Group of entry points, each a command by its name on the command line."""
CANDIDATE_GROUP: Final = "drivegate.candidates"
"""Group of entry points, each a `PrefixedControllers` by the prefix without its colon."""
PUBLICATION_GROUP: Final = "drivegate.publications"
"""Group of entry points, each what pages show of a publication next to what is computed."""
LABORATORY: Final = "drivegate_lab"
"""Name of the package."""


def find_in_laboratory(group: str, name: str) -> Any | None:
    """Import what an entry point names; None where no installed package offers it."""
    for point in entry_points(group=group, name=name):
        if point.module.partition(".")[0] != LABORATORY:
            # Its code runs uncontained, so no other installed package can take its place.
            continue
        try:
            return point.load()
        except ModuleNotFoundError as error:
            # The entry points of a distribution outlive a package that was removed from it. An import that fails inside
            # the module is a fault of the laboratory.
            if not f"{point.module}.".startswith(f"{error.name}."):
                raise
    return None


def require_from_laboratory(group: str, name: str, what: str) -> Any:
    """Import what an entry point names, or refuse what needs it in one sentence."""
    found = find_in_laboratory(group, name)
    if found is None:
        raise InputError(
            f"{what} belongs to drivegate's laboratory, the package {LABORATORY}, which is not installed; install "
            "drivegate again, which brings it"
        )
    return found
