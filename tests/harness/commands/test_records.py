"""`drivegate check` with the records of a team: a corpus, waivers, and a baseline."""

import json
import xml.etree.ElementTree as ElementTree

import pytest

from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.results.document import ComparisonSection
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.errors import HarnessFault

SHORT = load_scenario("lock-up").replaced(name="from the corpus", duration_s=1.0)
COUNTEREXAMPLE = {
    "schema": 2,
    "kind": "counterexample",
    "check": "CNV-1",
    "candidate": {"name": "somebody's", "hash": ""},
    "scenario": SHORT.to_mapping(),
}
# One worker, since to start a process takes longer than all that it does here.
QUICK = ("check", "initial", "--effort", "quick", "--workers", "1", "--json")
WAIVER = """
schema = 1
[[waiver]]
check = "CNV-2"
candidate = "initial"
reason = "it does not search"
owner = "Ada <ada@example.org>"
expires = 2999-12-31
margin = -100.0
"""


@pytest.fixture
def corpus(tmp_path):
    """A folder with one counterexample."""
    folder = tmp_path / "corpus"
    folder.mkdir()
    (folder / "one.json").write_text(json.dumps(COUNTEREXAMPLE), encoding="utf-8")
    return folder


@pytest.fixture
def waivers(tmp_path):
    """A file with one waiver, for the failure of a candidate without a search."""
    file = tmp_path / "waivers.toml"
    file.write_text(WAIVER, encoding="utf-8")
    return file


def by_check(document):
    return {check["id"]: check for check in document["checks"]}


@pytest.fixture
def small(monkeypatch, little_shrunk):
    """Six fixed scenarios and a shard of one, so that a check in earnest takes seconds."""
    drive = load_drive("paper-5-phase")
    speeds = (600.0, 800.0, 1000.0, 1200.0, 1400.0, 1500.0)
    scenarios = tuple(
        steady_scenario(drive, speed, power_share=1.0, constant_power=False).replaced(
            name=f"at {speed:g} rpm"
        )
        for speed in speeds
    )
    monkeypatch.setattr("drivegate.contracts.current.contract.fixed_scenarios", lambda *_: scenarios)
    monkeypatch.setattr("drivegate.gate.plan.SHARDS", 1)
    monkeypatch.setattr("drivegate.gate.plan.EXAMPLES", {"quick": 1})


def test_a_waived_failure_passes_and_the_corpus_is_run(command, small, undrawn, corpus, waivers):
    ended = command(*QUICK, "--waivers", waivers, "--corpus", corpus)
    document = ended.document
    assert (ended.code, document["verdict"], document["exit_code"]) == (0, "waived", 0), ended.err
    assert document["corpus_runs"] == 1
    outcome = by_check(document)["CNV-2"]
    assert outcome["verdict"] == "waived"
    assert outcome["waiver"]["owner"] == "Ada <ada@example.org>"
    assert outcome["counterexample"] is not None, "what is waived stays broken, and is shown"
    names = [run["name"] for run in document["fixed"]]
    assert names == [f"at {speed} rpm" for speed in (600, 800, 1000, 1200, 1400, 1500)]


def test_a_waiver_that_has_expired_fails(command, small, one_page, waivers, monkeypatch):
    monkeypatch.setenv("SOURCE_DATE_EPOCH", str(10**11))
    ended = command(*QUICK, "--waivers", waivers)
    assert (ended.code, ended.document["verdict"]) == (1, "waiver expired")


def test_a_waiver_that_is_not_needed_fails(command, small, one_page, waivers):
    waivers.write_text(WAIVER + WAIVER.replace("schema = 1", "").replace("CNV-2", "CNV-1"), encoding="utf-8")
    ended = command(*QUICK, "--waivers", waivers)
    assert (ended.code, ended.document["verdict"]) == (1, "unexpectedly passes")


def test_a_result_is_its_own_baseline_and_a_better_one_fails_it(command, small, one_page, waivers, tmp_path):
    words = (*QUICK, "--waivers", waivers)
    first = command(*words).document
    assert first["baseline"] is None
    file = tmp_path / "drivegate-report" / "result.json"
    same = command(*words, "--baseline", file, "--output", "again")
    assert same.code == 0
    verdicts = {entry["check"]: entry["verdict"] for entry in same.document["baseline"]}
    assert verdicts["CNV-1"] == "no difference"
    assert verdicts["DET-1"] == "too few pairs", "only three of the scenarios are repeated"

    better = json.loads(file.read_text(encoding="utf-8"))
    for run in better["fixed"]:
        run["margins"]["CNV-1"] += 0.5
    (tmp_path / "better.json").write_text(json.dumps(better), encoding="utf-8")
    worse = command(*words, "--baseline", "better.json", "--output", "again")
    assert (worse.code, worse.document["verdict"]) == (1, "fail")
    lost = next(entry for entry in worse.document["baseline"] if entry["check"] == "CNV-1")
    assert (lost["verdict"], lost["pairs"]) == ("fail", 6)
    assert lost["median_change"] == pytest.approx(-0.5)
    assert lost["p_value"] == pytest.approx(1 / 64)


