"""What is left out of the daily tests, and the option that runs it."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SUITE = """import pytest

@pytest.mark.one_in(3)
@pytest.mark.parametrize("case", range(7))
def test_sweep(case): pass

@pytest.mark.nightly
def test_whole(): pass
"""


@pytest.mark.parametrize(
    ("words", "closing"),
    [((), "3 passed in"), (("--nightly",), "8 passed in"), (("test_suite.py::test_whole",), "1 passed in")],
)
def test_nightly_tests_run_when_they_are_asked_for(
    tmp_path: Path, words: tuple[str, ...], closing: str
) -> None:
    (tmp_path / "test_suite.py").write_text(SUITE, encoding="utf-8")
    (tmp_path / "pytest.ini").write_text("[pytest]\naddopts = -p tests.nightly\n", encoding="utf-8")
    ended = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-p", "no:xdist", *words],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout
    assert closing in ended.stdout
