"""What would reach a branch that no run took, as far as its condition shows it: a signal that is sensed."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from typing import Final, NamedTuple

# A field of a record, through a pointer, a reference or an object.
_FIELD: Final = re.compile(r"(?:->|\.)\s*([A-Za-z_]\w*)")
_ASSIGNED: Final = re.compile(
    r"(?P<name>(?:\w+(?:->|\.))*[A-Za-z_]\w*)\s*(?:\[[^\]]*\])?\s*[-+*/|&^]?=(?!=)(?=\s*(?P<value>[^;]+))"
)
_UNPACKED: Final = re.compile(r"^\s*(?:let\s*)?\(?(?P<names>[\w.\s]+(?:,[\w.\s]+)+)\)?\s*=(?!=)(?P<value>.+)")
_WORD: Final = re.compile(r"(?:\w+(?:->|\.))*[A-Za-z_]\w*")
_CALLED: Final = re.compile(r"\b(?P<function>[A-Za-z_]\w*)\s*\(")
_OUTPUT: Final = re.compile(r"^\s*&(?:mut\s+)?(?P<name>(?:\w+(?:->|\.))*[A-Za-z_]\w*)\s*$")
# A word in front of the name, its type or what begins a function; a call has none.
_DEFINED: Final = re.compile(
    r"^\s*(?!return\b|else\b|case\b)(?:[\w:<>]+[\s*&]+)+(?P<function>[A-Za-z_]\w*)\s*\("
)
_PARAMETER: Final = re.compile(r"([A-Za-z_]\w*)\s*(?::.*|=.*|\[.*)?$")
_LONGEST: Final = 1000
"""Characters of a line that are looked at; the patterns' time grows with the square."""
_ROUNDS: Final = 4
"""Number of variables in a row through which a signal is followed."""


class _Passed(NamedTuple):
    """A value that passes into a variable."""

    name: str
    value: str


class Conditions:
    """The signals that conditions depend on, followed through variables, calls and parameters of the same name.

    It reads text and no program, so it is a hint.
    """

    def __init__(self, text: Sequence[str], moved_by: Mapping[str, str]) -> None:
        """Follow the fields that keys of a scenario move, `moved_by`, through the text of all sources."""
        self._moved_by = moved_by
        self._carriers: dict[str, tuple[str, ...]] = {}
        lines = [_without_comments(line) for line in text]
        parameters = {
            found["function"]: _parameters(line[found.end() :])
            for line in lines
            if (found := _DEFINED.match(line)) and not line.rstrip().endswith(";")
        }
        passed = [each for line in lines for each in _passed(line, parameters)]
        for _ in range(_ROUNDS):
            for name, value in passed:
                fields = (*self._carriers.get(name, ()), *self._fields_in(value))
                if fields:
                    self._carriers[name] = tuple(dict.fromkeys(fields))

    def _fields_in(self, expression: str) -> tuple[str, ...]:
        direct = [name for name in _FIELD.findall(expression) if name in self._moved_by]
        carried = [field for name in _WORD.findall(expression) for field in self._carriers.get(name, ())]
        return tuple(dict.fromkeys((*direct, *carried)))

    def hint(self, line: str) -> str:
        """State which signals a line's condition depends on, and which keys move them; empty where none shows."""
        fields = self._fields_in(_without_comments(line))
        return "; ".join(f"{field}: {self._moved_by[field]}" for field in fields)


def _passed(line: str, parameters: Mapping[str, Sequence[str]]) -> Iterator[_Passed]:
    """List what a line assigns, and what it hands to functions: arguments to parameters, and back to addresses."""
    for found in _ASSIGNED.finditer(line):
        yield _Passed(found["name"], found["value"])
    unpacked = _UNPACKED.match(line)
    if unpacked is not None:
        yield from (
            _Passed(name.split()[-1], unpacked["value"])
            for name in unpacked["names"].split(",")
            if name.strip()
        )
    if _DEFINED.match(line):
        return
    for found in _CALLED.finditer(line):
        arguments = _arguments(line[found.end() :])
        inputs = " , ".join(argument for argument in arguments if not _OUTPUT.match(argument))
        yield from (_Passed(output["name"], inputs) for output in map(_OUTPUT.match, arguments) if output)
        known = parameters.get(found["function"], ())
        yield from map(_Passed, known, arguments)


def _arguments(text: str) -> list[str]:
    """Split what follows an opening parenthesis at the commas of its own level."""
    depth, parts = 0, [""]
    for character in text:
        if character in ")]}" and depth == 0:
            break
        depth += (character in "([{") - (character in ")]}")
        if character == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += character
    return parts


def _parameters(text: str) -> list[str]:
    found = (_PARAMETER.search(part.strip()) for part in _arguments(text))
    # A method's own object is no argument of its calls.
    return [name[1] for name in found if name is not None and name[1] != "self"]


def _without_comments(line: str) -> str:
    return re.sub(r"/\*.*?\*/|//.*|#.*", "", line[:_LONGEST])
