"""What of an answer or a file of drivegate two lists compare, and what of it has to vary."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path
from typing import Any, Final

# Left out without the wording.
_CHANGING: Final = frozenset({"provenance", "timing", "signature", "traceback", "output", "report", "folder"})
# With the wording, their keys are compared and their values are not: machine, times, a random key. So are those of the
# provenance of a result, which names drivegate; that of a drive has the sources of its values.
_KEYS_ALONE: Final = frozenset({"timing", "signature"})
_NUMBERS: Final = frozenset({".json", ".csv", ".parquet"})
_SHOWN: Final = _NUMBERS | {
    *(".html", ".xml", ".md", ".txt", ".svg", ".toml", ".yml"),
    *(".py", ".c", ".h", ".rs", ".ld"),
}
_BUILT: Final = frozenset({"target", "__pycache__"})
# A hash of sources, a commit, a SHA-256.
_HEXADECIMAL: Final = r"(?<![\w.])(?=[0-9]*[a-f])[0-9a-f]{16}(?:[0-9a-f]{24}|[0-9a-f]{48})?(?!\w)"
_VARYING: Final = tuple(
    (re.compile(pattern), shown)
    for pattern, shown in (
        (_HEXADECIMAL, "{hash}"),
        (r"\d{4}-\d\d-\d\d[T ]\d\d:\d\d(:\d\d)?(\.\d+)?( ?UTC|Z|[+-]\d\d:\d\d)?", "{time}"),
        (r"\b20\d\d-\d\d-\d\d\b", "{day}"),
        (r'(<testcase [^>]*|<testsuite [^>]*)\btime="[\d.]+"', r'\1time="{seconds}"'),
        (r'(<th scope="row">seconds</th><td><code>)[\d.]+', r"\1{seconds}"),
        (r"SHA256:[\w+/]{43}", "SHA256:{key}"),
        (r"[\d.]+ [nµm]?s a step( \([^)]*\))?(, [\d.e-]+ %)?", "{time of a step}"),
        (r"\b\d+(\.\d+)? (s|min|h), report", "{duration}, report"),
        (r"[\d.e+]+ points a second", "{rate} points a second"),
        (r"\b(process|pid)([ =:]+)\d+", r"\1\2{process}"),
        (r'File "[^"]*", line \d+', "File {line}"),
    )
)

# What pages, tables and a summary have of measured times: of a check, and of steps in a comparison.
_TIMED: Final = re.compile(
    r'<tr id="check-TIM-1">(?s:.*?)</tr>|<th scope="row">TIM-1</th>(?s:.*?)</tr>|\| TIM-1 \|.*'
    r"|<th [^>]*>time of a step(?s:.*?)</table>|(?<=,)step_us,(?s:.*)"
)
_MEASURED: Final = re.compile(r"(?<![\w.])([+-]?\d+\.\d+|[+-]\d+)")


@dataclass(frozen=True)
class Places:
    """Folders whose names vary, by what is shown for them; the innermost first."""

    names: tuple[tuple[str, str], ...]

    @classmethod
    def of(cls, scratch: Path, *code: Path) -> Places:
        """Name a scratch folder, the folders of code, and the environment."""
        named = [
            (scratch, "{scratch}"),
            *((folder, "{code}") for folder in code),
            (Path(sys.prefix), "{python}"),
        ]
        return cls(tuple((str(folder), shown) for folder, shown in named))


def normal(text: str, places: Places) -> str:
    """Replace what differs between two runs of the same code."""
    for folder, shown in places.names:
        text = text.replace(folder, shown)
    for pattern, shown in _VARYING:
        text = pattern.sub(shown, text)
    return _without_times(text)


def _without_times(text: str) -> str:
    return _TIMED.sub(lambda found: _MEASURED.sub("{number}", found[0]), text)


def stripped(value: Any, places: Places | None, key: str = "") -> Any:
    """Return a document without what may differ between two codes of the same behaviour.

    Without places these are provenance, times, hashes of sources, the order of keys, and any text with a space.
    """
    if isinstance(value, dict):
        if places is not None:
            return {
                name: _keys_alone(part) if _varies(name, part) else stripped(part, places, f"{key} {name}")
                for name, part in value.items()
            }
        kept = {
            name: stripped(part, None, name)
            for name, part in value.items()
            if name not in _CHANGING and (name != "hash" or key == "drive")
        }
        return dict(sorted(kept.items()))
    if isinstance(value, list):
        return [stripped(part, places, key) for part in value]
    if not isinstance(value, str) or key.endswith("drive hash"):
        return value
    if places is not None:
        return normal(value, places)
    return "" if " " in value or "/" in value else value


def _varies(name: str, part: Any) -> bool:
    return name in _KEYS_ALONE or (name == "provenance" and "drivegate" in (part or ()))


def _keys_alone(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _keys_alone(part) for name, part in value.items()}
    return [_keys_alone(part) for part in value] if isinstance(value, list) else None


def answered(text: str, places: Places | None) -> Any:
    """Return what is compared of a command's output: a JSON document, or its lines of text."""
    try:
        return stripped(json.loads(text), places)
    except ValueError:
        return f"no JSON document: {text[:200]!r}" if places is None else normal(text, places).splitlines()


def as_text(shown: Any) -> str:
    """Write what is compared as text, in which a changed value is one line."""
    return json.dumps(shown, indent=1, ensure_ascii=False, default=str)


def files_in(folder: Path, given: frozenset[str], *, wording: bool) -> Iterator[Path]:
    """List the files that a command wrote below a folder, without those that it was given."""
    for path in sorted(folder.rglob("*")):
        within = path.relative_to(folder)
        hidden = any(part in _BUILT or part.startswith(".drivegate") for part in within.parts)
        compared = path.suffix in (_SHOWN if wording else _NUMBERS)
        if path.is_file() and compared and not hidden and str(within) not in given:
            yield path


def parts_of(path: Path, places: Places | None) -> dict[str, str]:
    """Return what is compared of a file: by its name alone, and of a page also its words and its figures."""
    if path.suffix == ".parquet":
        return {"": _columns(path)}
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".json":
        return {"": as_text(answered(text, places))}
    if places is None:
        return {"": _without_times(text)}
    text = normal(text, places)
    if path.suffix != ".html":
        return {"": text}
    figures = "\n".join(re.findall(r"<svg.*?</svg>", text, re.DOTALL))
    return {"": text, " words": words_of(text), " figures": figures}


def _columns(path: Path) -> str:
    from pyarrow.parquet import read_table

    table = read_table(path)
    shown = {
        name: [str(table.schema.field(name).type), *table[name].to_pylist()] for name in table.column_names
    }
    return as_text(shown)


def words_of(page: str) -> str:
    """Return the text of a page outside of its figures, a line for each piece of it."""
    reader = _Words()
    reader.feed(page)
    return "\n".join(reader.lines)


class _Words(HTMLParser):
    """Collects the text of a page that is not in a figure, a script or a style."""

    def __init__(self) -> None:
        super().__init__()
        self.lines: list[str] = []
        self._outside = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self._outside += tag in ("svg", "script", "style")
        self.lines += [text for name, text in attrs if name in ("title", "aria-label", "alt") and text]

    def handle_endtag(self, tag: str) -> None:
        self._outside -= tag in ("svg", "script", "style")

    def handle_data(self, data: str) -> None:
        if not self._outside and data.strip():
            self.lines.append(" ".join(data.split()))
