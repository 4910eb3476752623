"""The sanitizers that can look into a candidate, and what they report."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Final, NamedTuple

from drivegate.candidates.fault import bounded_line, short_lines
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
# At the end of a report, whose beginning is lost where a trace is very long.
_SUMMARY: Final = re.compile(
    r"^SUMMARY: AddressSanitizer: (?P<what>\S+) (?P<file>/[^:\n]*):(?P<line>\d+)", re.MULTILINE
)
# A panic of Rust, as versions before 1.73 print it too.
_PANIC: Final = re.compile(
    r"^thread '[^'\n]*'(?: \(\d+\))? panicked at (?:'(?P<old>.*)', )?(?P<file>[^:\n]+):(?P<line>\d+):\d+:?$"
    r"(?:\n(?P<what>.*))?",
    re.MULTILINE,
)
# Rust shortens what is below the folder in which the process runs.
_PANIC_FRAME: Final = re.compile(r"^\s+at (?P<file>\.?/[^:\n]*):(?P<line>\d+)", re.MULTILINE)
# Where in memory differs from run to run.
_WHERE: Final = re.compile(r" on (?:unknown )?address 0x[0-9a-f]+.*$")


def read_report(output: str, folder: Path, sources: Sequence[Path]) -> Report | None:
    """Read the first report in what a process printed; None where there is none.

    `folder`, `sources`: the candidate's; the place is the innermost one in its sources.
    """
    output = short_lines(output)
    panic = _PANIC.search(output)
    if panic is not None:
        frames = _frames(_PANIC_FRAME, output[panic.end() :], sources)
        is_own = (folder / panic["file"]).resolve() in sources
        place = _place(*((panic["file"], panic["line"]) if is_own or not frames else frames[0]), folder)
        return Report(place, bounded_line(f"{place}: {panic['old'] or panic['what'] or 'panic'}"))
    undefined, address = _UNDEFINED.search(output), _ADDRESS.search(output)
    if undefined is not None and (address is None or undefined.start() < address.start()):
        place = _place(undefined["file"], undefined["line"], folder)
        return Report(place, bounded_line(f"{place}: {undefined['what']}"))
    if address is None:
        summary = _SUMMARY.search(output)
        if summary is None:
            return None
        place = _place(summary["file"], summary["line"], folder)
        return Report(place, bounded_line(f"{place}: {summary['what']}"))
    rest = output[address.end() :]
    frames = _frames(_FRAME, rest, sources)
    place = _place(*frames[0], folder) if frames else "no line is known"
    access = _ACCESS.search(rest)
    what = _WHERE.sub("", address["what"]) + (f", {access['what']}" if access else "")
    return Report(place, bounded_line(f"{place}: {what}"))


def _frames(pattern: re.Pattern[str], output: str, sources: Sequence[Path]) -> list[tuple[str, str]]:
    """List files and lines in a trace, the innermost first; those in a candidate's sources alone where it has any."""
    frames = [(_whole(found["file"], sources), found["line"]) for found in pattern.finditer(output)]
    return [frame for frame in frames if Path(frame[0]).resolve() in sources] or frames


def _whole(file: str, sources: Sequence[Path]) -> str:
    """Return the source that a shortened path ends the path of; any other path as it is."""
    parts = Path(file).parts
    if Path(file).is_absolute():
        return file
    return next((str(source) for source in sources if source.parts[-len(parts) :] == parts), file)


def _place(file: str, line: str, folder: Path) -> str:
    path = Path(file)
    return f"{path.relative_to(folder) if path.is_relative_to(folder) else path}, line {line}"
