"""Tests that show once more what others show every time: the further cases of a sweep, and a second whole check."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest


def one_in(step: int, cases: Iterable[Any]) -> list[Any]:
    """Mark all cases of a sweep as nightly but the first one of so many."""
    return [
        case if place % step == 0 else pytest.param(case, marks=pytest.mark.nightly)
        for place, case in enumerate(cases)
    ]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Run these tests too."""
    parser.addoption("--nightly", action="store_true", help="run the tests that are marked as nightly, too")


def pytest_configure(config: pytest.Config) -> None:
    """State what the marker is for."""
    config.addinivalue_line(
        "markers", "nightly: shows once more what another test shows; left out without --nightly"
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave nightly tests out, unless nothing else is chosen."""
    if not config.getoption("--nightly"):
        items[:] = [item for item in items if item.get_closest_marker("nightly") is None] or items
