"""The checks as items of a user's own pytest suite."""

from __future__ import annotations

import json
import logging
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import pytest
import scipy.optimize  # noqa: F401  (what a run of pytester imports is forgotten, and numpy cannot be imported twice)
from tests.harness.made import made_outcome, made_result
from tests.harness.output.log_commands import commands_in

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault, FaultKind
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.gate import engine as real_engine
from drivegate.gate.events import CheckFinished, CheckStarted, Event
from drivegate.gate.options import CheckOptions
from drivegate.results.document import CheckSection
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.errors import HarnessFault, InputError

pytest_plugins = ["pytester"]

SUITE = """
from drivegate import conformance_tests

@conformance_tests({arguments})
def test_conformance(conformance):
    conformance.verify()
"""
CONTROLLERS = """
from drivegate import Command

class Raising:
    def reset(self, nameplate):
        pass

    def step(self, sense):
        raise ValueError("what is this?")
"""


def outcome(check: Any, verdict: str, message: str = "") -> CheckSection:
    applied = verdict in ("pass", "fail")
    scenario = load_scenario("lock-up").to_mapping() if applied else None
    return made_outcome(
        check.id,
        verdict,
        requirement=check.requirement,
        source=check.source,
        subject=check.subject,
        level=check.level,
        limit=check.limit,
        margin={"pass": 0.25, "fail": -1.5}.get(verdict),
        measured="as measured",
        runs=int(applied),
        message=message or f"the message of {check.id}",
        scenario=scenario,
        counterexample=scenario if verdict == "fail" else None,
    )


@dataclass
class FakeEngine:
    """Stands for the engine: every check passes, apart from those named."""

    verdicts: dict[str, str] = field(default_factory=dict)
    faults: tuple[Fault, ...] = ()
    error: Exception | None = None
    message: str = ""
    calls: list[tuple[str, str, int]] = field(default_factory=list)
    options: list[CheckOptions] = field(default_factory=list)

    def __call__(self, candidate: Candidate, options: CheckOptions) -> Iterator[Event]:
        yield CheckStarted(candidate.name, 1)
        self.calls.append((candidate.specification, options.effort, options.seed))
        self.options.append(options)
        if self.message:
            logging.getLogger("drivegate").warning("%s", self.message)
        if self.error is not None:
            raise self.error
        checks = tuple(outcome(check, self.verdicts.get(check.id, "pass"), self.message) for check in CHECKS)
        verdict = "fail" if "fail" in self.verdicts.values() else "pass"
        result = made_result(
            candidate,
            faults=self.faults,
            verdict=verdict,
            exit_code=int(verdict != "pass"),
            seed=options.seed,
            effort=options.effort,
            checks=checks,
        )
        yield CheckFinished(result)


@pytest.fixture(autouse=True)
def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Keep from the suites that are run here which worker of pytest-xdist runs them."""
    monkeypatch.delenv("PYTEST_XDIST_WORKER", raising=False)


@pytest.fixture
def engine(monkeypatch: pytest.MonkeyPatch) -> FakeEngine:
    """The engine replaced in this process."""
    fake = FakeEngine()
    # The module is imported above: what a run of pytester imports is forgotten after it.
    monkeypatch.setattr(real_engine, "check_candidate", fake)
    return fake


@pytest.fixture
def suite(pytester: pytest.Pytester) -> Any:
    """Run a suite of one conformance test in this process."""

    def run(*options: str, arguments: str = '"reference", effort="quick"') -> pytest.RunResult:
        pytester.makepyfile(SUITE.format(arguments=arguments))
        # Warnings are errors here, but not in the suite of a user.
        return pytester.runpytest_inprocess("-W", "default", *options)

    return run


FEW_RUNS = """
import os
from drivegate.contracts.current.scenarios import fixed
from drivegate.gate import plan

