"""The kernels that a wheel carries."""

from types import SimpleNamespace

import pytest

from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.gate import packaged


def test_every_kind_of_drive_and_its_named_controllers_are_compiled(monkeypatch: pytest.MonkeyPatch) -> None:
    """What is compiled is recorded, since compiling it takes minutes."""
    kinds, ran = [], set()
    monkeypatch.setattr(packaged, "compile_missing", lambda drives: kinds.extend(one.kind for one in drives))
    monkeypatch.setattr(packaged, "envelope_of", lambda drive: None)
    monkeypatch.setattr(
        packaged, "own_candidate", lambda found: SimpleNamespace(name=found.name, controller=lambda: None)
    )
    monkeypatch.setattr(
        packaged, "recorded", lambda loaded, scenario, _: ran.add((scenario.drive.kind, loaded.name))
    )
    checks = packaged.compile_for_first_check()
    assert [drive for _, drive in checks] == [kind.default_drive for kind in DRIVE_KINDS.values()]
    assert kinds == list(DRIVE_KINDS)
    assert {("half-bridge", "reference"), ("star", "reference"), ("pm-ac", "foc")} < ran
