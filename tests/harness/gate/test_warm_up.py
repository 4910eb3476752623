"""Kernels are compiled once, and not at all where none are missing."""

from pathlib import Path
from types import SimpleNamespace

import pytest

from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.gate import warm_up


def test_no_kind_is_nothing_to_compile() -> None:
    warm_up.compile_kernels(())


def test_every_kind_of_drive_its_envelope_and_its_named_witnesses_are_compiled(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """What is compiled is recorded, since compiling it takes minutes."""
    monkeypatch.setenv("DRIVEGATE_CACHE", str(tmp_path))
    kinds, envelopes, ran = [], [], set()
    monkeypatch.setattr(warm_up, "compile_missing", lambda drives: kinds.extend(one.kind for one in drives))
    monkeypatch.setattr(warm_up, "envelope_of", lambda drive: envelopes.append(drive.kind))
    monkeypatch.setattr(
        warm_up, "own_candidate", lambda found: SimpleNamespace(name=found.name, controller=lambda: None)
    )
    monkeypatch.setattr(
        warm_up, "recorded", lambda loaded, scenario, _: ran.add((scenario.drive.kind, loaded.name))
    )
    warm_up.compile_for_first_check()
    assert kinds == envelopes == list(DRIVE_KINDS)
    assert {("half-bridge", "reference"), ("star", "reference"), ("pm-ac", "foc")} < ran
    assert ("pm-ac", "predictive-flux") in ran
    ran.clear()
    warm_up.compile_for_first_check()
    assert not ran, "what is kept is not compiled again"