every = fixed.fixed_scenarios
fixed.fixed_scenarios = lambda *given: every(*given)[::3]
plan.SHARDS = 1
os.cpu_count = lambda: 1
"""


@pytest.fixture
def few_runs(pytester: pytest.Pytester) -> None:
    """Let the process of a suite run a third of the fixed scenarios and one shard of drawn ones, in one worker."""
    pytester.makeconftest(FEW_RUNS)


def of_level(level: str) -> str:
    return next(check.id for check in CHECKS if check.level == level and check.subject == "candidate")


def text_of(result: pytest.RunResult) -> str:
    return "\n".join(result.outlines)


def counterexample_named(text: str) -> str:
    """The one file that a failing item names: in its failure, and where `CI` is set in pytest's summary too."""
    (file,) = set(re.findall(r"counterexample: (\S+)", text))
    return str(file)


def test_there_is_one_item_for_the_candidate_and_one_for_each_check(suite: Any, engine: FakeEngine) -> None:
    result = suite("--collect-only", "-q")
    collected = re.findall(r"test_conformance\[(.+)\]", text_of(result))
    assert collected == ["candidate", *(check.id for check in CHECKS)]
    assert engine.calls == [], "collecting must not check anything"


def test_all_items_share_one_check(suite: Any, engine: FakeEngine) -> None:
    suite("-q", arguments='"reference", effort="quick", seed=3').assert_outcomes(passed=1 + len(CHECKS))
    assert engine.calls == [("reference", "quick", 3)]


def test_another_seed_is_another_check(pytester: pytest.Pytester, engine: FakeEngine) -> None:
    pytester.makepyfile(
        test_one=SUITE.format(arguments='"reference", seed=1'),
        test_two=SUITE.format(arguments='"reference", seed=2'),
        test_three=SUITE.format(arguments='"reference", seed=1'),
    )
    pytester.runpytest_inprocess().assert_outcomes(passed=3 * (1 + len(CHECKS)))
    assert sorted(engine.calls) == [("reference", "default", 1), ("reference", "default", 2)]


def test_a_drive_is_taken_from_the_decorator_and_the_option_wins(
    suite: Any, engine: FakeEngine, pytester: pytest.Pytester
) -> None:
    paper = load_drive("paper-5-phase")
    for name in ("mine", "other"):
        drive = paper.replaced(name=name, resistance_ohm=0.1)
        (pytester.path / f"{name}.json").write_text(drive.to_json(), encoding="utf-8")
    suite(arguments='"reference", drive="mine.json"').assert_outcomes(passed=1 + len(CHECKS))
    suite("--drivegate-drive=other.json", arguments='"reference", drive="mine.json"')
    assert [options.drive and options.drive.name for options in engine.options] == ["mine", "other"]
    result = suite(arguments='"reference", drive="none.json"')
    result.stdout.fnmatch_lines(["*drivegate: *none.json does not exist*"])


def test_options_win_over_the_decorator(suite: Any, engine: FakeEngine) -> None:
    options = ("--drivegate-candidate=initial", "--drivegate-effort=nightly", "--drivegate-seed=9")
    suite(*options).assert_outcomes(passed=1 + len(CHECKS))
    assert engine.calls == [("initial", "nightly", 9)]


def test_a_required_check_that_fails_states_its_margin_and_how_to_replay(
    suite: Any, engine: FakeEngine, pytester: pytest.Pytester
) -> None:
    check = of_level("required")
    engine.verdicts[check] = "fail"
    result = suite()
    result.assert_outcomes(passed=len(CHECKS), failed=1)
    text = text_of(result)
    assert f"{check} fails (required): the message of {check}" in text
    assert "margin: -1.5" in text
    assert "Traceback" not in text
    file = counterexample_named(text)
    assert f"drivegate replay {file} --candidate reference" in text
    assert Path(file).is_relative_to(pytester.path / ".pytest_cache")
    document = json.loads(Path(file).read_text(encoding="utf-8"))
    assert (document["check"], document["candidate"]["name"]) == (check, "reference")


def test_a_check_that_does_not_apply_is_skipped_with_the_reason(suite: Any, engine: FakeEngine) -> None:
    check = of_level("required")
    engine.verdicts[check] = "not applicable"
    result = suite("-rs")
    result.assert_outcomes(passed=len(CHECKS), skipped=1)
    assert f"{check} is not applicable: the message of {check}" in text_of(result)


