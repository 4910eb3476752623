"""Families of controllers that are named with a prefix, which the laboratory brings."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

from drivegate.candidates.kinds import LABORATORY_PREFIXES
from drivegate.laboratory import CANDIDATE_GROUP, require_from_laboratory
from drivegate_cases.documents.wording import one_line

if TYPE_CHECKING:
    from drivegate.candidates.contract import ContractName
    from drivegate.candidates.controller import Controller
    from drivegate.candidates.declaration import Declaration


class PrefixedControllers(ABC):
    """A family of controllers, each known by its name without the prefix."""

    @abstractmethod
    def contract(self, name: str) -> ContractName:
        """Return the contract of a controller; one that is unknown may have any."""

    @abstractmethod
    def declaration(self, name: str) -> Declaration:
        """Return what a controller declares of itself.

        Raises InputError if there is none of this name.
        """

    @abstractmethod
    def load_controller(self, name: str) -> Controller:
        """Make a new instance of a controller."""


def family_of(entry: str) -> tuple[PrefixedControllers, str] | None:
    """Return the family of an entry with a prefix, and the name in it; None for an entry without one.

    Raises InputError if the laboratory is not installed.
    """
    prefix, colon, name = entry.partition(":")
    if prefix + colon not in LABORATORY_PREFIXES:
        return None
    family: PrefixedControllers = require_from_laboratory(
        CANDIDATE_GROUP, prefix, f"the candidate '{one_line(entry)}'"
    )
    return family, name
