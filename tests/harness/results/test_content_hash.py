"""The content hash: over all that a result says, except what differs from run to run."""

from __future__ import annotations

import copy
from typing import Any

import pytest

from drivegate.results.result import content_hash


@pytest.fixture
def document() -> dict[str, Any]:
    return {
        "verdict": "fail",
        "faults": [{"kind": "crash", "traceback": "at 0x7f"}],
        "provenance": {"drivegate": "0.1.0"},
        "timing": {"seconds": 1.0},
    }


def test_times_and_tracebacks_are_not_part_of_the_content(document: dict[str, Any]) -> None:
    later = copy.deepcopy(document)
    later["timing"]["seconds"] = 2.0
    later["faults"][0]["traceback"] = "at 0x80"
    assert content_hash(later) == content_hash(document)
    later["faults"][0]["kind"] = "hang"
    assert content_hash(later) != content_hash(document)


def test_a_signature_of_an_earlier_version_is_not_part_of_the_content(document: dict[str, Any]) -> None:
    signed = {**document, "signature": {"public_key": "ssh-ed25519 AAAA", "value": "00"}}
    assert content_hash(signed) == content_hash(document), "the signature was over this hash"
