"""The efficiency of loaded runs: a ratio of two means, which no row of requirements states."""

from __future__ import annotations

from drivegate.checks.check import Check, Record
from drivegate.checks.installed import InstalledCheck
from drivegate.checks.margin import Margin, at_most
from drivegate.checks.means import exact_mean
from drivegate.contracts.catalogue import contract_of

LEAST = 0.5
"""Least efficiency in the last fifth of a run (1)."""
LOADED = 0.2
"""Share of rated power from which a run counts as loaded (1)."""


def efficiency(record: Record) -> Margin | None:
    """Judge the mean shaft power over the mean input power in the last fifth of a run; None where that is small."""
    # Known without the run: a run of another kind is not made for this check.
    if record.scenario.failure is not None:
        return None
    signals = contract_of(record.scenario.drive).signals(record.run)
    last = slice(-max(len(signals["time_s"]) // 5, 1), None)
    shaft = exact_mean(signals["torque_nm"][last] * signals["speed_rpm"][last] * (3.141592653589793 / 30.0))
    given = exact_mean(signals["input_power_w"][last])
    if shaft < LOADED * record.scenario.drive.rating.rated_power_w:
        return None
    loss, allowed = 1.0 - shaft / given, 1.0 - LEAST
    return Margin("OWN-1", at_most(loss, allowed), f"efficiency {100.0 * (1.0 - loss):.4g} %")


CHECK = InstalledCheck(
    contract="duty",
    check=Check(
        id="OWN-1",
        requirement="The efficiency of a loaded run is at least 50 %.",
        source="own requirement",
        limit="50 %",
        scenarios="the last fifth of runs whose shaft power is 20 % of rated power or more",
        formula="1 - loss / the loss that is allowed",
        why="The battery pays for every loss.",
        every_run=True,
        evaluate=efficiency,
    ),
)