def test_a_comparison_that_fails_takes_no_result_with_it(command, engine, one_page, monkeypatch, tmp_path):
    """The result is reported before what follows from it."""

    def fails_at_the_end(candidate, options):
        yield from engine(candidate, options)
        raise HarnessFault(
            "the comparison with the baseline failed (ValueError: none), and the result has none"
        )

    monkeypatch.setattr("drivegate.gate.engine.check_candidate", fails_at_the_end)
    ended = command("check", "reference")
    assert ended.code == 3
    assert "the comparison with the baseline failed" in ended.err
    assert command("verify", tmp_path / "drivegate-report" / "result.json").code == 0


def test_the_engine_reports_a_result_that_cannot_be_compared(command, small, one_page, monkeypatch, tmp_path):
    words = (*QUICK, "--only", "ADV-2")
    assert command(*words).code == 0
    monkeypatch.setattr("drivegate.gate.engine.compared", lambda *_: 1 / 0)
    ended = command(*words, "--baseline", tmp_path / "drivegate-report" / "result.json", "--output", "again")
    assert (ended.code, ended.document["verdict"], ended.document["baseline"]) == (3, "pass", None)
    assert "ZeroDivisionError" in ended.err
    assert (tmp_path / "again" / "result.json").is_file()


def test_a_counterexample_is_replayed_as_it_was_found(command, small, one_page):
    """What a check found, replayed in a process of its own, gives the same margin to the last bit."""
    document = command(*QUICK, "--no-search").document
    found = by_check(document)["CNV-2"]["found"]
    ended = command("replay", "drivegate-report/counterexamples/CNV-2.json", "--json")
    assert ended.code == 1
    assert ended.document["now"]["margin"] == ended.document["then"]["margin"] == found["margin"]


def test_a_corpus_fails_a_candidate_that_breaks_it(command, small, one_page, tmp_path):
    """The corpus holds the one scenario in which the angle leaves its range."""
    source = """
from drivegate import Command
class Mine:
    def reset(self, nameplate): pass
    def step(self, sense): return Command(5.0, 0.0 if sense.speed_reference < 230.0 else 2.0)
"""
    (tmp_path / "mine.py").write_text(source, encoding="utf-8")
    (tmp_path / "corpus").mkdir()
    scenario = SHORT.replaced(initial_speed_rpm=2500.0, speed_rpm=((0.0, 2500.0),), name="fast")
    table = COUNTEREXAMPLE | {"check": "ADV-2", "scenario": scenario.to_mapping()}
    (tmp_path / "corpus" / "a.json").write_text(json.dumps(table), encoding="utf-8")
    check = ("check", "mine.py:Mine", "--effort", "quick", "--only", "ADV-2", "--workers", "1", "--json")
    words = (*check, "--max-time", "0.001")
    assert by_check(command(*words).document)["ADV-2"]["verdict"] == "inconclusive"
    words = (*check, "--corpus", "corpus")
    outcome = by_check(command(*words).document)["ADV-2"]
    assert outcome["verdict"] == "fail"
    assert "fails in 1 of 8 runs: fast;" in outcome["message"], "only the scenario of the corpus breaks it"


@pytest.fixture
def shown(command, engine, failing, tmp_path):
    """What every output shows of a waiver and a comparison."""
    verdicts = ("waived", "waiver expired", "unexpectedly passes", "pass", "inconclusive")
    waiver = {"reason": "known", "owner": "Ada", "expires": "2030-01-01", "margin": -2.0}
    engine.outcomes = tuple(
        one.model_copy(
            update={
                "verdict": verdict,
                "level": "required",
                "waiver": waiver,
                "message": f"{verdict} by Ada",
            }
        )
        for one, verdict in zip(engine.outcomes, verdicts, strict=True)
    )
    engine.faults = ()
    engine.verdict, engine.exit_code = "waiver expired", 1
    fallen = {"pairs": 9, "median_change": -0.2, "p_value": 0.002, "verdict": "fail"}
    engine.baseline = (
        ComparisonSection(check="CNV-1", level="required", message="the margin fell | much", **fallen),
        ComparisonSection(check="CUR-1", level="advisory", message="the margin fell", **fallen),
    )
    engine.corpus_runs = 3
    ended = command("check", "reference")
    return ended, tmp_path / "drivegate-report"


