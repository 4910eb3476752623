"""README's commands, as they are written: the cheap ones run, the others are ones that continuous integration runs."""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from tests.harness.ended import ended

from drivegate.candidates.resolution import resolve_candidate
from drivegate.commands.command_line import command_line
from drivegate.studies.campaign.file import read_campaign
from drivegate_cases.drive.drive_document import load_drive
from drivegate_lab.selftest.subjects import chosen_faults

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")
LINES = [
    line for block in re.findall(r"```shell\n(.*?)```", TEXT, flags=re.DOTALL) for line in block.splitlines()
]
OWN = [shlex.split(line, comments=True) for line in LINES if line.startswith("drivegate ")]
CHEAP = ("new", "diff", "drive")
"""What is run here; the others take minutes."""


@pytest.fixture(scope="module")
def fresh(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the cheap commands have been run, one after the other, as README has them."""
    folder = tmp_path_factory.mktemp("fresh")
    for name in ("examples", "docs"):
        (folder / name).symlink_to(ROOT / name)
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for line in LINES:
        if line.startswith(tuple(f"drivegate {name} " for name in CHEAP)):
            made = subprocess.run(
                ["bash", "-c", line],
                cwd=folder,
                env=os.environ | {"PATH": path},
                check=False,
                capture_output=True,
                text=True,
            )
            assert made.returncode == 0, f"{line}\n{made.stdout}{made.stderr}"
    return folder


def test_drivegate_is_installed_before_it_is_used() -> None:
    used = next(place for place, line in enumerate(LINES) if line.startswith("drivegate "))
    assert "python -m pip install ." in LINES[:used]


def test_what_sets_itself_up_is_run_word_for_word_by_continuous_integration() -> None:
    script = (ROOT / ".ci" / "run").read_text(encoding="utf-8")
    whole = [line for line in LINES if "&& tox" in line]
    assert len(whole) == 2
    assert [line for line in whole if f"({line})" not in script] == []
    configured = (ROOT / "tox.ini").read_text(encoding="utf-8")
    named = re.findall(r"tox -e (\w+)", TEXT)
    assert [name for name in named if f"[testenv:{name}]" not in configured] == []


def test_extras_are_those_of_the_package_and_bring_what_is_said() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = project["optional-dependencies"]
    rows = re.findall(r"^\| `(\w+)` \| .* \| `pip install (.+)` \|$", TEXT, re.MULTILINE)
    assert [name for name, _ in rows] == ["fmu", "parquet", "cluster"]
    for name, packages in rows:
        assert packages.split() == [re.split("[<>=]", needed)[0] for needed in extras[name]]
    installed = re.findall(r"pip install '\.\[(.+)\]'", TEXT)
    assert {name for names in installed for name in names.split(",")} <= set(extras)


FOUND = re.findall(r"^([a-z-]+) +([A-Z]+-\d) +(.+)$", TEXT, re.MULTILINE)


@pytest.mark.one_in(5)
@pytest.mark.parametrize(("name", "check", "measured"), FOUND, ids=[name for name, _, _ in FOUND])
def test_a_fault_is_found_as_it_is_shown(
    name: str,
    check: str,
    measured: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("drivegate.output.report_writers.entry_points", lambda group: [])
    printed = ended(capsys, "check", f"faulty:{name}", "--only", check, "--effort", "quick", "--workers", 1)
    assert f"  measured {measured}" in printed.out, printed.out + printed.err


def test_the_numbers_of_what_to_trust_are_those_of_the_tests() -> None:
    faults = re.search(r"catches (\d+) of (\d+) planted faults on `pm-ac-interior`", TEXT)
    assert faults is not None
    drive = load_drive("pm-ac-interior")
    tried = [fault for fault in chosen_faults((), drive) if fault.on(drive).idle_because is None]
    assert set(faults.groups()) == {str(len(tried))}, "drivegate selftest --drive pm-ac-interior"
    agreements = {
        folder: re.search(
            r"^AGREEMENT = (\S+)$",
            (ROOT / "tests" / "models" / folder / "plant" / "test_independent_solver.py").read_text(),
            re.MULTILINE,
        )
        for folder in ("pm_ac", "half_bridge", "star")
    }
    stated = re.search(r"within\s+(\S+) \(PM AC\), (\S+) \(decoupled phases\) and (\S+) \(star\)", TEXT)
    assert stated is not None
    assert list(stated.groups()) == [found[1] for found in agreements.values() if found]


@pytest.mark.parametrize("words", OWN, ids=" ".join)
def test_every_command_can_be_carried_out(
    words: list[str], fresh: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(fresh)
    with command_line.make_context("drivegate", words[1:]) as context:
        command = command_line.get_command(context, words[1])
        assert command is not None, f"there is no command {words[1]}"
        given = command.make_context(words[1], words[2:], parent=context).params
    named = [given.get("candidates", ()), [given.get(name) for name in ("first", "second", "candidate")]]
    for name in (name for names in named for name in names if isinstance(name, str)):
        resolve_candidate(name)
    for word in words[2:]:
        assert "/" not in word or (fresh / word).exists(), f"{word} is not there"
    if words[1] == "campaign":
        read_campaign(Path(words[2]))


def test_the_documentation_shows_the_campaign_of_the_examples() -> None:
    shown = (ROOT / "docs" / "campaigns.md").read_text(encoding="utf-8")
    assert (ROOT / "examples" / "campaign" / "spread.toml").read_text(encoding="utf-8") in shown
