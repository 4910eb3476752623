"""Running `drivegate bench` in this process."""

import pytest
from tests.harness.ended import Ended, ended

from drivegate_lab.bench.workbench import Workbench


@pytest.fixture
def bench(capsys, monkeypatch, tmp_path):
    """Run `drivegate bench` in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(*words: object) -> Ended:
        return ended(capsys, "bench", *words)

    return run


@pytest.fixture
def workbench(tmp_path):
    """A workbench for quick measurements."""
    return Workbench(tmp_path, quick=True)
