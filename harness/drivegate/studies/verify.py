"""Holding a kept result against its content hash and its signature."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

from drivegate.output.failure import ExitCode
from drivegate.output.result_reports import check_result, read_unchecked_result
from drivegate.results.result import content_hash
from drivegate.results.signature import (
    fingerprint,
    is_valid,
    public_key_line,
    read_public_key,
    require_cryptography,
)
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

SCHEMA: Final = 1
"""Version of the document of a verification."""


def verification(file: Path, key: Path | None) -> dict[str, Any]:
    """Return what ``drivegate verify --json`` prints of a result that must be signed by a key, or by any for None.

    ``outcome`` is ``altered``, ``invalid signature``, ``not signed``, ``another key``, ``valid``, or ``unsigned`` where
    no signature was asked for.
    """
    document = read_unchecked_result(file)
    stated = _stated_hash(document, file)
    expected = None if key is None else public_key_line(read_public_key(key))
    digest = content_hash(document)
    unchanged = digest == stated
    if unchanged:
        # Of a document that was altered that is all there is to say, whichever key it was.
        check_result(document, file)
    signature = document.get("signature") if unchanged else None
    outcome = _outcome(signature, digest, expected) if unchanged else "altered"
    signer = None if signature is None else fingerprint(signature["public_key"])
    return {
        "schema": SCHEMA,
        "kind": "verification",
        "file": str(file),
        "outcome": outcome,
        "message": _message(outcome, signer, None if expected is None else fingerprint(expected)),
        "unchanged": unchanged,
        "signed_by": signer if outcome in ("valid", "another key") else None,
        "expected_signer": None if expected is None else fingerprint(expected),
        "content_hash": digest,
        "stated_hash": stated,
        "candidate": document["candidate"]["name"] if unchanged else None,
        "verdict": document["verdict"] if unchanged else None,
        "exit_code": int(ExitCode.PASSED if outcome in ("valid", "unsigned") else ExitCode.FAILED),
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


def _outcome(signature: dict[str, str] | None, digest: str, expected: str | None) -> str:
    if signature is None:
        return "unsigned" if expected is None else "not signed"
    require_cryptography()
    if not is_valid(signature, digest):
        return "invalid signature"
    return "valid" if expected in (None, signature["public_key"]) else "another key"


def _message(outcome: str, signer: str | None, expected: str | None) -> str:
    if outcome == "altered":
        return "the result was altered: its content is not that of its content hash"
    if outcome == "unsigned":
        return "the content fits its hash, but there is no signature, and anyone can make a hash"
    if outcome == "not signed":
        return f"the content fits its hash, but nobody signed it; it must be signed by the key {expected}"
    if outcome == "invalid signature":
        return "the content fits its hash, but the signature is not that of its key over this content"
    if outcome == "another key":
        return f"the signature is valid, but by the key {signer}; it must be signed by {expected}"
    if expected is None:
        return f"unchanged, and signed by the key {signer}; --key checks whether that is the one you expect"
    return f"unchanged, and signed by the expected key {expected}"
