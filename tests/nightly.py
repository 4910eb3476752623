"""Tests that show once more what others show every time: the further cases of a sweep, and a second whole check."""

from __future__ import annotations

from collections import Counter

import pytest


def pytest_addoption(parser: pytest.Parser) -> None:
    """Run these tests too."""
    parser.addoption("--nightly", action="store_true", help="run the tests that are marked as nightly, too")


def pytest_configure(config: pytest.Config) -> None:
    """State what the markers are for."""
    config.addinivalue_line(
        "markers", "nightly: shows once more what another test shows; left out without --nightly"
    )
    config.addinivalue_line(
        "markers", "one_in(step): of the cases of this test, the first one of so many runs without --nightly"
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave nightly tests and cases out, unless nothing else is chosen."""
    if config.getoption("--nightly"):
        return
    cases: Counter[str] = Counter()
    daily = []
    for item in items:
        sweep = item.get_closest_marker("one_in")
        if item.get_closest_marker("nightly"):
            continue
        if sweep is not None:
            name = item.nodeid.partition("[")[0]
            cases[name] += 1
            if (cases[name] - 1) % sweep.args[0]:
                continue
        daily.append(item)
    items[:] = daily or items
