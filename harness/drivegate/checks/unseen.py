"""Runs that have not been made, from which follows whether a check looks at a run at all."""

from __future__ import annotations

from typing import Any


class NotRun(Exception):
    """Raised where something is read that only the run shows."""


class Unseen:
    """Stand-in for what a run shows: reading anything but what is already known raises `NotRun`."""

    def __init__(self, **known: Any) -> None:
        self.__dict__.update(known)

    def __getattr__(self, name: str) -> Any:
        raise NotRun(name)
