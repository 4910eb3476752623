"""What is common to making and reading result documents; `drivegate.results.document` has their keys."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Final

from drivegate.checks.margin import margin_in_words
from drivegate.results.provenance import hash_of_content

RESULT_SCHEMA: Final = 2
"""Version of the result document."""
MOST_MARGINS: Final = 1000
"""Most margins of a check that a result keeps."""
NOT_WITNESSED: Final = "not yet witnessed"
"""Verdict of a check that failed before known good controllers were run there; it does not count as a failure."""
NEVER_JUDGED: Final = "never judged"
"""Verdict of a user's row that no run of the plan has met: nothing shows that the candidate does what it requires."""
STALE_WAIVERS: Final = ("waiver expired", "unexpectedly passes")
"""Verdicts of checks whose waiver has to be renewed or removed."""

_ALTERED: Final = "was altered after drivegate wrote it: its content is not that of its content hash"
_WITHOUT_HASH: Final = "has no content hash, so nothing shows whether it is as drivegate wrote it"


def counted_levels(fail_on: str | None) -> tuple[str, ...]:
    """Return the levels of checks whose failure fails a candidate; earlier results state none, which means required."""
    return ("required", "advisory") if fail_on == "advisory" else ("required",)


def witness_in_words(witness: Mapping[str, Any]) -> str:
    """State in one clause that a known good controller meets a requirement."""
    knowing = ", which knows more than its nameplate," if witness["knows_plant"] else ""
    return f"{witness['name']}{knowing} meets it there with margin {margin_in_words(witness['margin'])}"


def content_hash(document: Mapping[str, Any]) -> str:
    """Hash all that a result says but its times, a signature in it and what dying processes printed."""
    hashed = {key: value for key, value in document.items() if key not in ("timing", "signature")}
    # What a dying process printed differs from run to run.
    hashed["faults"] = [{**fault, "traceback": ""} for fault in document["faults"]]
    return hash_of_content(hashed)


def alteration_of(document: Mapping[str, Any]) -> str:
    """State, after the name of a result, that its content does not fit its hash; empty where it does."""
    provenance = document.get("provenance")
    stated = provenance.get("content_hash") if isinstance(provenance, Mapping) else None
    try:
        return "" if stated == content_hash(document) else _ALTERED if stated else _WITHOUT_HASH
    except (LookupError, TypeError, AttributeError, ValueError, RecursionError):
        # What is missing is needed to compute the hash.
        return _ALTERED if stated else _WITHOUT_HASH


def finite(value: Any) -> Any:
    """Replace numbers that JSON cannot write by null, and tuples by lists."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return value
