"""What writes reports: entry points of installed packages, which the harness finds by name and imports none of."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from typing import Any, Final, TypeAlias

from drivegate_models.errors import InputError

REPORT_GROUP: Final = "drivegate.reports"
"""Group of entry points, each a function of the result document and a folder that returns what it wrote."""
REPRODUCTION_GROUP: Final = "drivegate.reproductions"
"""Group of entry points, each a function of a folder that reproduces a publication into it and returns a document."""
PUBLICATION: Final = "paper"
"""Name of the entry point that reproduces the publication that drivegate rests on."""

WriteReport: TypeAlias = Callable[[dict[str, Any], Path], Path]
"""From a result document and an existing folder to the page that was written."""
Reproduce: TypeAlias = Callable[[Path], dict[str, Any]]
"""From an existing folder to the document of what was written into it."""


def report_points() -> dict[str, EntryPoint]:
    """Find the reports that installed packages offer."""
    return {
        point.name: point for point in sorted(entry_points(group=REPORT_GROUP), key=lambda point: point.name)
    }


def reproduction_writer() -> Reproduce:
    """Load what reproduces the publication."""
    for point in entry_points(group=REPRODUCTION_GROUP, name=PUBLICATION):
        reproduce: Reproduce = point.load()
        return reproduce
    raise InputError(
        f"no installed package offers the entry point '{PUBLICATION}' of the group '{REPRODUCTION_GROUP}'; "
        "install drivegate anew, which brings it"
    )
