"""The check of a candidate from end to end, in real worker processes."""

import json
import re
import textwrap
import time
from pathlib import Path
from typing import Any

import pytest

from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.drives.envelope_document import envelope_of
from drivegate.gate import engine
from drivegate.gate.engine import check_candidate
from drivegate.gate.events import CheckFinished, CheckStarted, Event, RunDone, Shrinking
from drivegate.gate.options import CheckOptions
from drivegate.output.result_file import as_json
from drivegate.results.document import ResultDocument
from drivegate.results.result import finite
from drivegate.scenarios.simplification import size_of
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument, load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError


def check(text: str, **options: Any) -> ResultDocument:
    events = list(check_candidate(resolve_candidate(text), CheckOptions(effort="quick", **options)))
    assert isinstance(events[0], CheckStarted)
    done = [event.done for event in events if isinstance(event, RunDone)]
    assert done == sorted(done), f"progress goes back: {done}"
    shrinking = [(event.done, event.planned) for event in events if isinstance(event, Shrinking)]
    assert shrinking == [(index, len(shrinking) - 1) for index in range(len(shrinking))]
    final = events[-1]
    assert isinstance(final, CheckFinished)
    if final.result.verdict in ("pass", "fail"):
        stated = [event for event in events if isinstance(event, RunDone)][-1]
        assert stated.done == stated.planned == final.result.runs, (
            "progress must end with the runs of the result"
        )
    return final.result


@pytest.fixture
def few_jobs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few short runs: what is wrong with a candidate from its first steps shows in any of them."""

    def short(*given: Any) -> tuple[Scenario, ...]:
        return tuple(
            scenario.model_copy(update={"duration_s": 2.0}) for scenario in fixed_scenarios(*given)[:3]
        )

    monkeypatch.setattr("drivegate.contracts.current.contract.fixed_scenarios", short)
    monkeypatch.setattr("drivegate.gate.plan.SHARDS", 1)
    monkeypatch.setattr("drivegate.gate.plan.EXAMPLES", {"quick": 1})


def check_of_initial(workers: int) -> ResultDocument:
    """Check the line of angles alone in a third of the fixed scenarios and in two shards of drawn ones."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(
            "drivegate.contracts.current.contract.fixed_scenarios",
            lambda *given: fixed_scenarios(*given)[::3],
        )
        patched.setattr("drivegate.gate.plan.SHARDS", 2)
        return check("initial", workers=workers, seed=5)


@pytest.fixture
def little_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """All fixed scenarios, and one shard of few drawn ones, of which the test on the number of workers has more."""
    monkeypatch.setattr("drivegate.gate.plan.SHARDS", 1)


@pytest.fixture(scope="module")
def initial() -> ResultDocument:
    return check_of_initial(2)


def verdicts(result: ResultDocument) -> dict[str, str]:
    return {outcome.id: outcome.verdict for outcome in result.checks}


def test_the_reference_passes_every_required_check(little_drawn: None) -> None:
    result = check("reference")
    assert (result.verdict, result.exit_code) == ("pass", 0), verdicts(result)
    assert verdicts(result)["FLO-1"] == "not applicable", "the reference does not follow the flowchart"
    assert "TIM-1" in result.timing["checks"], "a time depends on the machine and belongs to the times"
    assert [run.name for run in result.fixed] == [
        scenario.name for scenario in fixed_scenarios(load_drive("paper-5-phase"))
    ]


def test_the_published_search_fails_and_shows_the_lock_up(little_drawn: None) -> None:
    result = check("published")
    found = verdicts(result)
    assert (result.verdict, result.exit_code) == ("fail", 1)
    assert found["CNV-1"] == found["CNV-2"] == found["CPW-1"] == "fail", found
    assert found["ADV-1"] == "pass", found
    convergence = next(outcome for outcome in result.checks if outcome.id == "CNV-1")
    assert "lock-up" in convergence.message
    assert convergence.counterexample is not None
    assert convergence.counterexample["drive"]["machine"]["inductance_h"] > 0.0, (
        "the scenario is not fully resolved"
    )
    assert convergence.scenario is not None
    assert convergence.found is not None
    assert convergence.found.margin < 0.0, "a counterexample has to break its check"
    assert convergence.found.size <= size_of(convergence.scenario), "a counterexample is the simpler scenario"
    assert found["FLO-1"] == "pass", "the published search follows its own flowchart"


def test_the_initial_angle_alone_converges_but_misses_the_optimum(initial: ResultDocument) -> None:
    found = verdicts(initial)
    assert found["CNV-2"] == "fail", found
    assert found["CNV-1"] == found["CNV-3"] == found["CPW-1"] == "pass", found
    failed = {one.id for one in initial.checks if (one.level, one.verdict) == ("required", "fail")}
    assert failed <= {"CNV-2", "ROB-1"}, "the template that gives the same commands waives these alone"


def test_the_result_has_its_drive_and_what_that_can_do(initial: ResultDocument) -> None:
    document = parse_document(json.loads(as_json(initial.written())), ResultDocument, "the result")
    drive = load_drive("paper-5-phase")
    assert document.drive is not None
    assert parse_document(document.drive.document, DriveDocument, "the drive") == drive
    assert document.envelope is not None
    assert document.envelope.model_dump() == as_read(finite(envelope_of(drive)))


def as_read(written: dict[str, Any]) -> dict[str, Any]:
    """Lists of a document are read as tuples."""
    return written | {"points": tuple(written["points"])}


