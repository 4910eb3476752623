"""The sanitizers that can look into a candidate, and what they report."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final, NamedTuple

from drivegate.candidates.fault import bounded_line
from drivegate_cases.documents.wording import nearest, one_line
from drivegate_models.errors import InputError

SANITIZERS: Final = ("address", "undefined", "float")
"""Memory; what the language leaves undefined, with conversions of floats that are out of range; floats divided by 0."""


def read_sanitizers(text: str) -> tuple[str, ...]:
    """Read names with commas between them."""
    names = tuple(dict.fromkeys(word.strip() for word in text.split(",")))
    unknown = [name for name in names if name not in SANITIZERS]
    if unknown:
        raise InputError(
            f"--sanitize names '{one_line(unknown[0])}', the nearest known one is "
            f"'{nearest(unknown[0], SANITIZERS)}'; known are {', '.join(SANITIZERS)}"
        )
    return names


class Report(NamedTuple):
    """What a sanitizer reports."""

    place: str
    """File and line."""
    message: str
    """The report in one line, the place first."""


_UNDEFINED: Final = re.compile(
    r"^(?P<file>[^\s:][^:\n]*):(?P<line>\d+):\d+: runtime error: (?P<what>.*)$", re.MULTILINE
)
_ADDRESS: Final = re.compile(r"^==\d+==ERROR: AddressSanitizer: (?P<what>[^\n]*)$", re.MULTILINE)
_ACCESS: Final = re.compile(r"^(?P<what>(?:READ|WRITE) of size \d+)", re.MULTILINE)
_FRAME: Final = re.compile(r"^\s+#\d+ 0x[0-9a-f]+ in .*? (?P<file>/[^:\n]*):(?P<line>\d+)", re.MULTILINE)
# Where in memory differs from run to run.
_WHERE: Final = re.compile(r" on (?:unknown )?address 0x[0-9a-f]+.*$")


def read_report(output: str, folder: Path, sources: Sequence[Path]) -> Report | None:
    """Read the first report in what a process printed; None where there is none.

    `folder`, `sources`: the candidate's; the place is the innermost one in its sources.
    """
    undefined, address = _UNDEFINED.search(output), _ADDRESS.search(output)
    if undefined is not None and (address is None or undefined.start() < address.start()):
        place = _place(undefined["file"], undefined["line"], folder)
        return Report(place, bounded_line(f"{place}: {undefined['what']}"))
    if address is None:
        return None
    rest = output[address.end() :]
    frames = [(found["file"], found["line"]) for found in _FRAME.finditer(rest)]
    own = [frame for frame in frames if Path(frame[0]).resolve() in sources]
    place = _place(*(own or frames)[0], folder) if frames else "no line is known"
    access = _ACCESS.search(rest)
    what = _WHERE.sub("", address["what"]) + (f", {access['what']}" if access else "")
    return Report(place, bounded_line(f"{place}: {what}"))


def _place(file: str, line: str, folder: Path) -> str:
    path = Path(file)
    return f"{path.relative_to(folder) if path.is_relative_to(folder) else path}, line {line}"
