"""From the margins of all runs to a verdict for each check and for the candidate."""

from __future__ import annotations

from collections.abc import Sequence

from drivegate.catalogue import CHECKS
from drivegate.check import Check
from drivegate.fault import Fault
from drivegate.margin import Margin
from drivegate.result import CheckOutcome
from drivegate.search_shard import JudgedRun

_NAMED = 4


def check_outcomes(runs: Sequence[JudgedRun], *, complete: bool) -> tuple[CheckOutcome, ...]:
    """Judge every check over all runs.

    Parameters
    ----------
    runs : sequence of JudgedRun
        The runs.
    complete : bool
        Whether all planned runs were made; if not, a check that has not failed is inconclusive.

    Returns
    -------
    tuple of CheckOutcome
        In the order of the catalogue.
    """
    return tuple(_outcome(check, runs, complete) for check in CHECKS)


def _outcome(check: Check, runs: Sequence[JudgedRun], complete: bool) -> CheckOutcome:
    judged = [(margin, run.scenario) for run in runs for margin in run.margins if margin.check == check.id]
    binding = [item for item in judged if not item[0].advisory]
    considered = binding or judged
    if not considered:
        verdict = "not applicable" if complete else "inconclusive"
        message = f"applies to {check.scenarios}; there was none"
        return _made(check, verdict, None, "", 0, message, None)
    margin, scenario = min(considered, key=lambda item: item[0].value)
    failed = [item for item in considered if not item[0].met]
    if failed:
        verdict = "fail"
        names = list(dict.fromkeys(str(item[1]["name"]) for item in failed))
        listed = ", ".join(names[:_NAMED]) + (
            f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
        )
        message = f"{margin.measured}; fails in {len(failed)} of {len(considered)} runs: {listed}"
    else:
        verdict = "pass" if complete else "inconclusive"
        message = f"{margin.measured}; met in all {len(considered)} runs"
    advised = [item for item in judged if item[0].advisory and not item[0].met]
    if advised and binding:
        message += f"; advisory: not met in {len(advised)} runs at light load"
    return _made(check, verdict, margin, margin.measured, len(considered), message, scenario)


def _made(
    check: Check,
    verdict: str,
    margin: Margin | None,
    measured: str,
    runs: int,
    message: str,
    scenario: dict[str, object] | None,
) -> CheckOutcome:
    return CheckOutcome(
        id=check.id,
        requirement=check.requirement,
        source=check.source,
        subject=check.subject,
        level=check.level,
        limit=check.limit,
        verdict=verdict,
        margin=None if margin is None else margin.value,
        measured=measured,
        runs=runs,
        message=message,
        scenario=scenario,
        counterexample=scenario if verdict == "fail" else None,
    )


def candidate_verdict(outcomes: Sequence[CheckOutcome], faults: Sequence[Fault]) -> tuple[str, int]:
    """Judge the candidate.

    Parameters
    ----------
    outcomes : sequence of CheckOutcome
        Every check's outcome.
    faults : sequence of Fault
        The candidate's faults.

    Returns
    -------
    verdict : str
        The first fault's kind, or ``fail``, ``inconclusive`` or ``pass``.
    exit_code : int
        3 when a plant check failed, 1 when the candidate does not pass, 0 when it does.
    """
    required = [outcome for outcome in outcomes if outcome.level == "required"]
    if any(outcome.subject == "plant" and outcome.verdict == "fail" for outcome in required):
        return "harness fault", 3
    if faults:
        return faults[0].kind.value, 1
    if any(outcome.verdict == "fail" for outcome in required):
        return "fail", 1
    if any(outcome.verdict == "inconclusive" for outcome in required):
        return "inconclusive", 1
    return "pass", 0
