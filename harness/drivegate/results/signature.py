"""A signature over the content hash of a result: who vouches for it, and whether it still says the same."""

from __future__ import annotations

import base64
import binascii
import hashlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NoReturn

from drivegate.results.result import content_hash
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey, Ed25519PublicKey

_LARGEST_KEY_BYTES: Final = 64 * 1024
_MAKE: Final = "make one with openssl genpkey -algorithm ed25519 -out key.pem"
_PUBLISH: Final = "it is the .pub file of ssh-keygen, or what openssl pkey -in key.pem -pubout writes"


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
    """Return True if a signature is that of the key beside it, over a content hash, character by character."""
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


def require_cryptography() -> None:
    """Refuse what needs signatures where the package for them is missing."""
    try:
        import cryptography.hazmat.primitives.asymmetric.ed25519  # noqa: F401
    except ImportError as error:
        raise InputError("signatures need the package cryptography; pip install cryptography") from error


def read_private_key(path: Path) -> Ed25519PrivateKey:
    """Read the ed25519 key to sign with, as openssl (PKCS #8) or ssh-keygen writes it, without a passphrase."""
    require_cryptography()
    from cryptography.hazmat.primitives import serialization
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

    data, where = _bytes_of(path), shown_path(path)
    if _is_public(data):
        raise InputError(f"{where} holds a public key, but a result is signed with the private one")

    def load() -> object:
        if b"BEGIN OPENSSH PRIVATE KEY" in data:
            return serialization.load_ssh_private_key(data, password=None)
        return serialization.load_pem_private_key(data, password=None)

    key = _loaded(load, where, f"an ed25519 private key; {_MAKE}")
    if not isinstance(key, Ed25519PrivateKey):
        _refuse_kind(key, where, _MAKE)
    return key


def read_public_key(path: Path) -> Ed25519PublicKey:
    """Read the ed25519 key that a result must be signed by: a PEM file, or the line that ssh-keygen writes."""
    require_cryptography()
    from cryptography.hazmat.primitives import serialization
    from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PublicKey

    data, where = _bytes_of(path), shown_path(path)
    if b"PRIVATE KEY" in data:
        raise InputError(
            f"{where} holds a private key, but a result is verified with the public one; {_PUBLISH}"
        )

    def load() -> object:
        if b"-----BEGIN" in data:
            return serialization.load_pem_public_key(data)
        return serialization.load_ssh_public_key(data.strip())

    key = _loaded(load, where, f"an ed25519 public key; {_PUBLISH}")
    if not isinstance(key, Ed25519PublicKey):
        _refuse_kind(key, where, _PUBLISH)
    return key


def _bytes_of(path: Path) -> bytes:
    where = shown_path(path)
    try:
        with path.open("rb") as stream:
            data = stream.read(_LARGEST_KEY_BYTES + 1)
    except FileNotFoundError as error:
        raise InputError(f"{where} does not exist; name the file of a key") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{where} cannot be read: {one_line(reason)}; name the file of a key") from error
    if len(data) > _LARGEST_KEY_BYTES:
        raise InputError(f"{where} is larger than {_LARGEST_KEY_BYTES // 1024} KB, so it is no key")
    return data


def _is_public(data: bytes) -> bool:
    return b"PUBLIC KEY" in data or data.lstrip().startswith((b"ssh-", b"ecdsa-"))


def _loaded(load: Callable[[], object], where: str, required: str) -> Any:
    from cryptography.exceptions import UnsupportedAlgorithm

    try:
        return load()
    except TypeError as error:
        raise InputError(
            f"{where} is locked with a passphrase, which drivegate does not ask for; "
            "unlock a copy with openssl pkey, or with ssh-keygen -p"
        ) from error
    except (ValueError, UnsupportedAlgorithm) as error:
        raise InputError(f"{where} does not hold {required}") from error


def _refuse_kind(key: object, where: str, remedy: str) -> NoReturn:
    kind = type(key).__name__.removesuffix("PrivateKey").removesuffix("PublicKey").lstrip("_")
    raise InputError(f"{where} holds a key of kind {kind}, but must hold one of kind Ed25519; {remedy}")
