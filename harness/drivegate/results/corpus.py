"""The corpus: a folder of counterexamples whose scenarios every check runs again."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.results.counterexample import Counterexample


def read_corpus(folder: Path) -> tuple[Counterexample, ...]:
    """Read every counterexample of a folder."""
    from drivegate.results.counterexample import read_counterexample

    try:
        if not folder.is_dir():
            problem = "is no folder" if folder.exists() else "does not exist"
            raise InputError(f"--corpus {shown_path(folder)} {problem}; name a folder of counterexamples")
        files = sorted(path for path in folder.iterdir() if path.name.endswith(".json"))
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(
            f"--corpus {shown_path(folder)} cannot be read: {one_line(reason)}; name a readable folder"
        ) from error
    return tuple(read_counterexample(file) for file in files)
