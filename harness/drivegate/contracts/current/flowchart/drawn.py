"""Scripts drawn by Hypothesis, for searches that follow the paper's flowchart."""

from __future__ import annotations

import hashlib
import math

from hypothesis import strategies as st

from drivegate.candidates.declaration import FlowchartProfile
from drivegate.contracts.current.flowchart.scripts import Event, script_of
from drivegate.scenarios.drive_scale import scale_of, tidy
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.script import Script


def drawn_scripts(
    drive: DriveDocument, profile: FlowchartProfile, speed_range_rpm: tuple[float, float] | None
) -> st.SearchStrategy[Script]:
    """Draw scripts."""
    lowest, highest = speed_range_rpm or (0.0, math.inf)
    scale = scale_of(drive)
    step = scale.speed_step_rpm
    lowest = max(lowest, scale.speed(0.1))
    highest = max(min(highest, scale.highest_loaded_rpm), lowest)
    powers = st.sampled_from((0.0, -2.0, 2.0, -3.0, 3.0, -5.0, 5.0, -0.5, 0.5))
    errors = st.sampled_from((0.0, 0.0, 0.0, 0.0, 0.0, 0.5, -0.5, 1.5, -1.5))
    return st.builds(
        lambda slower, events: _drawn(drive, profile, tidy(highest - step * slower), events),
        st.integers(0, int((highest - lowest) // step)),
        st.lists(st.tuples(powers, errors).map(lambda pair: Event(*pair)), min_size=1, max_size=24),
    )


def _drawn(drive: DriveDocument, profile: FlowchartProfile, speed_rpm: float, events: list[Event]) -> Script:
    digest = hashlib.sha256(repr(events).encode()).hexdigest()[:8]
    name = f"drawn-{speed_rpm:g}rpm-{len(events) + 1}-rows-{digest}"
    return script_of(name, drive, profile, speed_rpm, events, "Changes of power and speed drawn at random.")