def test_the_result_does_not_depend_on_the_number_of_workers(initial: ResultDocument) -> None:
    documents = []
    for result in (check_of_initial(1), initial):
        document = result.written()
        del document["timing"]
        documents.append(json.dumps(document))
    assert documents[0] == documents[1]


def candidate(folder: Path, body: str) -> str:
    source = f"""
from drivegate import Command
import math, random, time

class Controller:
    def reset(self, nameplate):
        self.count = 0
    def step(self, sense):
{textwrap.indent(textwrap.dedent(body), " " * 8)}
"""
    (folder / "mine.py").write_text(source)
    return f"{folder / 'mine.py'}:Controller"


@pytest.mark.parametrize(
    ("body", "verdict"),
    [
        ("raise ValueError('no <b>idea</b>')", "exception"),
        ("return Command(math.nan, 0.0)", "invalid output"),
        ("return 3", "invalid output"),
        ("import os; os._exit(3)", "crash"),
        ("return Command(random.random(), 0.0)", "non-deterministic"),
    ],
)
def test_faults_of_a_python_candidate_become_verdicts(
    tmp_path: Path, few_jobs: None, body: str, verdict: str
) -> None:
    result = check(candidate(tmp_path, body), workers=1)
    assert (result.verdict, result.exit_code) == (verdict, 1), result.faults
    if verdict != "non-deterministic":
        assert result.faults[0].sense is None or "speed" in result.faults[0].sense
        assert set(verdicts(result).values()) <= {
            "inconclusive",
            "fail",
            "not yet witnessed",
            "not applicable",
        }, verdicts(result)


def test_commands_out_of_range_fail_their_checks_and_are_clamped(tmp_path: Path, few_jobs: None) -> None:
    found = verdicts(check(candidate(tmp_path, "return Command(1e9, -0.02)"), workers=1))
    assert found["ADV-2"] == found["CMD-1"] == "fail", found
    assert found["PWR-1"] == "pass", "the plant suffered from a command out of range"


def test_time_that_has_run_out_is_inconclusive() -> None:
    result = check("reference", max_time=1e-9)
    assert (result.verdict, result.exit_code, result.incomplete) == ("inconclusive", 1, "max time")


def test_runs_that_take_too_long_end_soon_after_the_time_has_run_out(tmp_path: Path, few_jobs: None) -> None:
    slow = candidate(tmp_path, "import time; time.sleep(0.001); return Command(1.0, 0.0)")
    began = time.monotonic()
    result = check(slow, workers=2, max_time=1.0)
    assert time.monotonic() - began < 8.0, "a run of ten thousand steps must not be waited for"
    assert (result.verdict, result.incomplete) == ("inconclusive", "max time")


def test_a_check_that_is_ended_has_what_its_runs_have_shown(tmp_path: Path, few_jobs: None) -> None:
    ended: list[Event] = []
    events = check_candidate(
        resolve_candidate(candidate(tmp_path, "return Command(1e9, -0.02)")),
        CheckOptions(effort="quick", workers=1, is_ended=lambda: bool(ended)),
    )
    for event in events:
        if isinstance(event, RunDone):
            ended.append(event)
    assert len(ended) == 1, "no more work begins"
    assert isinstance(event, CheckFinished)
    result = event.result
    unheard = "not yet witnessed"
    assert (result.verdict, result.exit_code, result.incomplete) == (unheard, 1, "interrupted")
    failed = {outcome.id: outcome for outcome in result.checks}["CMD-1"]
    assert failed.verdict == unheard
    assert failed.counterexample is not None
    assert result.runs == ended[0].done
    document = json.loads(as_json(result.written()))
    assert parse_document(document, ResultDocument, "the result").incomplete == "interrupted"


@pytest.mark.parametrize("uncompiled", [(), ("star",)])
def test_a_drive_is_refused_once_its_kernels_are_compiled(
    monkeypatch: pytest.MonkeyPatch, uncompiled: tuple[str, ...]
) -> None:
    compiled: list[str] = []

    def refuse(_: DriveDocument) -> None:
        raise InputError(f"with {compiled} compiled")

    monkeypatch.setattr(engine, "uncompiled_kinds", lambda _: uncompiled)
    monkeypatch.setattr(engine, "compile_kernels", lambda kinds, _: compiled.extend(kinds))
    monkeypatch.setattr(engine, "refuse_unreachable", refuse)
    with pytest.raises(InputError, match=re.escape(f"with {list(uncompiled)} compiled")):
        list(check_candidate(resolve_candidate("initial"), CheckOptions(drive=load_drive("star-3-phase"))))


def test_a_drive_whose_runs_cannot_be_planned_is_refused_before_they_are(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(engine, "uncompiled_kinds", lambda _: ("half-bridge",))
    monkeypatch.setattr(engine, "compile_kernels", lambda _, __: None)
    slow = load_drive("fan-3-phase").replaced(inertia_kg_m2=1e3)
    with pytest.raises(InputError, match="is too slow to be checked"):
        list(check_candidate(resolve_candidate("initial"), CheckOptions(drive=slow)))


def test_an_unknown_effort_is_refused() -> None:
    with pytest.raises(InputError, match="must be one of quick, default, nightly"):
        list(check_candidate(resolve_candidate("initial"), CheckOptions(effort="heroic")))


def test_a_check_that_does_not_apply_ends_no_check_and_shows_no_margin() -> None:
    options = CheckOptions(effort="quick", drive=load_drive("pm-ac-2kw-sensorless"))
    counting = engine._counting(engine._planned(resolve_candidate("foc-sensorless"), options))
    assert "SLS-1" in counting
    assert counting.isdisjoint({"STA-1", "ROB-4", "ROB-5", "SAF-1"})
