"""Designs know no drive: one that differs in its units alone is controlled in the same way, bit for bit."""

import numpy as np
import pytest
from tests.harness.candidates.builtin.test_similar_drives import (
    AMPERES,
    PAPER,
    SPEED,
    in_other_units,
    step_of_load,
)

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.running import run_scenario
from drivegate_lab.candidates.families import DESIGN_NAMES


@pytest.mark.one_in(6)
@pytest.mark.parametrize(("speed", "share"), [(1.3, 1.0), (3.0, 1.0), (2.0, 0.3)])
@pytest.mark.parametrize("name", [f"design:{name}" for name in DESIGN_NAMES])
def test_a_drive_in_other_units_is_controlled_alike(name: str, speed: float, share: float) -> None:
    candidate = resolve_candidate(name)
    traces = [
        run_scenario(step_of_load(drive, speed, share, time), load_controller(candidate), trace_every=1).trace
        for drive, time in ((PAPER, 1.0), (in_other_units(PAPER), 1.0 / SPEED))
    ]
    assert np.ptp(traces[0]["current_reference_a"]) > 1.0, "a trace in which nothing happens proves nothing"
    for column, unit in (("advance_deg", 1.0), ("current_reference_a", AMPERES), ("speed_rpm", SPEED)):
        here, there = traces[0][column] * unit, traces[1][column]
        differing = np.nonzero(here != there)[0]
        assert not differing.size, (
            f"{column} differs from step {differing[0]} on, {here[differing[0]]!r} and {there[differing[0]]!r}: "
            f"{name} has a constant that belongs to one drive"
        )
