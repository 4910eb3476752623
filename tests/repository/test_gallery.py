"""The gallery of faults: what it shows of each is what its counterexample gives."""

from __future__ import annotations

import re

import pytest
from gallery import FAULTS, PAGE, Fault, main, shown


def test_the_page_shows_every_fault_once() -> None:
    shown_checks = re.findall(r"^!\[([A-Z]+-\d)\]", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert shown_checks == [fault.check for fault in FAULTS]
    assert len(set(shown_checks)) == 13


@pytest.mark.one_in(10)
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.check)
def test_a_fault_fails_as_it_is_shown(fault: Fault) -> None:
    section, _ = shown(fault)
    assert section in PAGE.read_text(encoding="utf-8"), "run: python docs/gallery.py"
    assert fault.figure.stat().st_size < 60_000


def test_bad_usage_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--other"]) == 2
    assert capsys.readouterr().err.startswith("usage:")