def test_an_advisory_check_that_is_not_met_is_a_warning(suite: Any, engine: FakeEngine) -> None:
    check = of_level("advisory")
    engine.verdicts[check] = "fail"
    result = suite()
    result.assert_outcomes(passed=1 + len(CHECKS), warnings=1)
    assert f"ConformanceWarning: {check} fails (advisory)" in text_of(result)


@pytest.mark.parametrize("verdict", ["inconclusive", "waiver expired", "unexpectedly passes"])
def test_nothing_but_a_pass_or_a_waiver_lets_a_required_check_pass(
    suite: Any, engine: FakeEngine, verdict: str
) -> None:
    check = of_level("required")
    engine.verdicts[check] = verdict
    result = suite()
    result.assert_outcomes(passed=len(CHECKS), failed=1)
    assert f"{check} {verdict} (required)" in text_of(result)


def test_a_waived_check_is_skipped(suite: Any, engine: FakeEngine) -> None:
    check = of_level("required")
    engine.verdicts[check] = "waived"
    result = suite("-rs")
    result.assert_outcomes(passed=len(CHECKS), skipped=1)
    assert f"{check} is waived: the message of {check}" in text_of(result)


def test_a_contested_failure_warns(suite: Any, engine: FakeEngine) -> None:
    check = of_level("required")
    engine.verdicts[check] = "contested"
    result = suite()
    result.assert_outcomes(passed=len(CHECKS) + 1, warnings=1)
    assert f"{check} contested (required)" in text_of(result)


def test_a_failure_of_the_plant_is_reported_as_drivegates_own(suite: Any, engine: FakeEngine) -> None:
    engine.verdicts[next(check.id for check in CHECKS if check.subject == "plant")] = "fail"
    assert "a fault of drivegate itself" in text_of(suite())


def test_waivers_and_corpus_beside_the_test_reach_the_engine(
    suite: Any, engine: FakeEngine, pytester: pytest.Pytester
) -> None:
    pytester.mkdir("found")
    check = of_level("required")
    waiver = {
        "check": f'"{check}"',
        "candidate": '"reference"',
        "reason": '"known"',
        "owner": '"somebody"',
        "expires": "2199-12-31",
        "margin": "-2.0",
    }
    lines = "\n".join(f"{key} = {value}" for key, value in waiver.items())
    pytester.path.joinpath("waivers.toml").write_text(f"schema = 1\n[[waiver]]\n{lines}\n", encoding="utf-8")
    suite(arguments='"reference", corpus="found", waivers="waivers.toml"')
    (options,) = engine.options
    assert options.corpus == ()
    assert [(waiver.check, waiver.owner) for waiver in options.waivers] == [(check, "somebody")]


def test_a_fault_fails_the_item_of_the_candidate(suite: Any, engine: FakeEngine) -> None:
    crash = Fault(FaultKind.CRASH, "ended by SIGSEGV", "step", "SIGSEGV", "", 3, 0.0015, None)
    engine.faults = (crash, replace(crash, step=4, time=0.002))
    result = suite()
    result.assert_outcomes(passed=len(CHECKS), failed=1)
    result.stdout.fnmatch_lines(["crash*: ended by SIGSEGV", "FAILED *test_conformance[[]candidate[]]*"])


def test_nothing_that_is_judged_reaches_the_log_as_a_command(suite: Any, engine: FakeEngine) -> None:
    hostile = "x\n::error::x\n  ##teamcity[x]\x1b[2J"
    crash = Fault(FaultKind.EXCEPTION, hostile, "step", "ValueError", hostile, 3, 0.0015, None)
    engine.faults, engine.message = (crash,), hostile
    required = [check.id for check in CHECKS if check.level == "required" and check.subject == "candidate"]
    engine.verdicts = dict(zip(required, ("fail", "waived", "contested"), strict=False))
    result = suite("-rA", "-o", "log_cli=true", "-o", "log_cli_level=INFO")
    result.assert_outcomes(passed=len(CHECKS) - 2, failed=2, skipped=1, warnings=1)
    assert text_of(result).count("##teamcity [x]") > 5, "the texts are not shown"
    assert commands_in("\n".join([*result.outlines, *result.errlines])) == []
    engine.error = InputError(hostile)
    assert commands_in(text_of(suite("-k", "candidate"))) == []
    assert commands_in(text_of(suite(arguments='"x##vso[y]/none.toml"'))) == []


