"""A signature over the content hash of a result: who vouches for it, and whether it still says the same."""

from __future__ import annotations

import base64
import binascii
import hashlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from drivegate.results.result import content_hash
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey


def statement(digest: str) -> bytes:
    """Write what is signed; the words keep a signature that was made for something else from fitting."""
    return f"drivegate result sha256:{digest}\n".encode()


def signed(document: Mapping[str, Any], key: Ed25519PrivateKey) -> dict[str, Any]:
    """Return a result with the key ``signature``, which lies outside its content hash.

    An earlier signature is replaced. A document that no longer matches its content hash raises `InputError`.
    """
    digest = content_hash(document)
    if digest != document["provenance"].get("content_hash"):
        raise InputError(
            "the result was altered after it was made, so it is not signed: its content hash differs"
        )
    signature = {
        "public_key": public_key_line(key.public_key()),
        "value": key.sign(statement(digest)).hex(),
    }
    return {**document, "signature": signature}


def is_valid(signature: Mapping[str, str], digest: str) -> bool:
    """Tell whether a signature is that of the key beside it, over a content hash, character by character."""
    from cryptography.exceptions import InvalidSignature, UnsupportedAlgorithm
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey
    from cryptography.hazmat.primitives.serialization import load_ssh_public_key

    try:
        key, value = load_ssh_public_key(signature["public_key"].encode()), bytes.fromhex(signature["value"])
        if not isinstance(key, Ed25519PublicKey):
            return False
        key.verify(value, statement(digest))
    except (ValueError, UnsupportedAlgorithm, InvalidSignature):
        return False
    # Comments, spaces and capitals would be read the same.
    return signature["public_key"] == public_key_line(key) and signature["value"] == value.hex()


def public_key_line(key: Ed25519PublicKey) -> str:
    """Write a public key in one line, as ssh-keygen does, without a comment."""
    from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat

    return key.public_bytes(Encoding.OpenSSH, PublicFormat.OpenSSH).decode()


def fingerprint(line: str) -> str:
    """Name a public key as ``ssh-keygen -l`` does; needs no package for signatures."""
    words = line.split()
    try:
        blob = base64.b64decode(words[1], validate=True)
    except (IndexError, ValueError, binascii.Error):
        return "that cannot be read"
    return "SHA256:" + base64.b64encode(hashlib.sha256(blob).digest()).decode().rstrip("=")
