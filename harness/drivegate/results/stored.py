"""Reading a result that was kept: what every command that reads one goes through."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

from drivegate.results.counterexample import require_kind
from drivegate.results.result import alteration_of
from drivegate_cases.documents.reading import read_mapping
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

_log = logging.getLogger("drivegate")


def read_unverified(path: Path) -> dict[str, Any]:
    """Read a document that says of itself that it is the result of a check."""
    mapping = read_mapping(path)
    if mapping.get("kind") == "checks":
        raise InputError(
            f"{shown_path(path)} holds the results of several candidates; name the result.json of one of them"
        )
    require_kind(mapping, "check", path)
    return mapping


def read_stored(path: Path) -> dict[str, Any]:
    """Read a result, and warn if it is not as drivegate wrote it."""
    mapping = read_unverified(path)
    if words := alteration_of(mapping):
        _log.warning("%s %s", shown_path(path), words)
    return mapping
