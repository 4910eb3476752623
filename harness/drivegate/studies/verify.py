"""Holding a kept result against its content hash."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from drivegate.output.failure import ExitCode
from drivegate.output.result_reports import check_result
from drivegate.results.result import content_hash
from drivegate.results.stored import read_unverified
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

SCHEMA: Final = 2
_ALTERED: Final = "the result was altered: its content is not that of its content hash"
_UNCHANGED: Final = (
    "the content fits its hash, but anyone can make a hash; a signature of the file shows whose it is"
)
_WITH_SIGNATURE: Final = (
    "the content fits its hash; drivegate no longer checks the signature in the result, so sign the file itself with "
    "ssh-keygen -Y sign, and check it with ssh-keygen -Y verify"
)


def verification(file: Path) -> dict[str, Any]:
    """Return what ``drivegate verify --json`` prints of a result; ``outcome`` is ``unchanged`` or ``altered``."""
    document = read_unverified(file)
    stated = _stated_hash(document, file)
    digest = content_hash(document)
    unchanged = digest == stated
    if unchanged:
        # Of a document that was altered that is all there is to say.
        check_result(document, file)
    message = _WITH_SIGNATURE if document.get("signature") else _UNCHANGED
    return {
        "schema": SCHEMA,
        "kind": "verification",
        "file": str(file),
        "outcome": "unchanged" if unchanged else "altered",
        "message": message if unchanged else _ALTERED,
        "unchanged": unchanged,
        "content_hash": digest,
        "stated_hash": stated,
        "candidate": document["candidate"]["name"] if unchanged else None,
        "verdict": document["verdict"] if unchanged else None,
        "exit_code": int(ExitCode.PASSED if unchanged else ExitCode.FAILED),
    }


def _stated_hash(document: dict[str, Any], file: Path) -> str:
    """Find the content hash of a document that has all that is needed to compute it again."""
    provenance, faults = document.get("provenance"), document.get("faults")
    stated = provenance.get("content_hash") if isinstance(provenance, dict) else None
    if not isinstance(stated, str):
        raise InputError(f"{shown_path(file)} has no content hash, the text 'content_hash' in 'provenance'")
    if not isinstance(faults, list) or not all(isinstance(fault, dict) for fault in faults):
        raise InputError(f"{shown_path(file)} has no list of tables 'faults', which every result has")
    return stated
