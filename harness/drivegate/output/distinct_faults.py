"""Faults of many runs that say the same, reported once."""

from __future__ import annotations

from typing import Any


def distinct_faults(faults: list[dict[str, Any]]) -> list[tuple[dict[str, Any], int]]:
    """Group faults by what happened."""
    groups: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for fault in faults:
        groups.setdefault((fault["kind"], fault["phase"], fault["message"]), []).append(fault)
    return [(group[0], len(group)) for group in groups.values()]


def in_runs(count: int) -> str:
    """Tell how often a fault happened, where it was more than once."""
    return f" in {count} runs" if count > 1 else ""
