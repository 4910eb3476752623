"""Checks of installed packages: found by their entry points, judged like any other, and refused in one sentence."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from tests.harness.contracts.rows.synthetic import HELD_AT_SPEED, INTERIOR, record_with_run

from drivegate.candidates.declaration import NOTHING_DECLARED
from drivegate.checks.installed import installed_checks, installed_versions
from drivegate.contracts.catalogue import all_checks, check_of, checks_of
from drivegate_models.errors import InputError

EXAMPLE = Path(__file__).parents[3] / "examples" / "checks"
BROKEN = """
from dataclasses import replace
from efficiency_check import CHECK

def raising(record):
    raise ValueError("what it raises")

RAISING = replace(CHECK, check=replace(CHECK.check, id="OWN-2", evaluate=raising))
WRONG = replace(CHECK, check=replace(CHECK.check, id="OWN-3", evaluate=lambda record: 0.5))
TAKEN = replace(CHECK, check=replace(CHECK.check, id="OVC-1"))
NOTHING = 3
"""


def _forget() -> None:
    for cached in (installed_checks, installed_versions, all_checks):
        cached.cache_clear()


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Any]:
    """Install the example, with further entry points that a test names."""
    shutil.copy(EXAMPLE / "efficiency_check.py", tmp_path)
    (tmp_path / "broken_checks.py").write_text(BROKEN, encoding="utf-8")
    monkeypatch.syspath_prepend(str(tmp_path))

    def install(**points: str) -> None:
        metadata = tmp_path / "own-1.0.dist-info"
        metadata.mkdir()
        (metadata / "METADATA").write_text("Metadata-Version: 2.1\nName: own\nVersion: 1.0\n")
        lines = [f"{name} = {entry}" for name, entry in points.items()]
        (metadata / "entry_points.txt").write_text("\n".join(["[drivegate.checks]", *lines, ""]))
        _forget()

    yield install
    for name in ("efficiency_check", "broken_checks"):
        sys.modules.pop(name, None)
    monkeypatch.undo()
    _forget()


def test_the_example_is_a_check_of_its_contract(installed: Any) -> None:
    assert "OWN-1" not in all_checks()
    installed(efficiency="efficiency_check:CHECK")
    assert "OWN-1" in all_checks()
    assert "OWN-1" in {check.id for check in checks_of(INTERIOR, NOTHING_DECLARED)}
    assert installed_checks("current") == ()
    assert installed_versions() == {"own": "1.0"}
    check = check_of("duty", "OWN-1")
    power = INTERIOR.rating.rated_power_w
    for given, met in ((1.5 * power, True), (3.0 * power, False)):
        margin = check.evaluate(record_with_run(HELD_AT_SPEED, power, given))
        assert margin is not None
        assert margin.met is met
    assert check.evaluate(record_with_run(HELD_AT_SPEED, 0.1 * power, power)) is None


@pytest.mark.parametrize(
    ("entry", "check", "sentence"),
    [
        ("broken_checks:RAISING", "OWN-2", "failed (ValueError: what it raises)"),
        ("broken_checks:WRONG", "OWN-3", 'returned 0.5, but must return None or a Margin("OWN-3", …)'),
        ("broken_checks:TAKEN", "", "offers a check OVC-1, which there is already"),
        ("broken_checks:NOTHING", "", "names 3, but must name an InstalledCheck"),
        ("no_such_module:CHECK", "", "cannot be loaded (ModuleNotFoundError"),
    ],
)
def test_a_package_that_is_wrong_is_refused_in_one_sentence(
    installed: Any, entry: str, check: str, sentence: str
) -> None:
    installed(wrong=entry)

    def judge() -> None:
        known = all_checks()
        known[check].evaluate(record_with_run(HELD_AT_SPEED, 1.0, 1.0))

    with pytest.raises(InputError) as refused:
        judge()
    assert sentence in str(refused.value)
