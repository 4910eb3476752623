"""Progress: plain lines where there is no terminal, a bar where there is one, and never a failure."""

import io
import time
from types import SimpleNamespace

import pytest

from drivegate.gate.events import CheckStarted, RunDone
from drivegate.output.event_loop import followed
from drivegate.output.pace import CheckPace
from drivegate.output.progress import Display, progress_on, with_rate


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Gone(io.StringIO):
    def write(self, text):
        raise BrokenPipeError


@pytest.fixture
def no_time_passes(monkeypatch):
    """Stop the clock that progress is told by, so that a busy machine adds no line."""
    monkeypatch.setattr("drivegate.output.progress.time", SimpleNamespace(monotonic=lambda: 1000.0))


def reported(stream):
    with progress_on(stream) as display:
        runs = (RunDone(done, 3, "a scenario", "CNV-1 +0.5") for done in (1, 2, 3))
        followed((CheckStarted("mine\x1b[31m", 3), *runs), display)


@pytest.mark.usefixtures("no_time_passes")
def test_plain_lines_are_few_and_printable():
    stream = io.StringIO()
    reported(stream)
    assert stream.getvalue().splitlines() == [
        r"mine\x1b[31m: 1 of 3 runs, least margin so far CNV-1 +0.5, 0 s left",
    ], "lines must be printable, and at most one in two seconds"


def test_a_terminal_gets_a_bar():
    stream = Terminal()
    reported(stream)
    assert "3/3" in stream.getvalue()


def test_lines_never_stand_still_for_long(monkeypatch):
    monkeypatch.setattr("drivegate.output.progress.SECONDS_BETWEEN_LINES", 0.05)
    stream = io.StringIO()
    with progress_on(stream) as display:
        display.begin("mine", 3)
        display.advance(1, 3, "slow", unit="runs", always=True)
        deadline = time.monotonic() + 60.0
        while len(stream.getvalue().splitlines()) <= 3:
            assert time.monotonic() < deadline, "a line must come although nothing has happened"
            time.sleep(0.01)
    lines = stream.getvalue().splitlines()
    assert lines[-1].startswith("mine: 1 of 3 runs, slow, ")
    assert lines[-1].endswith(" s so far")


def test_nobody_listening_is_no_failure():
    reported(Gone())
    reported(None)


@pytest.mark.usefixtures("no_time_passes")
def test_the_rate_leaves_out_what_was_there_before_and_the_start():
    stream, now = io.StringIO(), [0.0]
    with progress_on(stream) as display:
        tell = with_rate(display, "many", 1000, "points", clock=lambda: now[0])
        for now[0], done in ((100.0, 400), (110.0, 500), (130.0, 1000)):
            tell(done, 400)
    assert stream.getvalue().splitlines() == [
        "many: 400 of 1000 points, starting",
        "many: 1000 of 1000 points, 20 points/s, 0 s left",
    ], "the first and the last line are reported, however close"


class Kept(Display):
    """Keeps the last line."""

    def _print(self, words, always):
        self.last = words


@pytest.mark.parametrize(
    ("seconds", "time_left"), [(10.0, "90 s left"), (60.0, "9 min left"), (800.0, "2 h 0 min left")]
)
def test_the_time_left_is_reported_as_people_say_it(seconds, time_left):
    kept, now = Kept(), [0.0]
    tell = with_rate(kept, "many", 10, clock=lambda: now[0])
    tell(0, 0)
    now[0] = seconds
    tell(1, 0)
    assert kept.last.endswith(time_left)


def test_a_check_that_takes_hours_is_told_once_with_what_makes_it_shorter():
    now = [0.0]
    pace = CheckPace(clock=lambda: now[0])
    told = []
    for now[0], done in ((30.0, 2), (35.0, 4), (130.0, 6), (230.0, 8)):
        told.append(pace.slow_in_words(done, 302))
    # From 30 s on it made 4 runs in 100 s.
    assert told == [
        "",
        "",
        "at this pace this check takes about 2 h 3 min more; --effort quick or --only makes it shorter, and "
        "--max-time ends it",
        "",
    ]


def test_a_check_of_less_than_an_hour_is_not_told_to_be_long():
    now = [0.0]
    pace = CheckPace(clock=lambda: now[0])
    for now[0], done in ((30.0, 2), (130.0, 16), (230.0, 30)):
        assert pace.slow_in_words(done, 302) == ""


@pytest.mark.parametrize("stream", [io.StringIO(), Terminal()], ids=["a file", "a terminal"])
def test_an_announcement_stays_and_is_not_repeated(stream, monkeypatch):
    monkeypatch.setattr("drivegate.output.progress.SECONDS_BETWEEN_LINES", 0.05)
    with progress_on(stream) as display:
        display.begin("mine", 3)
        display.announce("at this pace \x1b[31m it takes hours")
        time.sleep(0.3)
    text = stream.getvalue()
    assert text.count("takes hours") == 1, text
    assert r"mine: at this pace \x1b[31m it takes hours" in text
