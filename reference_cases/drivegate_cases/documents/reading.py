"""From a TOML or JSON file, or from KEY=VALUE pairs, to plain data, with one sentence for each way to fail."""

import errno
import json
import re
import tomllib
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Any, Final, NoReturn

from drivegate_cases.documents.regular_file import regular_content
from drivegate_cases.documents.wording import nearest_key, one_line, short_line, shown, shown_path, with_point
from drivegate_models.errors import InputError

DEEPEST: Final = 32
"""Most levels of tables and lists, several times what any document has."""
MOST_KEYS: Final = 200_000
"""Most keys in all tables of a document."""
MOST_ENTRIES: Final = 1_000_000
"""Most entries in all lists of a document."""
TOO_DEEP: Final = f"is nested too deeply; a document has at most {DEEPEST} levels of tables and lists"
LARGEST_FILE_BYTES: Final = 16 * 1024 * 1024
LARGEST_TOML_BYTES: Final = 4 * 1024 * 1024
"""Less than of JSON, which programs write: TOML is written by people, and slow to read."""
SUFFIXES: Final = (".toml", ".json")

_PART: Final = r"(?:(?<![\w-])[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')[ \t]*+"
_LONG_KEY: Final = re.compile(rf"(?:{_PART}\.[ \t]*+){{{DEEPEST}}}")
_WORD: Final = re.compile(r"\s*([\w.-]{1,80})\s*=\s*([A-Za-z][\w./-]{0,80})\s*(?:#.*)?$")
_VALUE: Final = re.compile(r"[=:]\s*([+-]?\d[\d.,eE+-]{0,40})\s*(?:[#}]|$)")


def excess_of(value: object) -> str | None:
    """Return what is too much in a document, in words that follow its name; None for one of a usual extent."""
    level: list[dict[object, object] | list[object]] = [value] if isinstance(value, (dict, list)) else []
    keys = entries = 0
    for _ in range(DEEPEST):
        keys += sum(len(table) for table in level if isinstance(table, dict))
        entries += sum(len(listed) for listed in level if isinstance(listed, list))
        if keys > MOST_KEYS:
            return f"has more than {MOST_KEYS} keys, the most that a document may have"
        if entries > MOST_ENTRIES:
            return f"has more than {MOST_ENTRIES} entries in its lists, the most that a document may have"
        level = [
            item
            for outer in level
            for item in (outer.values() if isinstance(outer, dict) else outer)
            if isinstance(item, (dict, list))
        ]
        if not level:
            return None
    return TOO_DEEP


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
        return regular_content(place, most)
    except FileNotFoundError as error:
        raise InputError(f"{where} does not exist; name an existing {kind}") from error
    except (OSError, ValueError) as error:
        if getattr(error, "errno", None) == errno.EFBIG:
            raise InputError(f"{where} is larger than {most // 1024**2} MB, {limit}") from error
        reason = getattr(error, "strerror", None) or str(error)
        raise InputError(f"{where} cannot be read: {one_line(reason)}; name a readable {kind}") from error


def read_mapping(path: str | Path) -> dict[str, Any]:
    """Read a TOML or JSON file; the suffix of its name says which."""
    where = shown_path(path)
    text = _decoded(_bytes_of(path, where), where)
    language, parse = ("JSON", _json_value) if _is_json(path) else ("TOML", _toml_value)
    value = _parsed(text, where, language, parse)
    excess = excess_of(value)
    if excess:
        raise InputError(f"{where} {excess}")
    if not isinstance(value, dict):
        raise InputError(f"{where} holds {shown(value)} at its top, but must hold a table of keys and values")
    return value


def _is_json(path: str | Path) -> bool:
    return Path(path).suffix.lower() == ".json"


