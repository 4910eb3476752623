"""How deep and how large a document may be, so that every one is read or refused in a few seconds."""

from typing import Final

DEEPEST: Final = 32
"""Most levels of tables and lists, several times what any document has."""
MOST_KEYS: Final = 200_000
"""Most keys in all tables of a document."""
MOST_ENTRIES: Final = 1_000_000
"""Most entries in all lists of a document."""
TOO_DEEP: Final = f"is nested too deeply; a document has at most {DEEPEST} levels of tables and lists"


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
