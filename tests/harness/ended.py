"""Running the command line in this process."""

import json
from dataclasses import dataclass
from typing import Any

import pytest

from drivegate.commands.command_line import main


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


def ended(capsys: pytest.CaptureFixture[str], *words: object) -> Ended:
    """Run a command to its end."""
    with pytest.raises(SystemExit) as left:
        main([str(word) for word in words])
    printed = capsys.readouterr()
    return Ended(int(left.value.code or 0), printed.out, printed.err)
