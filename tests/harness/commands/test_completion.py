"""What a shell completes, as click asks for it."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest
from click.shell_completion import ShellComplete, get_completion_class

from drivegate.commands.command_line import COMMANDS, command_line
from drivegate.contracts.catalogue import all_checks
from drivegate_cases.drive.drive_document import drive_names
from drivegate_cases.scenario.scenario import scenario_names


def completed(*words: str) -> list[str]:
    """Complete the last word."""
    *before, incomplete = words
    shell = ShellComplete(command_line, {}, "drivegate", "_DRIVEGATE_COMPLETE")
    return [item.value for item in shell.get_completions(before, incomplete) if item.type == "plain"]


def test_names_of_commands_drives_scenarios_and_checks(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert completed("") == [*COMMANDS, "help"]
    assert completed("check", "--drive", "pm-") == [name for name in drive_names() if name.startswith("pm-")]
    assert completed("simulate", "foc", "--case", "") == list(scenario_names())
    assert completed("checks", "FW") == sorted(name for name in all_checks() if name.startswith("FW"))
    assert completed("check", "--only", "STP-1,MT") == ["STP-1,MTP-1"]


def test_help_is_completed_by_commands_and_checks(capfd):
    assert completed("help", "che") == ["check", "checks"]
    assert completed("help", "FWK-") == ["FWK-1", "FWK-2", "FWK-3"]
    assert capfd.readouterr() == ("", ""), "a shell shows what is printed amid the line"


def test_candidates_are_names_and_files_of_a_kind(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "src").mkdir()
    for name in ("candidate.toml", "notes.md", "src/firmware.c"):
        (tmp_path / name).touch()
    assert completed("check", "c") == ["candidate.toml"]
    assert completed("check", "fo")[:2] == ["foc", "foc-mtpa"]
    assert completed("simulate", "src/") == ["src/firmware.c"]
    assert completed("check", "--drive", "c") == ["candidate.toml"]
    assert completed("check", "nothing-like-it") == [], "the shell completes files"


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_shell_gets_a_script(shell):
    found = get_completion_class(shell)
    assert found is not None
    assert "_DRIVEGATE_COMPLETE" in found(command_line, {}, "drivegate", "_DRIVEGATE_COMPLETE").source()


def test_fish_takes_a_comma_for_a_part_of_the_value():
    found = get_completion_class("fish")
    assert found is not None
    source = found(command_line, {}, "drivegate", "_DRIVEGATE_COMPLETE").source()
    assert 'string split --max 1 "," $completion' in source


def test_a_real_shell_completes_a_drive(tmp_path):
    program = tmp_path / "drivegate"
    program.write_text(
        f"#!{sys.executable}\nfrom drivegate.commands.command_line import main\nmain()\n", encoding="utf-8"
    )
    program.chmod(0o755)
    words = (
        'eval "$(_DRIVEGATE_COMPLETE=bash_source drivegate)"; COMP_WORDS=(drivegate check --drive pm-ac-su); '
        'COMP_CWORD=3; _drivegate_completion drivegate; echo "${COMPREPLY[@]}"'
    )
    environment = os.environ | {"PATH": f"{tmp_path}:{os.environ['PATH']}"}
    ended = subprocess.run(
        ["bash", "-c", words], env=environment, capture_output=True, text=True, check=False
    )
    assert ended.stdout.split() == ["pm-ac-surface"], ended.stderr
