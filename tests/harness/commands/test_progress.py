"""Progress: plain lines where there is no terminal, a bar where there is one, and never a failure."""

import io
import time
from types import SimpleNamespace

import pytest

from drivegate.containment.watches import SlowRun
from drivegate.gate.events import (
    CheckPlan,
    CheckStarted,
    Compiling,
    Recording,
    RunDone,
    Running,
    Shrinking,
    WitnessesHeard,
)
from drivegate.output.event_loop import followed
from drivegate.output.progress import Display, progress_on, with_rate
from drivegate.output.waiting import CheckPace
from drivegate_cases.drive.drive_document import load_drive


class Terminal(io.StringIO):
    def isatty(self):
        return True


class Gone(io.StringIO):
    def write(self, text):
        raise BrokenPipeError


@pytest.fixture
def clock(monkeypatch):
    """The clock that progress is reported by, which only the test moves."""
    now = SimpleNamespace(seconds=1000.0)
    monkeypatch.setattr("drivegate.output.progress.time", SimpleNamespace(monotonic=lambda: now.seconds))
    return now


DRIVE = load_drive("pm-ac-interior")
START = CheckStarted("mine\x1b[31m", 10, CheckPlan(DRIVE, "user", "quick", 7, 2))


def reported(stream):
    with progress_on(stream) as display:
        followed((START, *(RunDone(done, 10, "a scenario", "CNV-1 +0.5") for done in range(1, 11))), display)


def test_a_log_has_a_headline_and_a_line_for_each_phase(clock):
    stream = io.StringIO()
    events = [
        START,
        Compiling(("pm-ac",)),
        Running(10),
        *(RunDone(done, 10, "a scenario", "") for done in range(1, 11)),
        Shrinking("", 0, 2),
        Shrinking("CNV-1", 1, 2),
        Shrinking("CNV-2", 2, 2),
        WitnessesHeard("", 0, 2),
        WitnessesHeard("CNV-1", 1, 2),
        Recording(),
    ]
    with progress_on(stream) as display:
        for event in events:
            clock.seconds += 1.0
            followed([event], display)
    lines = stream.getvalue().splitlines()
    assert lines.pop(1).startswith(r"mine\x1b[31m: compiling the kernels, which is done once")
    assert lines == [
        r"mine\x1b[31m on pm-ac-interior, contract duty, effort quick, seed 7",
        r"mine\x1b[31m: running",
        r"mine\x1b[31m: shrinking counterexamples: 0 of 2",
        r"mine\x1b[31m: running known good controllers in counterexamples: 0 of 2",
        r"mine\x1b[31m: recording what the report shows",
    ]


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("user", ""),
        ("manifest", " (from its manifest)"),
        ("default", " (default for duty-ratio candidates)"),
    ],
)
def test_the_first_line_of_a_log_says_who_chose_the_drive(source, words):
    stream = io.StringIO()
    with progress_on(stream) as display:
        followed([CheckStarted("foc", 2, CheckPlan(DRIVE, source, "quick", 0, 2))], display)
    assert stream.getvalue() == f"foc on pm-ac-interior{words}, contract duty, effort quick, seed 0\n"


@pytest.mark.parametrize(
    ("seconds", "parts", "expected"),
    [
        (1.0, 100, [30, 60, 90]),
        (1.0, 1000, list(range(100, 1001, 100))),
        (60.0, 20, list(range(2, 21, 2))),
    ],
    ids=["half a minute is later", "a tenth is later", "slow parts"],
)
def test_a_log_has_a_line_for_a_tenth_or_half_a_minute_whichever_is_later(clock, seconds, parts, expected):
    stream = io.StringIO()
    with progress_on(stream) as display:
        display.begin("mine", parts)
        for done in range(1, parts + 1):
            clock.seconds += seconds
            display.advance(done, parts)
    assert stream.getvalue().splitlines() == [f"mine: {done} of {parts}" for done in expected]


def test_no_line_of_a_log_is_printed_twice(clock):
    stream = io.StringIO()
    with progress_on(stream) as display:
        display.begin("mine", 3)
        for _ in range(3):
            clock.seconds += 100.0
            display.phase("running")
            display.advance(1, 3)
            display.announce("it takes long")
    lines = stream.getvalue().splitlines()
    assert len(lines) == len(set(lines)) == 3, lines


def test_a_terminal_gets_a_bar():
    stream = Terminal()
    reported(stream)
    assert "10/10" in stream.getvalue()
    assert r"mine\x1b[31m on pm-ac-interior, contract duty, effort quick, seed 7" in stream.getvalue()


def test_a_phase_of_a_terminal_has_a_name_and_moves_although_nothing_happens():
    stream = Terminal()
    with progress_on(stream) as display:
        display.begin("mine")
        display.phase("recording")
        deadline = time.monotonic() + 60.0
        while stream.getvalue().count("recording") < 3:
            assert time.monotonic() < deadline, "the bar must move although nothing has happened"
            time.sleep(0.01)


def test_nobody_listening_is_no_failure():
    reported(Gone())
    reported(None)


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

    def _print(self, words, done, total, *, always):
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


def test_a_check_that_takes_hours_is_reported_once_with_what_makes_it_shorter():
    now = [0.0]
    pace = CheckPace(clock=lambda: now[0])
    stated = []
    for now[0], done in ((30.0, 2), (34.0, 4), (130.0, 6), (230.0, 8)):
        stated.append(pace.slow_in_words(done, 302))
    # From 30 s on it made 4 runs in 100 s.
    assert stated == [
        "",
        "",
        "at this pace this check takes about 2 h 3 min more; --effort quick or --only makes it shorter, and "
        "--max-time ends it",
        "",
    ]


def test_the_first_slow_run_projects_the_whole_check_at_once():
    pace = CheckPace()
    pace.begin(120, 2)
    slow = SlowRun(60_000, 0.002, 180.0)
    assert pace.slow_run_in_words(slow) == (
        "at this pace this run takes about 2 min: 60000 steps of 0.002 s each, and this check about 2 h 0 min; "
        "--effort quick or --only makes it shorter, and --max-time ends it"
    )
    assert pace.slow_in_words(60, 120) == "", "it is projected once"


@pytest.mark.parametrize(
    ("used", "words"),
    [
        ({"is_quick": True}, "; --only makes it shorter, and --max-time ends it"),
        ({"is_part": True}, "; --effort quick makes it shorter, and --max-time ends it"),
        ({"is_quick": True, "is_part": True}, " more; --max-time ends it"),
    ],
)
def test_what_makes_it_shorter_is_not_what_was_asked_for_already(used, words):
    now = [0.0]
    pace = CheckPace(clock=lambda: now[0], **used)
    for now[0], done in ((30.0, 2), (34.0, 4), (130.0, 6)):
        stated = pace.slow_in_words(done, 302)
    assert stated.endswith(words)


def test_a_check_of_a_few_minutes_is_not_announced_as_long():
    now = [0.0]
    pace = CheckPace(clock=lambda: now[0])
    for now[0], done in ((30.0, 2), (130.0, 102), (230.0, 202)):
        assert pace.slow_in_words(done, 302) == ""


@pytest.mark.parametrize("stream", [io.StringIO(), Terminal()], ids=["a file", "a terminal"])
def test_an_announcement_stays_and_is_not_repeated(stream):
    with progress_on(stream) as display:
        display.begin("mine", 3)
        display.announce("at this pace \x1b[31m it takes hours")
        time.sleep(0.3)
    text = stream.getvalue()
    assert text.count("takes hours") == 1, text
    assert r"mine: at this pace \x1b[31m it takes hours" in text
