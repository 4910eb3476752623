"""The files of compiled kernels: read without waiting, and trusted only as they were before strangers' code ran."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Final

PATTERN: Final = "*.nb[ic]"
"""Names of the files: an index of each function, and the code of each signature."""
LISTED: Final = "digests.json"
"""File of a wheel's folder of compiled kernels with the digest of each of its files, in hexadecimal."""

_trusted: list[dict[str, bytes]] = []
# The digests of the files that this process trusts, as the one element; without it, all are trusted.
_saved: dict[str, bytes] = {}
# The digests of the files that this process, or the one that it is a copy of, has saved.


def content_of(path: str | Path) -> bytes:
    """Read a file, without waiting for a process that has a lease on it.

    Raises FileNotFoundError where there is none, or it is leased: then it is as if it were not there.
    """
    descriptor = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    with os.fdopen(descriptor, "rb") as stream:
        return stream.read()


def _name_in(folder: Path, path: str | Path) -> str:
    """Name a file by its path in the folder; code that is not drivegate's own lies elsewhere."""
    return str(path).removeprefix(f"{folder}{os.sep}")


def digest_of(content: bytes) -> bytes:
    return hashlib.sha256(content).digest()


def digests_in(folder: Path) -> dict[str, bytes]:
    """Return a digest of each file of compiled kernels, by its path in their folder."""
    found = {}
    for path in sorted(folder.rglob(PATTERN)):
        with contextlib.suppress(OSError):
            found[_name_in(folder, path)] = digest_of(content_of(path))
    return found


def trust_only(digests: Mapping[str, bytes]) -> None:
    """Load in this process only those compiled kernels that have these digests, or that it compiles itself.

    `digests`: digest of each file by its path in the folder, as `digests_in` returned them before code of strangers
    ran.
    """
    _trusted[:] = [dict(digests)]


def trusts_all() -> bool:
    """Return True if this process loads compiled kernels whatever their digests are."""
    return not _trusted


def trusted_content(folder: Path, path: str) -> bytes | None:
    """Read a file of compiled code; None if it is not there, is leased, or is not as it is listed."""
    try:
        content = content_of(path)
    except (FileNotFoundError, BlockingIOError):
        return None
    name = _name_in(folder, path)
    is_trusted = all(listed.get(name) == digest_of(content) for listed in _trusted)
    return content if is_trusted else None


def enter_saved(folder: Path, paths: Iterable[str]) -> None:
    """Trust files that this process has just saved."""
    for path in paths:
        name, digest = _name_in(folder, path), digest_of(content_of(path))
        for listed in (*_trusted, _saved):
            listed[name] = digest


def saved_digests() -> dict[str, bytes]:
    """Return the digests of the files that this process has saved."""
    return dict(_saved)


def remove_changed(folder: Path, known: Iterable[Mapping[str, bytes]]) -> int:
    """Remove the files that are not as they are known, such as after code of strangers ran that nothing isolated.

    `known`: digests by path; a file may have those of any of them. Result: number of the files that were removed.
    """
    accepted: dict[str, set[bytes]] = {}
    for digests in known:
        for name, digest in digests.items():
            accepted.setdefault(name, set()).add(digest)
    changed = 0
    for path in sorted(folder.rglob(PATTERN)):
        try:
            is_known = digest_of(content_of(path)) in accepted.get(_name_in(folder, path), ())
        except OSError:
            is_known = False
        if not is_known:
            with contextlib.suppress(OSError):
                path.unlink()
                changed += 1
    return changed


def list_digests(folder: Path) -> None:
    """Write the digests of the compiled kernels in a folder next to them, for a wheel that carries them."""
    written = {name: digest.hex() for name, digest in digests_in(folder).items()}
    (folder / LISTED).write_text(json.dumps(written, indent=1, sort_keys=True), encoding="utf-8")


def remove_unlisted(folder: Path) -> None:
    """Remove the files that are not as a wheel lists them; without a list, as of an older wheel, all of them."""
    try:
        listed = json.loads((folder / LISTED).read_text(encoding="utf-8"))
        known = {str(name): bytes.fromhex(digest) for name, digest in listed.items()}
    except (OSError, ValueError, AttributeError, TypeError):
        known = {}
    remove_changed(folder, [known])
