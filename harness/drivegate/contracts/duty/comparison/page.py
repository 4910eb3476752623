"""The page of a comparison of controllers of duty ratios: its sections and what it says of the method."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Final

from drivegate.contracts.comparison import CHECKS, POINTS, RANKING, TIMING, Document, Section
from drivegate.contracts.drawings import MarkPanel, RowMarks


def rise_percent(row: Mapping[str, Any]) -> float | None:
    """Return a rise time over what is allowed (%); None where it is not known."""
    return None if row["rise_ms"] is None else 100.0 * float(row["rise_ms"]) / float(row["allowed_ms"])


def _value(key: str) -> Any:
    return lambda row: row[key]


STEADY_MARKS: Final = RowMarks(
    name="points",
    title="Steady states over the best possible",
    table=POINTS,
    load="reference_nm",
    load_label="torque asked for, or of the load (N·m), by speed",
    panels=(
        MarkPanel("loss above\nleast (%)", _value("loss_above_least_percent")),
        MarkPanel("current above\nleast (%)", _value("current_above_least_percent")),
        MarkPanel("ripple (% of\nrated torque)", _value("ripple_percent")),
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
            _value("overshoot_percent"),
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
        link="Steady states",
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
