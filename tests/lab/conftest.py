"""Fixtures that the laboratory's tests share with those of the packages that it proves right."""

from pathlib import Path
from typing import Any

import pytest
from tests.harness.commands.conftest import command, controllers, refused
from tests.harness.conftest import altered, little_shrunk, no_process_left, not_isolated
from tests.reports.conftest import (
    browser,
    duty_result,
    failing,
    failing_page,
    lock_up,
    make_check,
    make_document,
    recorded,
    recorded_page,
    reproduction,
)
from tests.reports.test_browser import opened

__all__ = [
    "altered",
    "browser",
    "command",
    "controllers",
    "duty_result",
    "failing",
    "failing_page",
    "little_shrunk",
    "lock_up",
    "make_check",
    "make_document",
    "no_process_left",
    "not_isolated",
    "opened",
    "pages",
    "recorded",
    "recorded_page",
    "refused",
    "reproduction",
]


@pytest.fixture(scope="session")
def pages(reproduction: tuple[Path, dict[str, Any]]) -> dict[str, Path]:
    """Return the page of the reproduction; the others, which take most of the time to draw, are not opened here."""
    folder, document = reproduction
    return {"reproduction": folder / document["page"]}
