"""What a candidate says reaches the log of a CI server as text, never as a command."""

from __future__ import annotations

import io
import json
import logging
import subprocess
import sys
import warnings
from pathlib import Path

import click
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.harness.made import with_hash
from tests.harness.output.log_commands import commands_in

from drivegate.commands import conduct
from drivegate.commands.conduct import Outcome, conducted
from drivegate.output.console import console_for, plain, table
from drivegate.output.progress import progress_on
from drivegate.output.result_reports import workflow_commands
from drivegate.output.streams import LogStream, guard_output, harmless, write_to
from drivegate_models.errors import HarnessFault, InputError

HOSTILE = (
    "::notice title=gate::passed",
    "  ::stop-commands::x",
    "x ##[add-mask]y",
    "##vso[task.complete]",
    "##teamcity[buildStatus text='passed']",
    "\r::error::x",
    "a\x85::error::x",
    "\x1b[2J",
    "\x9b31m",
)
PIECES = (
    ":",
    "::",
    ":::",
    "#",
    "##",
    "###",
    "vso",
    "TEAMCITY",
    "[",
    "\n",
    "\r",
    " ",
    "\t",
    "\u2028",
    "\x1b[1m",
    "a",
)
ANY_TEXT = st.lists(st.sampled_from(PIECES) | st.text(max_size=3), max_size=12).map("".join)
BAD_TEXT = st.tuples(ANY_TEXT, st.sampled_from(HOSTILE), ANY_TEXT).map("".join)


@pytest.fixture
def streams(monkeypatch: pytest.MonkeyPatch) -> io.StringIO:
    """Both standard streams in one, as the log of a job has them."""
    log = io.StringIO()
    monkeypatch.setattr(sys, "stdout", log)
    monkeypatch.setattr(sys, "stderr", log)
    return log


@pytest.mark.parametrize("text", HOSTILE)
def test_no_text_on_the_console_is_a_command(text: str) -> None:
    assert commands_in(text) != [], "the test would not see a command"
    stream = io.StringIO()
    write_to(stream, f"{text}\n")
    console = console_for(stream)
    console.print(plain(text))
    console.print(text)
    rows = table("candidate")
    # A cell that is folded may begin a line anywhere.
    rows.add_row(plain("x" * 158 + text))
    rows.add_row(text)
    console.print(rows)
    assert commands_in(stream.getvalue()) == []
    assert "x" * 100 in stream.getvalue()


@given(texts=st.lists(ANY_TEXT, max_size=6))
def test_no_text_is_a_command_in_however_many_pieces_it_is_written(texts: list[str]) -> None:
    written = io.StringIO()
    stream = LogStream(written)
    assert [stream.write(text) for text in texts] == [len(text) for text in texts]
    assert commands_in(written.getvalue()) == []
    assert "".join(written.getvalue().split(" ")) == "".join(harmless("".join(texts)).split(" "))


@given(text=ANY_TEXT)
def test_text_without_commands_is_not_changed(text: str) -> None:
    made = harmless(text)
    assert commands_in(made) == []
    assert harmless(made) == made
    if made.replace("\n", "").replace("\t", "").isprintable() and not commands_in(text) and made != text:
        assert not text.replace("\n", "").isprintable()


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=15)
@given(text=BAD_TEXT)
def test_nothing_that_a_command_prints_is_obeyed(text: str, streams: io.StringIO) -> None:
    """All ways out of a command: prints, logs, warnings, failures with tracebacks, progress, and what nobody caught."""

    def refused(error: Exception) -> object:
        raise error

    def shown() -> object:
        click.echo(text)
        click.echo(text, err=True)
        logging.getLogger("drivegate").warning("%s; the output is in x", text)
        logging.getLogger("drivegate.part").warning(text.replace("%", ""))
        # Python writes a warning so; pytest would record it.
        sys.stderr.write(warnings.formatwarning(text, UserWarning, text, 1))
        with progress_on(sys.stderr) as display:
            display.begin(text, 2)
            display.phase(text)
            display.announce(text)
        sys.excepthook(ValueError, ValueError(text), None)
        return Outcome({"name": text}, lambda console: console.print(text), 0)

    streams.seek(0)
    streams.truncate()
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DRIVEGATE_DEBUG", "1")
        patch.setattr(sys, "stdout", streams)
        patch.setattr(sys, "stderr", streams)
        # pytest's own handlers would take the records.
        patch.setattr(logging.getLogger("drivegate"), "propagate", False)
        patch.setattr(logging.getLogger("drivegate"), "handlers", [])
        for as_json in (False, True):
            assert conducted(shown, as_json=as_json) == 0
            for error in (InputError(text), HarnessFault(text), ValueError(text), click.ClickException(text)):
                assert conducted(lambda error=error: refused(error), as_json=as_json) in (2, 3)
    assert commands_in(streams.getvalue()) == []
    assert streams.getvalue().count("ValueError") > 4


def test_the_log_is_harmless_for_every_handler() -> None:
    guard_output()
    stream = io.StringIO()
    handler = logging.StreamHandler(stream)
    log = logging.getLogger("drivegate")
    log.addHandler(handler)
    try:
        log.warning("a compiler says\n%s", "::error::x\x1b[2J")
    finally:
        log.removeHandler(handler)
    assert stream.getvalue() == "a compiler says\n: :error::x\\x1b[2J\n"


def test_an_interpreter_without_unicode_has_no_way_past_the_filter(tmp_path: Path) -> None:
    """click writes past a text stream in ASCII if it finds the bytes below, and a traceback comes after the command."""
    program = (
        "import atexit, click; from drivegate.output.streams import guard_output; guard_output()\n"
        "atexit.register(print, '::notice::after')\n"
        "click.echo(chr(233) + ' ##vso[x]\\n::error::x')\n"
        "raise ValueError('::error::\\n::error::x')"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program],
        cwd=tmp_path,
        env={"PATH": "/usr/bin", "LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
        capture_output=True,
        text=True,
        check=False,
    )
    assert commands_in(ended.stdout + ended.stderr) == []
    assert "##vso [x]" in ended.stdout
    assert "after" in ended.stdout
    assert "ValueError: ::error::" in ended.stderr


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
        "message": "m ##[add-mask]x ##teamcity[x]\r\n::error::x",
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
    (line,) = workflow_commands(with_hash(result))
    assert commands_in(f"x{line}") == []
    assert line.startswith("::error file="), "drivegate's own annotation is a command"
