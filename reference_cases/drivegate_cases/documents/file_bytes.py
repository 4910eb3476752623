"""The bytes of a file that a user names, with one sentence for each way to fail."""

from pathlib import Path

from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError


def file_bytes(path: str | Path, kind: str, *, most: int, limit: str, having: str = "") -> bytes:
    """Read a whole file of at most `most` bytes.

    `kind`, `having` and `limit` are words for the `InputError` that anything else raises: what such a file is, what it
    has, and what the limit is.
    """
    where = shown_path(path)
    try:
        place = Path(path)
        if place.is_dir():
            raise InputError(f"{where} is a folder, but must be a {kind}{having}")
        if place.exists() and not place.is_file():
            raise InputError(f"{where} is not a regular file, but must be a {kind}{having}")
        with place.open("rb") as stream:
            data = stream.read(most + 1)
    except FileNotFoundError as error:
        raise InputError(f"{where} does not exist; name an existing {kind}") from error
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{where} cannot be read: {one_line(reason)}; name a readable {kind}") from error
    if len(data) > most:
        raise InputError(f"{where} is larger than {most // 1024**2} MB, {limit}")
    return data
