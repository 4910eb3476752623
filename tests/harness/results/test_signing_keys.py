"""Keys: both forms that people make them in, and one sentence for whatever else lies in a file."""

from __future__ import annotations

import sys
from base64 import b64decode, b64encode
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from cryptography.hazmat.primitives.asymmetric import ec, rsa
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.hazmat.primitives.serialization import (
    BestAvailableEncryption,
    Encoding,
    NoEncryption,
    PrivateFormat,
    PublicFormat,
)

from drivegate.results.signature import public_key_line, read_private_key, read_public_key
from drivegate_models.errors import InputError

Written = Callable[[bytes], Path]
KEY = Ed25519PrivateKey.from_private_bytes(bytes(range(32)))
PRIVATE_FORMATS = {"openssl": PrivateFormat.PKCS8, "ssh-keygen": PrivateFormat.OpenSSH}
PUBLIC_FORMATS = {
    "openssl": (Encoding.PEM, PublicFormat.SubjectPublicKeyInfo),
    "ssh-keygen": (Encoding.OpenSSH, PublicFormat.OpenSSH),
}


@pytest.fixture
def written(tmp_path: Path) -> Written:
    def write(data: bytes) -> Path:
        path = tmp_path / "key"
        path.write_bytes(data)
        return path

    return write


def private(key: Any, form: PrivateFormat) -> bytes:
    return key.private_bytes(Encoding.PEM, form, NoEncryption())


def locked_by_openssl() -> bytes:
    return KEY.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, BestAvailableEncryption(b"secret"))


def locked_by_ssh_keygen() -> bytes:
    """Lay out a locked key by hand: to lock one takes a package that nothing else needs."""

    def text(content: bytes) -> bytes:
        return len(content).to_bytes(4, "big") + content

    rounds = text(bytes(16)) + (16).to_bytes(4, "big")
    public = b64decode(public_key_line(KEY.public_key()).split()[1])
    head = b"openssh-key-v1\0" + text(b"aes256-ctr") + text(b"bcrypt") + text(rounds) + (1).to_bytes(4, "big")
    body = b64encode(head + text(public) + text(bytes(144)))
    return b"\n".join(
        [b"-----BEGIN OPENSSH PRIVATE KEY-----", body, b"-----END OPENSSH PRIVATE KEY-----", b""]
    )


@pytest.mark.parametrize("form", PRIVATE_FORMATS)
def test_a_private_key_is_read(form: str, written: Written) -> None:
    key = read_private_key(written(private(KEY, PRIVATE_FORMATS[form])))
    assert key.private_bytes_raw() == KEY.private_bytes_raw()


@pytest.mark.parametrize("form", PUBLIC_FORMATS)
@pytest.mark.parametrize("end", [b"", b"\n"])
def test_a_public_key_is_read(form: str, end: bytes, written: Written) -> None:
    data = KEY.public_key().public_bytes(*PUBLIC_FORMATS[form])
    assert public_key_line(read_public_key(written(data + end))) == public_key_line(KEY.public_key())


def test_the_comment_that_ssh_keygen_adds_is_passed_over(written: Written) -> None:
    line = public_key_line(KEY.public_key())
    assert public_key_line(read_public_key(written(f"{line} me@here\n".encode()))) == line


@pytest.mark.parametrize("locked", [locked_by_openssl, locked_by_ssh_keygen])
def test_a_locked_key_is_refused(locked: Callable[[], bytes], written: Written) -> None:
    with pytest.raises(InputError, match="locked with a passphrase"):
        read_private_key(written(locked()))


@pytest.mark.parametrize("form", PRIVATE_FORMATS)
@pytest.mark.parametrize("kind", ["RSA", "EC"])
def test_a_key_of_another_kind_is_named(form: str, kind: str, written: Written) -> None:
    key = rsa.generate_private_key(65537, 2048) if kind == "RSA" else ec.generate_private_key(ec.SECP256R1())
    with pytest.raises(InputError, match=f"of kind {kind}, but must hold one of kind Ed25519"):
        read_private_key(written(private(key, PRIVATE_FORMATS[form])))
    with pytest.raises(InputError, match=f"of kind {kind}, but must hold one of kind Ed25519"):
        read_public_key(written(key.public_key().public_bytes(*PUBLIC_FORMATS[form])))


@pytest.mark.parametrize("form", PRIVATE_FORMATS)
def test_the_two_halves_are_not_mixed_up(form: str, written: Written) -> None:
    with pytest.raises(InputError, match="holds a private key, but a result is verified with the public one"):
        read_public_key(written(private(KEY, PRIVATE_FORMATS[form])))
    with pytest.raises(InputError, match="holds a public key, but a result is signed with the private one"):
        read_private_key(written(KEY.public_key().public_bytes(*PUBLIC_FORMATS[form])))


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\0" * 100,
        b"{}",
        b"\xff\xfe",
        b"-----BEGIN",
        b"-----BEGIN SOMETHING-----\nAAAA\n-----END SOMETHING-----\n",
        b"ssh-ed25519 AAAA",
        b"-----BEGIN OPENSSH",
    ],
)
@pytest.mark.parametrize("read", [read_private_key, read_public_key])
def test_what_is_no_key_is_refused(data: bytes, read: Callable[[Path], object], written: Written) -> None:
    with pytest.raises(InputError, match=r"does not hold an ed25519|holds a public key"):
        read(written(data))


def test_a_cut_key_is_refused(written: Written) -> None:
    for form in PRIVATE_FORMATS.values():
        whole = private(KEY, form)
        for length in range(0, len(whole) - 2, 7):
            with pytest.raises(InputError, match="does not hold"):
                read_private_key(written(whole[:length]))


@pytest.mark.parametrize("read", [read_private_key, read_public_key])
def test_a_file_that_cannot_be_one(read: Callable[[Path], object], written: Written, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="does not exist; name the file of a key"):
        read(tmp_path / "missing")
    with pytest.raises(InputError, match="cannot be read: Is a directory"):
        read(tmp_path)
    with pytest.raises(InputError, match="larger than 64 KB"):
        read(written(b"-" * 10_000_000))


@pytest.mark.parametrize("read", [read_private_key, read_public_key])
def test_the_missing_package_is_named(
    read: Callable[[Path], object], written: Written, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "cryptography.hazmat.primitives.asymmetric.ed25519", None)
    with pytest.raises(InputError, match="pip install cryptography"):
        read(written(b"a key"))
