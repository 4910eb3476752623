"""Refusing the name of a file of a user's that is to be written."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

_SUFFIX: Final = ".toml"


def refuse_new_file(file: Path, whose: str) -> None:
    """Refuse a file that exists, or whose name is none of a TOML file."""
    if file.suffix != _SUFFIX:
        raise InputError(f"{shown_path(file)} is no name for {whose} file, which ends in {_SUFFIX}")
    if file.is_symlink() or file.exists():
        raise InputError(
            f"{shown_path(file)} exists already, and nothing is ever overwritten; name another file"
        )
