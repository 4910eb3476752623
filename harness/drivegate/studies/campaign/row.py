"""What is kept of one run of a campaign: a row of numbers and words, made where the run is judged."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees
from typing import Any, Final

from drivegate.candidates.fault import Fault, bounded_line
from drivegate.checks.catalogue import CHECKS
from drivegate.checks.check import judged_elsewhere
from drivegate.checks.determinism import DET_1
from drivegate.checks.margin import Margin
from drivegate.containment.messages import JudgedCandidate
from drivegate.drives.kinds import kind_of
from drivegate.drives.running import recorded
from drivegate.runs.record import RunRecord
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import HarnessFault
from drivegate_models.machine import ledger
from drivegate_models.units import RPM

PASS: Final = "pass"
FAIL: Final = "fail"
SET_ASIDE: Final = "set aside"
"""Verdict on a run that was not made, since no controller could do what it requires."""
NOT_JUDGED: Final = "not judged"
"""Verdict on a run to which none of the checks applies."""
HARNESS_FAULT: Final = "harness fault"
"""Verdict on a run in which the plant broke a rule that it guarantees."""
UNCOUNTED: Final = (SET_ASIDE, NOT_JUDGED, HARNESS_FAULT)
"""Verdicts on runs that say nothing about the candidate."""

JUDGED_CHECKS: Final = tuple(
    check.id
    for check in CHECKS
    if check.evaluate is not judged_elsewhere and not check.volatile and check is not DET_1
)
"""Checks that judge a run by itself, whatever the machine."""
OBSERVATIONS: Final = (
    "speed_final_rpm",
    "speed_error_worst_rpm",
    "current_sum_mean_a",
    "current_peak_a",
    "torque_mean_nm",
    "torque_ripple_worst_percent",
    "input_power_mean_w",
    "shaft_power_mean_w",
    "advance_mean_deg",
    "energy_residual",
)
"""What is observed of every run, in people's units."""

CHECKS_BY_ID: Final = {check.id: check for check in CHECKS}


@dataclass(frozen=True)
class RowRequest:
    """What a worker is to run.

    Attributes
    ----------
    scenario : Scenario
        The scenario.
    checks : tuple of str
        The checks that judge it.
    """

    scenario: Scenario
    checks: tuple[str, ...]


@dataclass(frozen=True)
class CampaignRow:
    """What a run came to.

    Attributes
    ----------
    verdict : str
        `PASS`, `FAIL`, one of `UNCOUNTED`, or the kind of the candidate's fault.
    message : str
        The fault in one line; empty without one.
    margins : dict
        Margin of each check that applies.
    measured : dict
        What each of them was measured as.
    advisory : tuple of str
        Checks among them that only advise in this run.
    observed : dict
        Values by the names in `OBSERVATIONS`; empty of a run that did not come to its end.
    """

    verdict: str
    message: str = ""
    margins: dict[str, float] | None = None
    measured: dict[str, str] | None = None
    advisory: tuple[str, ...] = ()
    observed: dict[str, float] | None = None


def run_row(loaded: JudgedCandidate, request: RowRequest) -> CampaignRow:
    """Make a run and judge it."""
    if not kind_of(request.scenario.drive).is_fair(request.scenario):
        return CampaignRow(SET_ASIDE)
    try:
        record = recorded(loaded, request.scenario, loaded.controller())
        return _judged(record, request.checks)
    except HarnessFault as fault:
        return CampaignRow(HARNESS_FAULT, bounded_line(str(fault)))


def fault_row(fault: Fault) -> CampaignRow:
    """Give the row of a run that the candidate's fault ended."""
    return CampaignRow(fault.kind.value, bounded_line(fault.message))


def _judged(record: RunRecord, checks: tuple[str, ...]) -> CampaignRow:
    margins: list[Margin] = []
    for name in checks:
        check = CHECKS_BY_ID[name]
        if check.reason_not_applicable(record.declaration, record.scenario.drive) is None:
            margin = check.evaluate(record)
            if margin is not None:
                margins.append(margin)
    return CampaignRow(
        _verdict(margins),
        margins={margin.check: margin.value for margin in margins},
        measured={margin.check: margin.measured for margin in margins},
        advisory=tuple(margin.check for margin in margins if margin.advisory),
        observed=_observed(record),
    )


def _verdict(margins: list[Margin]) -> str:
    unmet = [CHECKS_BY_ID[margin.check] for margin in margins if not margin.met and not margin.advisory]
    required = [check for check in unmet if check.level == "required"]
    if any(check.subject == "plant" for check in required):
        return HARNESS_FAULT
    if not margins:
        return NOT_JUDGED
    return FAIL if required else PASS


def _observed(record: RunRecord) -> dict[str, Any]:
    run, duration = record.run, record.scenario.duration_s
    windows = run.windows
    observed = {
        "speed_final_rpm": run.observed.speed_final * RPM,
        "current_sum_mean_a": run.totals[ledger.MAGNITUDE] / duration,
        "current_peak_a": run.totals[ledger.PEAK],
        "torque_mean_nm": run.totals[ledger.IMPULSE] / duration,
        "input_power_mean_w": run.observed.input_energy / duration,
        "shaft_power_mean_w": run.observed.shaft_energy / duration,
        "energy_residual": run.observed.exchange_error,
    }
    if windows:
        last = windows[-1]
        observed["speed_error_worst_rpm"] = max(window.speed_error for window in windows) * RPM
        observed["torque_ripple_worst_percent"] = max(window.ripple for window in windows) * 100.0
        observed["advance_mean_deg"] = degrees(last.angle)
    return {name: float(value) for name, value in observed.items()}
