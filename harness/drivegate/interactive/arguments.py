"""What the functions take from Python, where no command line has looked at it: a sentence for what makes no sense."""

from __future__ import annotations

import tempfile
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager
from numbers import Integral, Real
from pathlib import Path

from drivegate_cases.documents.wording import short_line
from drivegate_models.errors import InputError


def named_text(value: object, what: str, advice: str) -> str:
    """Return a name or path as text; refuse other objects, of which Python has many more than a command line."""
    if not isinstance(value, str | Path):
        raise InputError(f"{what} is {_described(value)}, but must be {advice}")
    return str(value)


def candidate_text(value: object) -> str:
    return named_text(
        value,
        "the candidate",
        "a text that names one, such as 'controller.py:Controller' or 'candidate.toml'; it runs in a process of its "
        "own, so write a controller to a file first",
    )


def texts(value: object, what: str, advice: str) -> tuple[str, ...]:
    """Return several names; a single one may go without a list."""
    listed = (value,) if isinstance(value, str | Path) else value
    if not isinstance(listed, Iterable) or isinstance(listed, Mapping):
        raise InputError(f"{what} is {_described(value)}, but must be {advice}")
    return tuple(named_text(one, what, advice) for one in listed)


def settings_words(settings: object) -> list[str]:
    """Write settings of a drive as the command line has them."""
    if settings is None:
        return []
    if not isinstance(settings, Mapping):
        raise InputError(
            f"settings is {_described(settings)}, but must be a dictionary, such as {{'machine.resistance_ohm': 0.1}}"
        )
    return [f"{key}={value}" for key, value in settings.items()]


def one_of(value: object, what: str, known: Collection[str]) -> str | None:
    """Return a word, None for none; refuse one that is not known."""
    if value is None:
        return None
    if isinstance(value, str) and value in known:
        return value
    raise InputError(f"{what} is {_described(value)}, but must be one of {', '.join(known)}")


def whole_number(value: object, what: str, least: int) -> int | None:
    """Return a whole number, None for none; refuse another one, or what is below the least one."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, Integral) or int(value) < least:
        raise InputError(f"{what} is {_described(value)}, but must be a whole number of {least} or more")
    return int(value)


def seconds(value: object, what: str) -> float | None:
    """Return a time, None for none; refuse what is no time to wait."""
    if value is None:
        return None
    if isinstance(value, bool) or not isinstance(value, Real) or not float(value) > 0.0:
        raise InputError(f"{what} is {_described(value)}, but must be a number of seconds above 0")
    return float(value)


def optional_path(value: str | Path | None, what: str) -> Path | None:
    return None if value is None else Path(named_text(value, what, "the path of a file or folder"))


@contextmanager
def report_folder(output: str | Path | None) -> Iterator[Path]:
    """Return the folder of a report, which is deleted at the end unless it was named."""
    if output is not None:
        yield Path(named_text(output, "output", "the path of a folder"))
        return
    with tempfile.TemporaryDirectory(prefix="drivegate-") as scratch:
        yield Path(scratch) / "report"


def _described(value: object) -> str:
    """Write a number or a short text, and the type of everything else."""
    if isinstance(value, str):
        return f"'{short_line(value)}'"
    if isinstance(value, Real) or value is None:
        return str(value)
    return f"an object of the type {type(value).__name__}"
