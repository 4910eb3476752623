"""Run the product's tests in an installation without the laboratory, then all others with it.

    python tests/run_parts.py [arguments of pytest]

Arguments that name tests are run once, with whatever is installed.
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Final

TESTS: Final = Path(__file__).resolve().parent
PRODUCT: Final = ("cases", "harness", "models", "reports")
"""Folders with the tests of the four packages of the product."""
OTHERS: Final = ("benchmarks", "lab", "repository")
"""Folders with tests of the laboratory, and of what uses it."""
_PYTEST: Final = ("-m", "pytest", "--numprocesses", "logical", "--dist", "worksteal")


@contextmanager
def without_laboratory() -> Iterator[None]:
    """Take the installed package away, and put it back whatever happens."""
    found = find_spec("drivegate_lab")
    if found is None or not found.submodule_search_locations:
        raise SystemExit("drivegate_lab is not installed; install drivegate again, which brings it")
    package = Path(found.submodule_search_locations[0])
    apart = package.with_name("drivegate_lab.apart")
    package.rename(apart)
    try:
        yield
    finally:
        apart.rename(package)


def run(folders: Sequence[str], options: Sequence[str]) -> int:
    """Run the tests of some folders in a process of their own, and return its exit code."""
    paths = [str(TESTS / folder) for folder in folders]
    return subprocess.run([sys.executable, *_PYTEST, *options, *paths], check=False).returncode


def main(options: Sequence[str]) -> int:
    """Run both parts, the second one even if the first fails."""
    if any(Path(option.partition("::")[0]).exists() for option in options):
        return run((), options)
    with without_laboratory():
        alone = run(PRODUCT, options)
    return run(OTHERS, options) or alone


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
