"""The page of a comparison of controllers of duty ratios: its sections and what it says of the method."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Final

from drivegate.contracts.comparison import CHECKS, POINTS, RANKING, TIMING, Document, Section
from drivegate.contracts.drawings import MarkPanel, RowMarks

if TYPE_CHECKING:
    from pandas import DataFrame, Series


def rise_percent(steps: DataFrame) -> Series[float]:
    """Return the rise times over what is allowed (%)."""
    return 100.0 * steps["rise_ms"].astype(float) / steps["allowed_ms"]


STEADY_MARKS: Final = RowMarks(
    name="points",
    title="Steady states over the best possible",
    table=POINTS,
    load="reference_nm",
    load_label="torque asked for, or of the load (N·m), by speed",
    panels=(
        MarkPanel("loss above\nleast (%)", "loss_above_least_percent"),
        MarkPanel("current above\nleast (%)", "current_above_least_percent"),
        MarkPanel("ripple (% of\nrated torque)", "ripple_percent"),
    ),
    caption=(
        "Each column is an operating point, from the least speed to the highest and from light to heavy load; points "
        "that a candidate does not hold are left out. Ripple: greatest less least torque at any instant."
    ),
)
"""The operating points."""
STEP_MARKS: Final = RowMarks(
    name="steps",
    title="Steps of the torque reference",
    table="steps",
    load="after_nm",
    load_label="torque after the step (N·m), by speed",
    panels=(
        MarkPanel("rise time (%\nof allowed)", rise_percent, lambda _: 100.0),
        MarkPanel(
            "overshoot (%)",
            "overshoot_percent",
            lambda document: float(document["drive"]["overshoot_limit_percent"]),
        ),
    ),
    caption="Steps of the torque reference for which the voltage leaves room. Dashed: what STP-1 allows.",
)
"""The steps."""
SECTIONS: Final = (
    RANKING,
    Section(
        name="steady",
        title="Steady states",
        table=POINTS,
        drawings=(STEADY_MARKS,),
        folded="Every operating point",
    ),
    Section(
        name="steps",
        title="Steps of the torque reference",
        link="Steps",
        table="steps",
        drawings=(STEP_MARKS,),
        folded="Every step",
    ),
    CHECKS,
    TIMING,
)
"""The sections of the page."""


def method(_document: Document) -> Sequence[str]:
    """Return how the comparison was made."""
    return (
        "Every candidate runs the same torque references at the same constant speeds, from standstill to the highest; "
        "a steady state is the end of each.",
        "The least current and the least loss are the oracle's, for the torque of the candidate's own currents, within "
        "the limits of current and of undistorted voltage. Losses are those of copper and core, of the fundamental.",
        "Ripple: the exact plant plays the recorded commands once more over a sixth of an electrical period; the exact "
        "extremes of the torque are divided by rated torque.",
    )


def shown_facts(document: Document) -> Sequence[tuple[str, str]]:
    """Return what was followed; documents from before there was a choice follow torques."""
    drive = document["drive"]
    if document.get("reference") == "speed":
        return (
            ("reference", "speed, under a constant load"),
            ("held within", f"{drive['speed_tolerance_rpm']:.3f} rpm"),
        )
    return (
        ("reference", "torque, at held speeds"),
        ("held within", f"{drive['torque_tolerance_nm']:.3f} N·m"),
    )
