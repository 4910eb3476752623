"""From the bytes of a TOML or JSON file to plain data, with one sentence for each way to fail."""

import json
import re
import tomllib
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final, NoReturn

from drivegate_cases.documents.extent import DEEPEST, TOO_DEEP, excess_of
from drivegate_cases.documents.file_bytes import file_bytes
from drivegate_cases.documents.wording import one_line, shown, shown_path, with_point
from drivegate_models.errors import InputError

LARGEST_FILE_BYTES: Final = 16 * 1024 * 1024
LARGEST_TOML_BYTES: Final = 4 * 1024 * 1024
"""Less than of JSON, which programs write: TOML is written by people, and slow to read."""
SUFFIXES: Final = (".toml", ".json")

_PART: Final = r"(?:(?<![\w-])[\w-]++|\"[^\"\n]*+\"|'[^'\n]*+')[ \t]*+"
_LONG_KEY: Final = re.compile(rf"(?:{_PART}\.[ \t]*+){{{DEEPEST}}}")
_VALUE: Final = re.compile(r"[=:]\s*([+-]?\d[\d.,eE+-]{0,40})\s*(?:[#}]|$)")


def read_mapping(path: str | Path) -> dict[str, Any]:
    """Read a TOML or JSON file; the suffix of its name says which."""
    where = shown_path(path)
    text = _decoded(_bytes_of(path, where), where)
    language, parse = ("JSON", _json_value) if _is_json(path) else ("TOML", _toml_value)
    value = _parsed(text, where, language, parse)
    excess = excess_of(value)
    if excess:
        raise InputError(f"{where} {excess}")
    return _table_at_top(value, where)


def _is_json(path: str | Path) -> bool:
    return Path(path).suffix.lower() == ".json"


def _bytes_of(path: str | Path, where: str) -> bytes:
    if Path(path).suffix.lower() not in SUFFIXES:
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
        raise ValueError(comma or _about_strings(str(error))) from error


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


def _table_at_top(value: Any, where: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError(f"{where} holds {shown(value)} at its top, but must hold a table of keys and values")
    return value
