"""The commands as functions: the same results, with tables and traces as data frames."""

from __future__ import annotations

import subprocess
import sys

import pytest

import drivegate


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


def test_importing_loads_nothing_that_is_not_used() -> None:
    program = "import sys, drivegate; print([m for m in ('click', 'pandas', 'numba', 'pydantic') if m in sys.modules])"
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"
