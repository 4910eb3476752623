"""What commands print is inserted into the pages from runs; `docs/outputs.py --check` makes these, minutes at night.

Every day the pages are held against what is known without a run: names, commands, numbers of runs.
"""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from outputs import COMMANDS, FAULT, FAULTS, PLACE, fault_command, main, pages, renewed, selected

from drivegate.commands.command_line import command_line
from drivegate.contracts.catalogue import contract_of
from drivegate.gate.focus import Focus
from drivegate.gate.plan import planned_work
from drivegate.studies.campaign.file import read_campaign
from drivegate.studies.campaign.plan import CampaignPlan, planned
from drivegate_cases.drive.drive_document import load_drive

ROOT = Path(__file__).parents[2]
PLACES = {
    name: text.splitlines() for page in pages() for name, text in PLACE.findall(page.read_text("utf-8"))
}
CAMPAIGNS = [name for name, commands in COMMANDS.items() if "campaign" in commands[0]]


def plan_of(name: str) -> CampaignPlan:
    file = ROOT / COMMANDS[name][0].split()[2]
    return planned(read_campaign(file), file.parent)


def test_every_name_is_used_once_and_known() -> None:
    marked = re.findall(r"<!-- printed: (.*?) -->", "".join(page.read_text("utf-8") for page in pages()))
    assert sorted(marked) == sorted(PLACES) == sorted((FAULTS, *COMMANDS)), (
        "a block of text must follow each mark"
    )


def test_verdicts_of_checks_are_printed_and_not_written_by_hand() -> None:
    """A block of text with the row of a check, its margin among it, comes from a run."""
    for page in pages():
        by_hand = PLACE.sub("", page.read_text("utf-8"))
        for block in re.findall(r"```text\n(.*?)```", by_hand, re.DOTALL):
            assert not re.search(r"^ *[A-Z]{3}-\d +(required|advisory) ", block, re.MULTILINE), page.name


@pytest.mark.nightly
@pytest.mark.parametrize("name", [FAULTS, *COMMANDS])
def test_what_the_pages_show_is_what_the_commands_print_now(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["--check", name]) == 0, capsys.readouterr().out


@pytest.mark.parametrize("words", [command for commands in COMMANDS.values() for command in commands])
def test_the_commands_are_ones_that_there_are(words: str) -> None:
    _, name, *rest = shlex.split(words)
    with command_line.make_context("drivegate", [name, *rest]) as context:
        command = command_line.get_command(context, name)
        assert command is not None
        # A manifest that a command names is not there.
        command.make_context(name, rest, parent=context, resilient_parsing=True)


@pytest.mark.parametrize("name", CAMPAIGNS)
def test_the_runs_of_a_campaign_are_as_many_as_are_planned(name: str) -> None:
    plan, lines = plan_of(name), PLACES[name]
    candidates = [candidate.name for candidate in plan.candidates]
    titles = [line for line in lines if line.partition(":")[0] in candidates]
    assert [title.partition(":")[0] for title in titles] == candidates
    for title in titles:
        assert sum(map(int, re.findall(r"(\d+) \w", title))) == plan.campaign.runs_per_candidate
    of_points = [line for line in lines if re.match(r" +\w+ [\d.]+  ", line)]
    assert of_points, "each point of the grid has a row"
    for line in of_points:
        assert re.findall(r"\d+ of (\d+)", line) == [str(plan.campaign.draws)]
    known = {f"{key} {value:g}" for _, point in plan.places for key, value in point.items()}
    assert {re.split(r" {2,}", line.strip())[0] for line in of_points} == known


def test_the_runs_of_readme_s_check_are_those_that_are_planned_but_for_the_infeasible() -> None:
    rows = dict(
        re.findall(r"^ ([A-Z]+-\d) .* in all (\d+) runs$", "\n".join(PLACES["firmware"]), re.MULTILINE)
    )
    only = tuple(re.findall(r"--only (\S+)", COMMANDS["firmware"][-1])[0].split(","))
    assert tuple(rows) == only
    drive = load_drive("pm-ac-interior")
    focus = Focus(only, only).within(drive.contract, [check.id for check in contract_of(drive).checks])
    runs = sum(item.runs for item in planned_work("default", 0, drive=drive, focus=focus))
    assert 0.9 * runs <= int(rows["OVC-1"]) <= runs, (
        "OVC-1 judges every run; run: python docs/outputs.py firmware"
    )
    assert all(0 < int(made) <= int(rows["OVC-1"]) for made in rows.values())


def test_the_faults_have_a_command_each() -> None:
    for line in PLACES[FAULTS]:
        known = FAULT.match(line)
        assert known is not None, line
        assert (
            fault_command(known[1], known[2])
            == f"drivegate check faulty:{known[1]} --only {known[2]} --effort quick"
        )


def test_a_stale_output_is_noticed_and_renewed() -> None:
    printed = [" ROB-4   required   +0.9   fine", " OVC-1   required   +0.0213   205 runs", "next: more"]
    shown = [" OVC-1   required   +0.0496   199 runs", " …"]
    assert selected(shown, printed) == [" OVC-1   required   +0.0213   205 runs", " …"]
    with pytest.raises(SystemExit, match="ADV-2"):
        selected([" ADV-2   required"], printed)
    page = (
        "<!-- printed: firmware -->\n\n```text\n OVC-1   required   +0.0496   199 runs\n```\n\n<!-- end -->\n"
    )
    made = renewed(page, [], lambda name, lines: selected(lines, printed))
    assert made == page.replace("+0.0496   199", "+0.0213   205")
    assert renewed(made, [], lambda name, lines: selected(lines, printed)) == made
    assert renewed(page, ["pm-ac"], lambda name, lines: []) == page


def test_bad_usage_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["unheard-of"]) == 2
    assert capsys.readouterr().err.startswith("usage:")
