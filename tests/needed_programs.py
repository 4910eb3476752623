"""Tests that need a program which no Python package brings are left out, and named, where it does not work."""

from __future__ import annotations

import shutil
from functools import cache

import pytest
from tests.working_programs import works

# The first one is the same engine without a desktop, and tests of pages take two thirds of the time in it.
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
IN_WORDS = {
    "browser": f"a browser ({', '.join(BROWSERS)}, or the one that `playwright install --with-deps chromium` brings)",
    "c++": "a C++ compiler (c++)",
    "rustc": "the Rust compiler (rustc)",
    "cargo": "Rust's build system (cargo)",
    "llvm": "the tools of Rust's LLVM (llvm-profdata and llvm-cov of the version that rustc -vV prints)",
    "man": "the reader of manual pages (man)",
    "arm-none-eabi-gcc": "the compiler for Arm microcontrollers (arm-none-eabi-gcc, with newlib)",
}


@cache
def found(program: str) -> str | None:
    """Find a program that works; the first browser that does."""
    if program != "browser":
        return (shutil.which(program) or program) if works(program) else None
    installed = next(filter(works, BROWSERS), None)
    return _browser_of_playwright() if installed is None else shutil.which(installed)


def _browser_of_playwright() -> str | None:
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        path = playwright.chromium.executable_path
    return path if works(path) else None


def pytest_addoption(parser: pytest.Parser) -> None:
    """Let a missing program be a failure."""
    parser.addoption(
        "--require-programs",
        action="store_true",
        help="run only the tests that need a program, present or not",
    )


def pytest_configure(config: pytest.Config) -> None:
    """Tell what the marker is for."""
    config.addinivalue_line(
        "markers", f"needs(program): needs what no Python package brings: {', '.join(IN_WORDS)}"
    )


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Leave out what cannot run here, or whatever needs no program."""
    chosen = []
    for item in items:
        programs = [mark.args[0] for mark in item.iter_markers("needs")]
        if config.getoption("--require-programs"):
            if programs:
                chosen.append(item)
        elif all(map(found, programs)):
            chosen.append(item)
    if len(chosen) < len(items):
        config.hook.pytest_deselected(items=[item for item in items if item not in chosen])
        items[:] = chosen


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """Fail in one sentence what has been requested and cannot run."""
    for mark in item.iter_markers("needs"):
        if found(mark.args[0]) is None:
            pytest.fail(f"this test needs {IN_WORDS[mark.args[0]]}", pytrace=False)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter, config: pytest.Config) -> None:
    """Say what was left out, and how to run it."""
    missing = [words for program, words in IN_WORDS.items() if found(program) is None]
    if missing and not config.getoption("--require-programs"):
        for words in missing:
            terminalreporter.write_line(
                f"left out: every test that needs {words}, which is missing or does not work", yellow=True
            )
        terminalreporter.write_line(
            "with it installed, `tox -e programs` runs these tests alone", yellow=True
        )


@pytest.fixture(scope="session")
def browser_path() -> str:
    """Path of a browser."""
    path = found("browser")
    assert path is not None
    return path