@pytest.mark.parametrize(
    "error", [InputError("there is no method 'step'"), HarnessFault("it broke"), KeyError("x")]
)
def test_without_a_result_no_item_passes_and_one_states_why(
    suite: Any, engine: FakeEngine, error: Exception
) -> None:
    engine.error = error
    result = suite()
    result.assert_outcomes(failed=1 + len(CHECKS))
    assert text_of(result).count("was not judged, see [candidate]") >= len(CHECKS)
    assert len(engine.calls) == 1, "what failed once must not be tried again for every item"


def test_an_output_folder_is_used_and_written_again(
    suite: Any, engine: FakeEngine, pytester: pytest.Pytester
) -> None:
    check = of_level("required")
    engine.verdicts[check] = "fail"
    for _ in range(2):
        suite("--drivegate-output", "found", "-p", "no:cacheprovider")
    files = {path.relative_to(pytester.path).as_posix() for path in pytester.path.glob("found/**/*.json")}
    folder = "found/reference-quick-0"
    assert files >= {f"{folder}/result.json", f"{folder}/counterexamples/{check}.json"}
    assert {path.name for path in (pytester.path / "found").iterdir()} == {"reference-quick-0"}


def test_results_have_a_place_without_a_cache(suite: Any, engine: FakeEngine) -> None:
    engine.verdicts[of_level("required")] = "fail"
    file = counterexample_named(text_of(suite("-p", "no:cacheprovider")))
    assert Path(file).is_file()


def test_candidates_of_the_same_name_get_a_folder_each(pytester: pytest.Pytester, engine: FakeEngine) -> None:
    for folder in ("left", "right"):
        package = pytester.mkpydir(folder)
        (package / "mine.py").write_text(CONTROLLERS, encoding="utf-8")
        suite = SUITE.format(arguments='"mine.py:Raising"')
        (package / "test_mine.py").write_text(suite, encoding="utf-8")
    pytester.runpytest_inprocess("--drivegate-output", "found").assert_outcomes(passed=2 * (1 + len(CHECKS)))
    assert [specification for specification, _, _ in engine.calls] == [
        f"{pytester.path}/left/mine.py:Raising",
        f"{pytester.path}/right/mine.py:Raising",
    ], "a file's path starts from the folder of the test's file"
    assert len(list((pytester.path / "found").iterdir())) == 2


@pytest.mark.one_in(3)
@pytest.mark.parametrize(
    ("arguments", "options", "reason"),
    [
        ("", (), "names no candidate; give it one, or call pytest with --drivegate-candidate"),
        ('"missing.py:Mine"', (), "missing.py does not exist; name an existing file"),
        ('"reference"', ("--drivegate-candidate", "referense"), "the nearest known one is 'reference'"),
        (
            '"reference", effort="huge"',
            (),
            "the effort is 'huge', but must be one of quick, default, nightly",
        ),
        ('"reference"', ("--drivegate-effort", "huge"), "the effort is 'huge'"),
        ('"reference"', ("--drivegate-seed", "-1"), "the seed is -1, but must be 0 or more"),
        ('"reference", corpus="found"', (), "/found does not exist; name a folder of counterexamples"),
        ('"reference", waivers="missing.toml"', (), "missing.toml does not exist"),
    ],
)
def test_bad_usage_is_one_sentence_while_collecting(
    suite: Any, arguments: str, options: tuple[str, ...], reason: str
) -> None:
    result = suite(*options, arguments=arguments)
    result.assert_outcomes(errors=1)
    assert result.ret == pytest.ExitCode.INTERRUPTED
    sentences = [line for line in result.outlines if line.startswith("drivegate: ")]
    assert len(sentences) == 1, text_of(result)
    assert reason in sentences[0]
    assert "Traceback" not in text_of(result)