def _bytes_of(path: str | Path, where: str) -> bytes:
    if Path(path).suffix.lower() not in SUFFIXES:
        if Path(path).is_dir():
            raise InputError(f"{where} is a folder; name a TOML or JSON file in it")
        raise InputError(
            f"{where} is neither a TOML nor a JSON file by its name, which must end in .toml or .json"
        )
    most, language = (LARGEST_FILE_BYTES, "JSON") if _is_json(path) else (LARGEST_TOML_BYTES, "TOML")
    limit = f"the most that a document in {language} may have"
    return file_bytes(path, "TOML or JSON file", most=most, limit=limit)


def _decoded(data: bytes, where: str) -> str:
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise InputError(
            f"{where} is not text in UTF-8 (byte {error.start}, line {line}), but must be TOML or JSON"
        ) from error


def _parsed(text: str, where: str, language: str, parse: Callable[[str], Any]) -> Any:
    try:
        return parse(text)
    except json.JSONDecodeError as error:
        reason = _decimal_comma(text, error.lineno) or one_line(error.msg)
        raise InputError(
            f"{where} is not well-formed JSON at line {error.lineno}, column {error.colno}: {reason}"
        ) from error
    except RecursionError as error:
        raise InputError(f"{where} {TOO_DEEP}") from error
    except ValueError as error:
        raise InputError(f"{where} is not well-formed {language}: {one_line(str(error))}") from error


def _toml_value(text: str) -> Any:
    if _LONG_KEY.search(text):
        # The parser's time grows with the square of a key's parts.
        raise RecursionError
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"\(at line (\d+), column", str(error))
        comma = _decimal_comma(text, int(place[1])) if place else None
        word = _word_without_quotes(text, int(place[1])) if place else None
        raise ValueError(comma or word or _about_strings(str(error))) from error


def _word_without_quotes(text: str, line: int) -> str | None:
    """Name a text without quotes in the line at which a parser stopped; None where there is none."""
    found = _WORD.match(text.split("\n")[line - 1])
    return found and f'in line {line} a text has no quotes; write {found[1]} = "{found[2]}"'


def _decimal_comma(text: str, line: int) -> str | None:
    """Name a decimal comma in the line at which a parser stopped; None where there is none."""
    value = _VALUE.search(text.split("\n")[line - 1])
    number = value[1].rstrip(",") if value else ""
    right = with_point(number)
    return right and f"in line {line} the number {number} has a decimal comma; write it with a point, {right}"


def _about_strings(sentence: str) -> str:
    """Name a string that is not closed, which the parser reports where it expects the quotation mark."""
    line = re.search(r"Illegal character '\\n' \(at line (\d+),", sentence)
    if line is not None:
        return f"in line {line[1]} a string is not closed; end it with the quotation mark that it begins with"
    if sentence.startswith(("Unterminated string", "Expected \"'")):
        return "a string is not closed up to the end of the file; end it with the quotation marks that it begins with"
    return sentence


def _json_value(text: str) -> Any:
    return json.loads(text, object_pairs_hook=_without_repeats, parse_constant=_refuse_constant)


def _without_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    table = dict(pairs)
    if len(table) < len(pairs):
        counts = Counter(key for key, _ in pairs)
        repeated = next(key for key in table if counts[key] > 1)
        raise ValueError(f"the key {shown(repeated)} appears more than once in one object")
    return table


def _refuse_constant(constant: str) -> NoReturn:
    raise ValueError(f"{constant} is no JSON number, and every number must be finite")


def parse_overrides(pairs: Sequence[str], known: Collection[str]) -> dict[str, Any]:
    values: dict[str, Any] = {}
    for pair in pairs:
        key, equals, text = (part.strip() for part in pair.partition("="))
        if not equals or not key or not text:
            raise InputError(f"--set {shown(pair)} is not a setting, which is written KEY=VALUE")
        if key not in known:
            raise InputError(
                f"--set {short_line(pair)}: the key '{short_line(key)}' is unknown, {nearest_key(key, known)}"
            )
        values[key] = _override_value(text)
        excess = excess_of(values[key])
        if excess:
            raise InputError(f"--set {key}: the value {excess}")
    return values


def _override_value(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        pass
    try:
        return float(text)
    except ValueError:
        return text
