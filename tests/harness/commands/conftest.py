"""Running the command line in this process, and results to show without a check."""

import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pytest
from tests.harness.ended import Ended, ended
from tests.harness.made import made_outcome, made_result

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault, FaultKind
from drivegate.gate.events import CheckFinished, CheckPlan, CheckStarted, RunDone
from drivegate.gate.options import CheckOptions
from drivegate.results.document import CheckSection, ComparisonSection
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import load_scenario


@pytest.fixture
def command(capsys, monkeypatch, tmp_path):
    """Run a command in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(*words: object) -> Ended:
        return ended(capsys, *words)

    return run


@pytest.fixture
def refused(command, tmp_path):
    """Run a command that must be refused in one sentence, without writing anything, as text and as JSON."""

    def run(*words: object) -> str:
        before = sorted(tmp_path.rglob("*"))
        text, data = command(*words), command(*words, "--json")
        assert text.code == data.code == 2, f"bad input must end with exit code 2: {text.err}"
        assert text.out == "", "a refusal belongs on standard error"
        lines = text.err.strip().splitlines()
        assert len(lines) == 1, f"a refusal must be one sentence: {text.err}"
        assert lines[0].startswith("error: ")
        assert "Traceback" not in text.err
        assert set(data.document) == {"schema", "error"}
        assert data.document["error"] == {"message": lines[0].removeprefix("error: "), "exit_code": 2}
        assert sorted(tmp_path.rglob("*")) == before, "nothing may be written when input is bad"
        return lines[0]

    return run


CONTROLLERS = """
from drivegate import Command

class Steady:
    def reset(self, nameplate): pass
    def step(self, sense): return Command(current_reference=5.0, advance_angle=0.0)

class Raising(Steady):
    def step(self, sense): raise ValueError("\\x1b[31mred [bold]x[/bold] | <b> & ]]>")

class WithoutStep:
    def reset(self, nameplate): pass
"""


@pytest.fixture
def controllers(tmp_path):
    """A file with controllers of which each does one thing."""
    file = tmp_path / "controllers.py"
    file.write_text(CONTROLLERS, encoding="utf-8")
    return file


HOSTILE = "\x1b]0;title\x07[red]markup[/red] | a_b *c* <script> & \ud800 \ufffe \u202e"


def outcome(
    check: str, verdict: str, *, level: str = "required", message: str = "as measured"
) -> CheckSection:
    scenario = load_scenario("lock-up").to_mapping()
    applied = verdict in ("pass", "fail")
    return made_outcome(
        check,
        verdict,
        level=level,
        margin={"pass": 0.25, "fail": -1.5}.get(verdict),
        runs=int(applied),
        message=message,
        scenario=scenario if applied else None,
        counterexample=scenario if verdict in ("fail", "contested", "not yet witnessed") else None,
    )


@dataclass
class FakeEngine:
    """Stands for the engine: answers for a candidate by its name."""

    outcomes: tuple[CheckSection, ...] = ()
    faults: tuple[Fault, ...] = ()
    verdict: str = "pass"
    exit_code: int = 0
    error: BaseException | None = None
    options: CheckOptions | None = None
    baseline: tuple[ComparisonSection, ...] | None = None
    corpus_runs: int = 0
    focus: dict[str, Any] | None = None
    timing: dict[str, Any] = field(default_factory=lambda: {"seconds": 1.0})

    def __call__(self, candidate: Candidate, options: CheckOptions) -> Any:
        self.options = options
        yield CheckStarted(
            candidate.name, 2, CheckPlan(load_drive("paper-5-phase"), "default", "quick", 0, 2)
        )
        yield RunDone(1, 2, "a scenario", "CNV-1 +0.1")
        if self.error is not None:
            raise self.error
        result = made_result(
            candidate,
            faults=self.faults,
            verdict=self.verdict,
            exit_code=self.exit_code,
            seed=options.seed,
            effort=options.effort,
            checks=self.outcomes,
            runs=2,
            timing=self.timing,
            corpus_runs=self.corpus_runs,
            baseline=self.baseline,
            focus=self.focus,
        )
        yield CheckFinished(result)


REPORT_FILE = "report.html"
"""Name of the page of `OnePage`, by which the last line names it before it is written."""


class OnePage:
    """Stands for an installed report."""

    name = "page"

    def load(self) -> Callable[..., Any]:
        def write(document: dict[str, Any], folder: Any) -> Any:
            sys.stdout.write("a report that prints\n")
            (folder / "report.html").write_text(document["verdict"], encoding="utf-8")
            return folder / "report.html"

        return write


@pytest.fixture
def one_page(monkeypatch):
    """The reports replaced: one page, for which nothing is drawn."""
    monkeypatch.setattr("drivegate.output.report_writers.entry_points", lambda group: [OnePage()])


@pytest.fixture
def engine(monkeypatch, one_page):
    """The engine and the reports replaced: a pass, and one page."""
    fake = FakeEngine(outcomes=(outcome("CNV-1", "pass"),))
    monkeypatch.setattr("drivegate.gate.engine.check_candidate", fake)
    return fake


@pytest.fixture
def failing(engine):
    """The engine replaced: everything that can be reported, from a candidate that says what it should not."""
    engine.outcomes = (
        outcome("CNV-1", "fail", message=HOSTILE),
        outcome("CNV-2", "pass"),
        outcome("CPW-1", "not applicable"),
        outcome("RIP-1", "inconclusive"),
        outcome("CUR-1", "fail", level="advisory"),
    )
    fault = Fault(FaultKind.EXCEPTION, HOSTILE, "step", "ValueError", f"first\n{HOSTILE}", 3, 0.0015, None)
    engine.faults = (fault, fault)
    engine.verdict, engine.exit_code = "exception", 1
    return engine
