"""Fixtures that the laboratory's tests share with those of the packages that it proves right."""

from tests.harness.commands.conftest import command, controllers, refused
from tests.harness.conftest import altered, no_process_left, not_isolated
from tests.reports.conftest import (
    browser,
    duty_result,
    failing,
    failing_page,
    lock_up,
    make_check,
    make_document,
    pages,
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