@pytest.mark.parametrize(
    ("test", "reason"),
    [
        (
            "@conformance_tests('reference')\ndef test_it(): pass",
            "test_it must take the argument 'conformance'",
        ),
        ("def test_it(conformance): pass", "needs the decorator drivegate.conformance_tests"),
    ],
)
def test_decorator_and_fixture_belong_together(pytester: pytest.Pytester, test: str, reason: str) -> None:
    pytester.makepyfile(f"from drivegate import conformance_tests\n{test}\n")
    result = pytester.runpytest_inprocess()
    assert result.ret != pytest.ExitCode.OK
    assert reason in text_of(result)


def test_the_plugin_is_light_where_it_is_not_used(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        """
        import sys

        def test_modules():
            heavy = {"numba", "numpy", "hypothesis", "pandas", "pydantic", "click", "matplotlib"}
            assert "drivegate.testing.plugin" in sys.modules
            assert heavy.isdisjoint(sys.modules)
        """
    )
    pytester.runpytest_subprocess("-p", "no:hypothesispytest").assert_outcomes(passed=1)


def test_importing_drivegate_brings_neither_pytest_nor_anything_heavy() -> None:
    heavy = ["pytest", "hypothesis", "numba", "numpy", "pandas", "pydantic", "click"]
    program = f"import sys, drivegate; print([name for name in {heavy} if name in sys.modules])"
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"


@pytest.mark.nightly
def test_the_items_of_the_reference_come_out_as_the_gate_has_them_for_real(
    pytester: pytest.Pytester, few_runs: None
) -> None:
    pytester.makepyfile(SUITE.format(arguments='effort="quick"'))
    result = pytester.runpytest_subprocess("--drivegate-candidate", "reference", "-rA", "-W", "default")
    (file,) = pytester.path.glob(".pytest_cache/d/drivegate/reference-quick-0/result.json")
    gate = json.loads(file.read_text(encoding="utf-8"))
    assert (gate["candidate"]["name"], gate["effort"], gate["seed"]) == ("reference", "quick", 0)
    ending = {"pass": "PASSED", "fail": "FAILED", "inconclusive": "FAILED"}
    expected = {
        check["id"]: "PASSED" if check["level"] == "advisory" else ending[check["verdict"]]
        for check in gate["checks"]
        if check["verdict"] != "not applicable"
    }
    seen = re.findall(r"^(PASSED|FAILED) \S+\[(\S+)\]", text_of(result), re.MULTILINE)
    assert {item: verdict for verdict, item in seen} == {"candidate": "PASSED"} | expected
    assert result.parseoutcomes()["skipped"] == len(CHECKS) - len(expected)


@pytest.mark.nightly
def test_the_initial_angle_alone_misses_the_optimum_for_real(
    pytester: pytest.Pytester, few_runs: None
) -> None:
    pytester.makepyfile(SUITE.format(arguments='"initial", effort="quick"'))
    result = pytester.runpytest_subprocess("-k", "CNV-2 or ADV-2 or candidate")
    result.assert_outcomes(passed=2, failed=1, deselected=len(CHECKS) - 2)
    result.stdout.fnmatch_lines(
        ["CNV-2 fails (required): *", "*margin: beyond -10", "FAILED *test_conformance[[]CNV-2[]]*"]
    )
    file = counterexample_named(text_of(result))
    assert json.loads(Path(file).read_text(encoding="utf-8"))["check"] == "CNV-2"


@pytest.mark.nightly
def test_a_controller_that_raises_fails_its_own_item_for_real(
    pytester: pytest.Pytester, few_runs: None
) -> None:
    pytester.makepyfile(controllers=CONTROLLERS)
    pytester.makepyfile(SUITE.format(arguments='"controllers.py:Raising", effort="quick"'))
    result = pytester.runpytest_subprocess()
    result.stdout.fnmatch_lines(["exception*: *what is this?*", "FAILED *test_conformance[[]candidate[]]*"])
    assert "ValueError" in text_of(result)
    assert 'raise ValueError("what is this?")' in text_of(result)