def test_the_terminal_shows_waivers_and_comparisons(shown):
    ended, _ = shown
    assert ended.code == 1
    assert "CNV-1 fails, waived (required)" in ended.out
    assert "2 runs, 3 of them from the corpus, 0 set aside" in ended.out
    assert "against the baseline" in ended.out
    assert "the margin fell | much" in ended.out


def test_junit_shows_waivers_and_comparisons(shown):
    _, folder = shown
    cases = {case.get("name"): case for case in ElementTree.parse(folder / "junit.xml").iter("testcase")}
    kinds = {name: [child.tag for child in case] for name, case in cases.items()}
    assert kinds == {
        "CNV-1": ["skipped"],
        "CNV-2": ["failure"],
        "CPW-1": ["failure"],
        "RIP-1": ["system-out"],
        "CUR-1": ["error"],
        "CNV-1 against the baseline": ["failure"],
        "CUR-1 against the baseline": ["system-out"],
    }
    assert "waived by Ada" in cases["CNV-1"].find("skipped").get("message")
    assert cases["CNV-1"].get("classname") == "reference.CNV"
    times = [float(case.get("time", "0")) for case in cases.values()]
    assert sum(times) == pytest.approx(1.0, abs=0.01), (
        "the times of the cases must add up to the time of the suite"
    )


def test_markdown_shows_waivers_and_comparisons(shown):
    _, folder = shown
    summary = (folder / "summary.md").read_text(encoding="utf-8")
    assert "| CNV-1 | required | waived | -1.5 | waived by Ada |" in summary
    assert "## Against the baseline" in summary
    assert summary.index("## What failed") < summary.index("| check |"), "what failed leads"
    assert "    drivegate replay counterexamples/CNV-1.json --candidate reference\n" in summary
    assert "| CNV-1 | required | fail | the margin fell \\| much |" in summary


def test_a_number_that_depends_on_the_machine_is_shown_from_the_times(command, engine, tmp_path):
    engine.outcomes = (
        engine.outcomes[0].model_copy(update={"margin": None, "measured": "", "scenario": None}),
    )
    engine.timing = {"seconds": 1.0, "checks": {"CNV-1": {"margin": 0.875, "measured": "12 µs"}}}
    assert "+0.875" in command("check", "reference").out
    assert "+0.875" in (tmp_path / "drivegate-report" / "summary.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        (WAIVER, "is for the candidate \"initial\", but must be for one of those checked, 'reference'"),
        (WAIVER.replace("initial", "reference").replace("CNV-2", "CNV-7"), "the nearest is 'CNV-"),
        (WAIVER.replace("initial", "reference").replace("CNV-2", "PWR-1"), "plant"),
        (WAIVER.replace("2999-12-31", "31.12.2999"), "not well-formed TOML"),
        ("schema = 5", "schema 5 is newer"),
    ],
)
def test_bad_waivers_are_refused_before_anything_runs(refused, engine, waivers, text, reason):
    waivers.write_text(text, encoding="utf-8")
    assert reason in refused("check", "reference", "--waivers", waivers)
    assert engine.options is None, "nothing may run before the files are read"


def test_waivers_of_one_of_several_candidates_are_fine(command, engine, waivers):
    assert command("check", "reference", "initial", "--waivers", waivers).code == 0
    assert [waiver.candidate for waiver in engine.options.waivers] == ["initial"]


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("{", "one.json is not well-formed JSON"),
        (json.dumps(COUNTEREXAMPLE | {"schema": 7}), "schema 7 is newer"),
        (json.dumps(COUNTEREXAMPLE | {"check": "nothing"}), "must be one of the checks"),
        (json.dumps(COUNTEREXAMPLE | {"scenario": "lock-up"}), "not a name"),
    ],
)
def test_a_bad_corpus_is_refused_before_anything_runs(refused, engine, corpus, text, reason):
    (corpus / "one.json").write_text(text, encoding="utf-8")
    assert reason in refused("check", "reference", "--corpus", corpus)
    assert engine.options is None, "nothing may run before the files are read"


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["--corpus", "nowhere"], "--corpus nowhere does not exist"),
        (["--waivers", "nowhere.toml"], "nowhere.toml does not exist"),
        (["--baseline", "nowhere.json"], "nowhere.json does not exist"),
        (["--baseline", "corpus/one.json"], 'is of kind "counterexample"'),
        (["--baseline", "corpus"], "corpus is a folder; name a TOML or JSON file in it"),
    ],
)
def test_records_that_are_not_there_are_refused(refused, engine, corpus, words, reason):
    assert reason in refused("check", "reference", *words)
