"""Running `drivegate bench` in this process."""

import json
from dataclasses import dataclass
from typing import Any

import pytest

from drivegate.commands.command_line import main
from drivegate.studies.bench.workbench import Workbench


@dataclass(frozen=True)
class Ended:
    """What a command printed, and its exit code."""

    code: int
    out: str
    err: str

    @property
    def document(self) -> Any:
        return json.loads(self.out)

    def row(self, name: str) -> dict[str, Any]:
        return next(row for row in self.document["rows"] if row["name"] == name)


@pytest.fixture
def bench(capsys, monkeypatch, tmp_path):
    """Run `drivegate bench` in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(*words: object) -> Ended:
        with pytest.raises(SystemExit) as ended:
            main(["bench", *map(str, words)])
        printed = capsys.readouterr()
        return Ended(int(ended.value.code or 0), printed.out, printed.err)

    return run


@pytest.fixture
def workbench(tmp_path):
    """A workbench for quick measurements."""
    return Workbench(tmp_path, quick=True)
