"""A known good controller that shows whether a requirement can be met in the scenario of an accusation."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Witness:
    """A built-in controller that passes the packaged drives of some kinds."""

    candidate: str
    """The string that names it."""
    kinds: tuple[str, ...]
    """Kinds of drives whose packaged ones it passes; on others it is no witness."""
    knows_plant: bool = False
    """Whether it knows more of the drive than its nameplate states, so that it shows what is possible, not what is
    reasonable."""
