"""Check of a run backward against its mirror image."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, at_most
from drivegate.contracts.duty.checks.judged import at, worst
from drivegate.contracts.duty.record import DutyRecord, DutyWindow

MIRROR_SHARE: Final = 0.02
"""Greatest difference of mean torque and current over rated torque and current limit (1)."""


def same_both_ways(record: DutyRecord) -> Margin | None:
    if record.mirror is None:
        return None
    # Either may end with a trip that is right.
    pairs = zip(record.steady, record.mirror.steady, strict=False)
    return worst(margin for window, forward in pairs for margin in _differences(record, window, forward))


def _differences(record: DutyRecord, window: DutyWindow, forward: DutyWindow) -> Iterator[Margin]:
    rated, limit = record.document.rating.rated_torque_nm, record.document.rating.current_limit_a
    measured = (
        ("torque", "N·m", window.torque, -forward.torque, rated),
        ("d current", "A", window.direct, forward.direct, limit),
        ("q current", "A", window.quadrature, -forward.quadrature, limit),
    )
    for name, unit, own, other, whole in measured:
        words = f"{name} {own:.4g} {unit}, {other:.4g} {unit} by the run forward, {at(window)}"
        yield Margin("SYM-1", at_most(abs(own - other), MIRROR_SHARE * whole), words)


SYM_1 = Check(
    id="SYM-1",
    families=("torque step", "weakening"),
    requirement=(
        "A run backward gives the mirror image of the run forward: mean torques differ by at most 2 % of "
        "rated torque, mean currents by 2 % of the current limit."
    ),
    level="advisory",
    limit="2 % of rated torque, and of the current limit",
    scenarios="steady torques backward on the nominal drive, run with speed, torque and initial angle negated as well",
    formula="1 - difference of mean torque or current between both runs / 2 % of rated torque or the current limit",
    why="A sign that holds one way only shows in nothing but the other way.",
    evaluate=same_both_ways,
)
