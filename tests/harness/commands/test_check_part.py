"""`drivegate check --only`, `-x`, `--last-failed` and `--quiet`: a tight loop around what fails."""

import json

import pytest

from drivegate.gate.focus import Focus

NO_REPORT = "there is no earlier result"


def test_checks_are_chosen_by_name_and_by_family(command, engine):
    assert command("check", "reference", "--only", "cnv-3,PWR", "--only", "CNV-2", "-x").code == 0
    assert engine.options.focus == Focus(
        ("PWR-1", "PWR-2", "CNV-2", "CNV-3"), ("CNV-3", "PWR", "CNV-2"), stop_at_first=True
    )


def test_what_failed_last_time_is_judged_alone_and_its_counterexample_comes_first(command, failing):
    command("check", "reference", "--output", "out")
    command("check", "reference", "--output", "out", "--last-failed")
    focus = failing.options.focus
    assert focus.only == ("CNV-1",), "CUR-1 failed too, but only advises"
    assert [stored.scenario.name for stored in focus.first] == ["lock-up"]
    command("check", "reference", "--output", "out", "--last-failed", "--fail-on", "advisory")


def test_after_a_pass_nothing_is_left_out(command, engine):
    command("check", "reference", "--output", "out")
    command("check", "reference", "--output", "out", "--last-failed")
    assert engine.options.focus == Focus()


def test_quiet_is_a_line_for_each_failure_and_one_with_verdict_time_and_report(command, failing):
    ended = command("check", "reference", "--quiet")
    assert (ended.code, "running" in ended.err) == (1, False), "progress is not quiet"
    *failed, last = ended.out.splitlines()
    assert last == (
        "reference: exception, 2 runs, 0 set aside as infeasible, 1 s, report: drivegate-report/report.html"
    )
    assert [line.split()[0].rstrip(":") for line in failed] == ["exception", "CNV-1", "CUR-1"], (
        "required ones come first"
    )
    assert failed[1].startswith("CNV-1 fail (required), margin "), failed[1]


def test_the_last_line_is_about_all_candidates_also_one_that_was_refused(command, engine):
    last = command("check", "reference", "nobody", "--output", "out").out.splitlines()[-1]
    assert last == "reference: pass; nobody: refused, 1 s, report: out"


def test_a_result_of_some_checks_says_so(command, engine, tmp_path):
    engine.focus = {"only": ["CNV-1"], "stopped_at_first": True}
    ended = command("check", "reference", "--only", "CNV-1")
    assert "reference: pass, only CNV-1, ended at the first failure after 2 runs" in ended.out
    assert "next: the whole check: drivegate check reference" in ended.out
    summary = (tmp_path / "drivegate-report" / "summary.md").read_text(encoding="utf-8")
    assert "only CNV-1" in summary


def test_the_report_of_another_candidate_is_no_earlier_one(command, refused, engine):
    command("check", "initial", "--output", "out")
    assert "is the result of 'initial', not of 'reference'" in refused(
        "check", "reference", "--output", "out", "--last-failed"
    )


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["reference", "--only", "CNX-2"], "no check 'CNX-2', the nearest is 'CNV-2'"),
        (["reference", "--only", ","], "--only names no check"),
        (["reference", "--last-failed"], NO_REPORT),
        (["reference", "initial", "--last-failed"], "takes one candidate"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(refused, engine, words, reason):
    assert reason in refused("check", *words)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("foc", "--only", "CNV-1"), "of the contract 'duty' are not judged by CNV-1, but by "),
        (("foc", "--only", "STP-1,CNV"), "of the contract 'duty' are not judged by CNV, but by "),
        (("foc", "--only", "ROB-1,ROB-4"), "of the contract 'duty' are not judged by ROB-1, but by "),
        (("reference", "--only", "STP-1"), "of the contract 'current' are not judged by STP-1, but by "),
        (
            ("reference", "--only", "FLO-1", "--effort", "quick"),
            "no named check applies, so nothing is judged",
        ),
    ],
)
def test_a_candidate_never_passes_by_checks_that_judge_nothing(command, tmp_path, words, reason):
    ended = command("check", *words, "--output", "out", "--workers", "1")
    assert ended.code == 2
    assert reason in ended.out + ended.err
    assert "running" not in ended.err, "it is refused before any work"
    assert not (tmp_path / "out").exists(), "there is no result of a check that judges nothing"


def test_a_family_stands_for_those_of_its_checks_that_the_contract_has():
    focus = Focus(("ROB-1", "ROB-4", "STP-1"), ("ROB", "STP-1"))
    assert focus.within("duty", ["STP-1", "ROB-4"]).only == ("ROB-4", "STP-1")


def test_a_check_ends_at_the_first_failure_for_real(command, little_shrunk, undrawn, tmp_path):
    words = ("published", "--effort", "quick", "--workers", "1", "--only", "CNV-1,CNV-2", "-x", "--json")
    document = command("check", *words).document
    assert (document["verdict"], document["exit_code"]) == ("fail", 1)
    assert document["focus"] == {"only": ["CNV-1", "CNV-2"], "stopped_at_first": True}
    assert {check["id"]: check["verdict"] for check in document["checks"]} == {
        "CNV-1": "fail",
        "CNV-2": "inconclusive",
    }, "what was not run to its end is no pass"
    stored = json.loads((tmp_path / "drivegate-report" / "result.json").read_text(encoding="utf-8"))
    assert document["runs"] == 2, (
        "the first job is the first two fixed scenarios, and the first of them fails"
    )
    assert stored["focus"] == document["focus"]
