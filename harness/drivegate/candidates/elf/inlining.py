"""What the compiler has inlined, and no call reaches: from the debug information of an image."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from drivegate.candidates.elf.debug_information import name_of, referenced


def inlined_into(function: Any) -> tuple[str, ...]:
    """Return the names of the functions that a function of the same source is inlined into.

    `function`: as DWARF describes it.
    """
    origin = _origin(function)
    top = function.cu.get_top_DIE()
    return tuple(dict.fromkeys(outer for outer, each in _inlined(top, "") if _origin(each) == origin))


def _origin(die: Any) -> int:
    """Return where the function is described of which something is a copy."""
    while "DW_AT_abstract_origin" in die.attributes:
        die = referenced(die, "DW_AT_abstract_origin")
    return int(die.offset)


def _inlined(outer: Any, function: str) -> Iterator[tuple[str, Any]]:
    """List the copies of inlined functions, each with the name of the function that it is in."""
    for die in outer.iter_children():
        if die.tag == "DW_TAG_inlined_subroutine":
            yield function, die
        if die.has_children:
            yield from _inlined(die, name_of(die) if die.tag == "DW_TAG_subprogram" else function)
