"""What a candidate says reaches the log of a CI server as text, never as a command."""

import io
import json

import pytest

from drivegate.commands import conduct
from drivegate.output.console import console_for, plain, table
from drivegate.output.result_reports import workflow_commands
from drivegate.output.streams import write_to

HOSTILE = ("::notice title=gate::passed", "  ::stop-commands::x", "x ##[add-mask]y", "##vso[task.complete]")


def commands_in(log: str) -> list[str]:
    """List the lines that GitHub Actions or Azure Pipelines would obey."""
    return [
        line
        for line in log.splitlines()
        if line.lstrip().startswith("::") or "##[" in line or "##vso[" in line.lower()
    ]


@pytest.mark.parametrize("text", HOSTILE)
def test_no_text_on_the_console_is_a_command(text: str) -> None:
    assert commands_in(text) == [text], "the test would not see a command"
    stream = io.StringIO()
    write_to(stream, f"{text}\n")
    console = console_for(stream)
    console.print(plain(text))
    rows = table("candidate")
    # A cell that is folded may begin a line anywhere.
    rows.add_row(plain("x" * 158 + text))
    console.print(rows)
    assert commands_in(stream.getvalue()) == []
    assert "x" * 100 in stream.getvalue()


def test_a_json_document_has_no_command_and_the_same_text(capsys: pytest.CaptureFixture[str]) -> None:
    document = {"name": "x ##[add-mask]y ###[z]"}
    conduct._write_json(document)
    printed = capsys.readouterr().out
    assert commands_in(printed) == []
    assert json.loads(printed) == document


def test_a_message_in_an_annotation_is_not_a_second_command() -> None:
    check = {
        "id": "CNV-1",
        "verdict": "fail",
        "level": "required",
        "message": "m ##[add-mask]x",
        "runs": 0,
        "counterexample": None,
    }
    result = {
        "candidate": {"name": "##[group]x", "specification": "##[group]x.toml"},
        "checks": [check],
        "faults": (),
        "baseline": None,
        "fail_on": "required",
    }
    (line,) = workflow_commands(result)
    assert "##[" not in line
