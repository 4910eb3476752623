"""The commands as functions: the same results, with tables and traces as data frames."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import drivegate
from drivegate.studies.check import check_all


def test_a_drive_has_single_values_replaced() -> None:
    drive = drivegate.load_drive("pm-ac-interior", {"machine.resistance_ohm": 0.9})
    assert drive.value("resistance_ohm") == 0.9
    with pytest.raises(drivegate.InputError, match="unknown"):
        drivegate.load_drive("pm-ac-interior", {"machine.resistence_ohm": 0.9})


def test_what_is_refused_is_raised() -> None:
    with pytest.raises(drivegate.InputError, match="is unknown"):
        drivegate.check("nobody")
    with pytest.raises(drivegate.InputError, match="is unknown"):
        drivegate.simulate("nobody", "lock-up")


MISUSES: dict[str, tuple[Callable[[], object], str]] = {
    "a table as a candidate": (lambda: drivegate.simulate([1.0], "lock-up"), "of the type list"),  # type: ignore[arg-type]
    "a class as a candidate": (lambda: drivegate.check(dict), "write a controller to a file first"),  # type: ignore[arg-type]
    "a table as a scenario": (
        lambda: drivegate.simulate("foc", {"torque_nm": 1.0}),
        "name of an included scenario",
    ),  # type: ignore[arg-type]
    "a result as a counterexample": (
        lambda: drivegate.replay(drivegate.CheckResult({}, None)),  # type: ignore[arg-type]
        "what counterexample",
    ),
    "no candidates": (drivegate.compare, "no candidate is named"),
    "a wrong one of several": (lambda: drivegate.compare("foc", "nobody"), "'nobody' is unknown"),
    "an effort": (lambda: drivegate.compare("foc", effort="fast"), "quick, default, nightly"),  # type: ignore[arg-type]
    "the effort of a check": (lambda: drivegate.check("foc", effort="fast"), "quick, default, nightly"),  # type: ignore[arg-type]
    "a level": (lambda: drivegate.check("foc", fail_on="all"), "required, advisory"),  # type: ignore[arg-type]
    "what is contested": (lambda: drivegate.check("foc", contested="no"), "pass, fail"),  # type: ignore[arg-type]
    "a seed in quotes": (lambda: drivegate.check("foc", seed="0"), "seed is '0'"),  # type: ignore[arg-type]
    "no processes": (lambda: drivegate.check("foc", workers=0), "workers is 0"),
    "no time": (lambda: drivegate.check("foc", max_time=0), "seconds above 0"),
    "time as text": (lambda: drivegate.check("foc", max_time="5min"), "seconds above 0"),  # type: ignore[arg-type]
    "a check": (lambda: drivegate.check("foc", only="DECC-1"), "the nearest is 'DEC-1'"),
    "the last report, which is not kept": (lambda: drivegate.check("foc", last_failed=True), "with output"),
    "requirements": (lambda: drivegate.check("foc", requirements="no.toml"), "no.toml does not exist"),
    "a number as a drive": (lambda: drivegate.check("foc", drive=5), "the drive is 5"),  # type: ignore[arg-type]
    "settings as words": (
        lambda: drivegate.load_drive("pm-ac-interior", ["resistance_ohm=1"]),  # type: ignore[arg-type]
        "must be a dictionary",
    ),
    "a key of a drive": (
        lambda: drivegate.load_drive("pm-ac-interior").value("resistence_ohm"),
        "the nearest known key is 'resistance_ohm'",
    ),
}


@pytest.mark.parametrize("misuse", MISUSES)
def test_what_makes_no_sense_is_refused_in_one_sentence(misuse: str) -> None:
    act, part = MISUSES[misuse]
    with pytest.raises(drivegate.InputError, match=part) as caught:
        act()
    assert "\n" not in str(caught.value)


def test_one_check_needs_no_list() -> None:
    # Nothing else is refused until the candidate is.
    with pytest.raises(drivegate.InputError, match="'nobody' is unknown"):
        drivegate.check("nobody", only="DEC-1,STP-1")


def test_a_check_takes_what_the_manifest_states(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    taken: list[Any] = []

    def stopped(*arguments: Any, **_options: Any) -> None:
        taken.extend(arguments)
        raise drivegate.InputError("enough is known")

    monkeypatch.setattr(check_all, "check_all", stopped)
    (tmp_path / "own.toml").write_text("schema = 1\n", encoding="utf-8")
    manifest = tmp_path / "candidate.toml"
    manifest.write_text(
        'schema = 1\nname = "mine"\nkind = "python"\nentry = "mine.py:Mine"\n'
        '[check]\ndrive = "pm-ac-surface"\neffort = "quick"\nrequirements = "own.toml"\n',
        encoding="utf-8",
    )
    with pytest.raises(drivegate.InputError, match="enough"):
        drivegate.check(manifest, seed=3)
    candidates, _folder, options, records, _part = taken
    assert candidates == [str(manifest)]
    assert (options.drive.name, options.effort, options.seed) == ("pm-ac-surface", "quick", 3)
    assert records.requirements == tmp_path / "own.toml"


def test_importing_loads_nothing_that_is_not_used() -> None:
    program = "import sys, drivegate; print([m for m in ('click', 'pandas', 'numba', 'pydantic') if m in sys.modules])"
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"
