"""Progress: plain lines where there is no terminal, a bar where there is one, and never a failure."""

import io

from drivegate.gate.events import CheckStarted, RunDone
from drivegate.output.progress import progress_on


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Gone(io.StringIO):
    def write(self, text):
        raise BrokenPipeError


def told(stream):
    with progress_on(stream) as handler:
        handler(CheckStarted("mine\x1b[31m", 3))
        for done in (1, 2, 3):
            handler(RunDone(done, 3, "a scenario", "CNV-1 +0.5"))


def test_plain_lines_are_few_and_printable():
    stream = io.StringIO()
    told(stream)
    assert stream.getvalue().splitlines() == [
        r"mine\x1b[31m: 1 of 3 runs, least margin so far CNV-1 +0.5",
    ], "lines must be printable, and at most one in two seconds"


def test_a_terminal_gets_a_bar():
    stream = Terminal()
    told(stream)
    assert "3/3" in stream.getvalue()


def test_nobody_listening_is_no_failure():
    told(Gone())
    told(None)
