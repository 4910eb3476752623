"""What the laboratory adds is found by entry points, and refused in one sentence where it is not installed."""

from __future__ import annotations

import subprocess
import sys
from importlib.metadata import EntryPoint
from typing import Any

import pytest

from drivegate import laboratory
from drivegate.commands.command_line import COMMANDS, LABORATORY_COMMANDS

REFUSAL = (
    "belongs to drivegate's laboratory, the package drivegate_lab, which is not installed; "
    "install drivegate again, which brings it"
)
LEFT_OVER = "drivegate_lab.nothing:command"
"""An entry point whose package was removed, as its distribution still lists it."""


def offering(monkeypatch: pytest.MonkeyPatch, *values: str) -> None:
    def entry_points(group: str, name: str) -> list[EntryPoint]:
        return [EntryPoint(name, value, group) for value in values]

    monkeypatch.setattr(laboratory, "entry_points", entry_points)


@pytest.fixture(
    params=["no entry point", "an entry point of a removed package", "an entry point of a stranger"]
)
def without(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Take the laboratory away."""
    values = {"no": (), "of a removed package": (LEFT_OVER,), "of a stranger": ("json:loads",)}
    offering(
        monkeypatch,
        *next(values[key] for key in values if request.param.startswith(key) or key in request.param),
    )
    for name in [name for name in sys.modules if name.partition(".")[0] == "drivegate_lab"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "drivegate_lab", None)


@pytest.mark.usefixtures("without")
@pytest.mark.parametrize("name", sorted(LABORATORY_COMMANDS))
def test_a_command_of_the_laboratory_is_refused_without_it(refused: Any, name: str) -> None:
    assert refused(name) == f"error: the command '{name}' {REFUSAL}"


@pytest.mark.usefixtures("without")
@pytest.mark.parametrize("candidate", ["faulty:slow-currents", "design:sweep", "near:gain-doubled"])
def test_a_candidate_of_the_laboratory_is_refused_without_it(refused: Any, candidate: str) -> None:
    assert refused("check", candidate) == f"error: the candidate '{candidate}' {REFUSAL}"


def test_a_fault_inside_the_laboratory_is_not_taken_for_its_absence(monkeypatch: pytest.MonkeyPatch) -> None:
    offering(monkeypatch, "drivegate_laboratory_that_is_broken:command")
    monkeypatch.setattr(laboratory, "LABORATORY", "drivegate_laboratory_that_is_broken")
    assert laboratory.find_in_laboratory("any", "name") is None
    broken = type(sys)("drivegate_laboratory_that_is_broken")
    monkeypatch.setitem(sys.modules, broken.__name__, broken)
    with pytest.raises(AttributeError):
        laboratory.find_in_laboratory("any", "name")


def test_the_help_lists_the_commands_of_the_laboratory_without_importing_it() -> None:
    words = "import sys; from drivegate.commands.command_line import main\ntry: main(['--help'])\nfinally: "
    words += "assert not any(name.startswith('drivegate_lab') for name in sys.modules)"
    shown = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True).stdout
    assert all(COMMANDS[name] in " ".join(shown.split()) for name in LABORATORY_COMMANDS)
