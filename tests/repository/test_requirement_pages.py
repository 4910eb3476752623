"""The pages on requirements: what they show is read by drivegate, and can be judged on the drive that they name."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from drivegate.candidates.declaration import Declaration
from drivegate.contracts.catalogue import contract_named, contract_of
from drivegate.drives.kinds import DEFAULT_DRIVES
from drivegate.gate.own_requirements import require_fitting
from drivegate.studies.new_requirements import requirements_toml
from drivegate_cases.drive.drive_document import drive_names, load_drive
from drivegate_cases.requirements.file import OwnRequirements, read_requirements
from drivegate_cases.requirements.quantities import QUANTITIES, quantities_of

DOCS = Path(__file__).parents[2] / "docs"
EXAMPLES = re.findall(
    r"```toml\n(.*?)```", (DOCS / "own_requirements.md").read_text(encoding="utf-8"), re.DOTALL
)


def read(text: str, folder: Path) -> OwnRequirements:
    file = folder / "requirements.toml"
    file.write_text(text, encoding="utf-8")
    return read_requirements(file)


def test_there_are_three_sentences() -> None:
    assert len(EXAMPLES) == 3


@pytest.mark.parametrize("place", range(3))
def test_an_example_is_judged_on_the_drive_of_the_page(place: int, tmp_path: Path) -> None:
    drive = load_drive(DEFAULT_DRIVES["duty"])
    own = read(EXAMPLES[place], tmp_path)
    require_fitting(Declaration(requirements=own), drive)
    for scenario in own.scenarios_on(drive):
        assert contract_of(drive).unseen(Declaration(), scenario).scenario.duration_s > 15.0


@pytest.mark.parametrize("name", drive_names())
def test_the_template_fits_every_included_drive(name: str, tmp_path: Path) -> None:
    drive = load_drive(name)
    own = read(requirements_toml(drive), tmp_path)
    require_fitting(Declaration(requirements=own), drive)
    assert [row.id for row in own.rows] == [f"REQ-{number}" for number in range(1, 6)]
    assert [scenario.name for scenario in own.scenarios_on(drive)] == ["standstill", "start"]


@pytest.mark.parametrize("name", ["current", "duty"])
def test_every_signal_of_a_contract_is_a_quantity(name: str) -> None:
    signals = contract_named(name).signal_names
    assert {signal for signal in signals if signal != "time_s"} <= set(QUANTITIES)
    assert set(quantities_of(signals)) != set(QUANTITIES.values())
