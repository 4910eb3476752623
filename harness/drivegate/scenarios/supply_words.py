"""The voltage of a supply as its users state it: of each half where the link has a tap, else of the whole link."""

from __future__ import annotations

from collections.abc import Sequence

from drivegate_cases.drive.drive_document import SPLIT_SUPPLY
from drivegate_cases.scenario.piecewise import Profile


def stated_supply(kind: str, halves: Sequence[Sequence[float]]) -> tuple[str, Profile]:
    """Return what the users of a kind of drive call its supply, and its course (s, V), from that of each half."""
    name, share = ("half-supply", 1.0) if kind == SPLIT_SUPPLY else ("link", 2.0)
    return name, tuple((time, share * volts) for time, volts in halves)
