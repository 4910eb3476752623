"""What would reach a branch that no run took, as far as its condition shows it: a signal that is sensed."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Final

# A field of a record, through a pointer, a reference or an object.
_FIELD: Final = re.compile(r"(?:->|\.)\s*([A-Za-z_]\w*)")
_ASSIGNED: Final = re.compile(
    r"(?P<name>(?:\w+(?:->|\.))*[A-Za-z_]\w*)\s*(?:\[[^\]]*\])?\s*[-+*/|&^]?=(?!=)(?=\s*(?P<value>[^;]+))"
)
_WORD: Final = re.compile(r"(?:\w+(?:->|\.))*[A-Za-z_]\w*")
_LONGEST: Final = 1000
"""Characters of a line that are looked at; the patterns' time grows with the square."""
_ROUNDS: Final = 3
"""Number of variables in a row through which a signal is followed."""


class Conditions:
    """The signals that conditions in one file depend on, followed through variables of the same name.

    It reads text and no program, so it is a hint: it misses what goes through arguments of other names.
    """

    def __init__(self, text: Sequence[str], moved_by: Mapping[str, str]) -> None:
        """Follow the fields that keys of a scenario move, `moved_by`, through assignments."""
        self._moved_by = moved_by
        self._carriers: dict[str, tuple[str, ...]] = {}
        assigned = [found for line in text for found in _ASSIGNED.finditer(_without_comments(line))]
        for _ in range(_ROUNDS):
            for found in assigned:
                fields = (*self._carriers.get(found["name"], ()), *self._fields_in(found["value"]))
                if fields:
                    self._carriers[found["name"]] = tuple(dict.fromkeys(fields))

    def _fields_in(self, expression: str) -> tuple[str, ...]:
        direct = [name for name in _FIELD.findall(expression) if name in self._moved_by]
        carried = [field for name in _WORD.findall(expression) for field in self._carriers.get(name, ())]
        return tuple(dict.fromkeys((*direct, *carried)))

    def hint(self, line: str) -> str:
        """State which signals a line's condition depends on, and which keys move them; empty where none shows."""
        fields = self._fields_in(_without_comments(line))
        return "; ".join(f"{field}: {self._moved_by[field]}" for field in fields)


def _without_comments(line: str) -> str:
    return re.sub(r"/\*.*?\*/|//.*|#.*", "", line[:_LONGEST])
