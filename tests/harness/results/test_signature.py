"""Signatures: over all that a result says, by the key that stands beside them, in one spelling alone."""

from __future__ import annotations

import copy
from typing import Any

import pytest
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from drivegate.results.result import content_hash
from drivegate.results.signature import fingerprint, is_valid, public_key_line, signed, statement
from drivegate_models.errors import InputError

KEY = Ed25519PrivateKey.from_private_bytes(bytes(range(32)))
OTHER = Ed25519PrivateKey.from_private_bytes(bytes(32))


@pytest.fixture
def document() -> dict[str, Any]:
    made = {
        "verdict": "fail",
        "faults": [{"kind": "crash", "traceback": "at 0x7f"}],
        "provenance": {"drivegate": "0.1.0"},
        "timing": {"seconds": 1.0},
    }
    made["provenance"]["content_hash"] = content_hash(made)  # type: ignore[index, call-overload]
    return made


def test_a_signature_is_over_the_content_hash(document: dict[str, Any]) -> None:
    made = signed(document, KEY)
    digest = document["provenance"]["content_hash"]
    assert {key: value for key, value in made.items() if key != "signature"} == document
    assert made["signature"]["public_key"] == public_key_line(KEY.public_key())
    KEY.public_key().verify(bytes.fromhex(made["signature"]["value"]), statement(digest))
    assert is_valid(made["signature"], digest)
    assert content_hash(made) == digest, "the signature must lie outside of what it is over"
    assert signed(document, KEY) == made, "the same key over the same content gives the same bytes"


def test_a_new_signature_takes_the_place_of_the_old(document: dict[str, Any]) -> None:
    assert signed(signed(document, OTHER), KEY) == signed(document, KEY)


def test_an_altered_document_is_not_signed(document: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="was altered after it was made"):
        signed({**document, "verdict": "pass"}, KEY)


def test_times_and_tracebacks_are_not_part_of_the_content(document: dict[str, Any]) -> None:
    later = copy.deepcopy(document)
    later["timing"]["seconds"] = 2.0
    later["faults"][0]["traceback"] = "at 0x80"
    assert content_hash(later) == content_hash(document)
    later["faults"][0]["kind"] = "hang"
    assert content_hash(later) != content_hash(document)


def test_a_signature_is_valid_for_its_own_content_alone(document: dict[str, Any]) -> None:
    signature = signed(document, KEY)["signature"]
    assert not is_valid(signature, "0" * 64)
    digest = content_hash(document)
    bare = {**signature, "value": KEY.sign(digest.encode()).hex()}
    assert not is_valid(bare, digest), "what the key signed for another purpose must not fit"
    assert not is_valid({**signature, "public_key": public_key_line(OTHER.public_key())}, digest)


@pytest.mark.parametrize("part", ["public_key", "value"])
def test_no_character_of_a_signature_can_be_another(part: str, document: dict[str, Any]) -> None:
    signature, digest = signed(document, KEY)["signature"], content_hash(document)
    text = signature[part]
    for place, character in enumerate(text):
        for other in {character.swapcase(), chr(ord(character) ^ 1), " ", ""} - {character}:
            changed = text[:place] + other + text[place + 1 :]
            assert not is_valid({**signature, part: changed}, digest), f"{part} reads {changed}"
    for surplus in (" ", "\n", " a comment", "0", "00", "="):
        assert not is_valid({**signature, part: text + surplus}, digest), f"{part} ends in {surplus!r}"


@pytest.mark.parametrize("text", ["", "ssh-ed25519", "ssh-rsa AAAA", "\ud800", "é", "\0", "x" * 100_000])
def test_what_is_no_signature_is_not_valid(text: str, document: dict[str, Any]) -> None:
    signature, digest = signed(document, KEY)["signature"], content_hash(document)
    assert not is_valid({**signature, "public_key": text}, digest)
    assert not is_valid({**signature, "value": text}, digest)


def test_a_key_is_named_as_ssh_keygen_names_it() -> None:
    # ssh-keygen -l prints this for the key whose private bytes are 0 to 31.
    line = "ssh-ed25519 AAAAC3NzaC1lZDI1NTE5AAAAIAOhB7/zzhC+HXDdGOdLwJln5NYwm6UNXx3chmQSVTG4"
    assert public_key_line(KEY.public_key()) == line
    assert fingerprint(line) == "SHA256:lbmsoA0yIEcEiVDRnMWuzm+nV+3ZEEpVIURqFoeSspg"


@pytest.mark.parametrize("line", ["", "ssh-ed25519", "ssh-ed25519 !", "ssh-ed25519 é"])
def test_a_key_that_cannot_be_read_has_no_name(line: str) -> None:
    assert fingerprint(line) == "that cannot be read"
