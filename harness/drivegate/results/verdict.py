"""From the margins of all runs to a verdict for each check and for the candidate."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, Final

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import Fault
from drivegate.candidates.step_costs import StepCosts, greatest_costs
from drivegate.checks.check import Check, JudgedRun, Nearness
from drivegate.checks.every_contract import costs_in_words, on_target
from drivegate.checks.margin import Margin
from drivegate.contracts.catalogue import all_checks, checks_of, on_drive
from drivegate.results.document import CheckSection, ComparisonSection
from drivegate.results.result import (
    MOST_MARGINS,
    NEVER_JUDGED,
    NOT_WITNESSED,
    STALE_WAIVERS,
    counted_levels,
)
from drivegate_cases.documents.document import parse_document
from drivegate_cases.documents.wording import counted, significant
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario

_NAMED: Final = 4
_DIGITS: Final = 6


def considered(check: str, runs: Iterable[JudgedRun]) -> list[tuple[Margin, JudgedRun]]:
    """Choose the runs that decide on a check."""
    judged = [(margin, run) for run in runs for margin in run.margins if margin.check == check]
    return [item for item in judged if not item[0].advisory] or judged


def check_outcomes(
    runs: Sequence[JudgedRun],
    declaration: Declaration,
    drive: DriveDocument,
    *,
    complete: bool,
    untimed_because: str = "",
) -> tuple[CheckSection, ...]:
    """Judge every check of a drive's contract over all runs.

    `untimed_because` states why the time of a candidate's steps is not judged, where it is not.
    """
    own = checks_of(drive, declaration)
    outcomes = (
        _outcome(on_drive(check, drive, declaration), runs, declaration, drive, complete) for check in own
    )
    return tuple(_without_time(outcome, runs, untimed_because) for outcome in outcomes)


def _nearest_in_words(check: Check, nearness: Nearness, runs: Sequence[JudgedRun]) -> str:
    """State that no run was judged, and which one came nearest."""
    scenarios = {
        str(run.scenario["name"]): run.scenario for run in runs if run.scenario.get("kind") != "script"
    }
    near = [
        (*nearness(parse_document(scenario, Scenario, "the scenario")), name)
        for name, scenario in scenarios.items()
    ]
    nearest = min(near, default=None)
    found = "" if nearest is None else f"; the nearest run is '{nearest[2]}': {nearest[1]}"
    return f"applies to {check.scenarios}, and there was none{found}"


def _without_time(outcome: CheckSection, runs: Sequence[JudgedRun], because: str) -> CheckSection:
    """State of a check of the time why it judged nothing, and what steps cost on a target."""
    known = all_checks().get(outcome.id)
    if not because or known is None or not known.volatile or outcome.runs:
        return outcome
    costs = _costs_on_target(runs)
    return outcome.model_copy(update={"verdict": "not applicable", "message": f"{because}{costs}"})


def _costs_on_target(runs: Sequence[JudgedRun]) -> str:
    costs = costs_in_words(greatest_costs(run.costs for run in runs))
    return f"; on the target, a step takes at most {costs}" if costs else ""


def machine_dependent(runs: Sequence[JudgedRun]) -> dict[str, dict[str, Any]]:
    """Return the numbers of the checks that depend on the machine."""
    numbers = {}
    for check in all_checks().values():
        items = [item for item in considered(check.id, runs) if item[0].is_timed] if check.volatile else []
        if items:
            margin, _ = min(items, key=lambda item: item[0].value)
            numbers[check.id] = {"margin": margin.value, "measured": margin.measured}
    return numbers


def costly_steps(runs: Sequence[JudgedRun], limits: StepCosts) -> dict[str, dict[str, Any]] | None:
    """Return the greatest costs of a step on the target, each with its limit and a run; None where none is counted."""
    found = {}
    for place, (name, limit) in enumerate(limits._asdict().items()):
        run = max(runs, key=lambda run: run.costs[place], default=None)
        if run is not None and run.costs[place]:
            found[name] = {
                "most": run.costs[place],
                "limit": limit or None,
                "scenario": str(run.scenario["name"]),
            }
    return found or None


def _outcome(
    check: Check,
    runs: Sequence[JudgedRun],
    declaration: Declaration,
    drive: DriveDocument,
    complete: bool,
) -> CheckSection:
    reason = check.reason_not_applicable(declaration, drive)
    items = considered(check.id, runs) if reason is None else []
    if not items and reason is None and complete and check.nearness is not None:
        return _made(check, NEVER_JUDGED, None, 0, _nearest_in_words(check, check.nearness, runs), None)
    if not items:
        verdict = "not applicable" if complete or reason is not None else "inconclusive"
        message = reason or f"applies to {check.scenarios}; there was none"
        return _made(check, verdict, None, 0, message, None)
    margin, run = min(items, key=lambda item: item[0].value)
    failed = [item for item in items if not item[0].met]
    if failed:
        verdict, summary = "fail", f"fails in {len(failed)} of {len(items)} runs"
    else:
        verdict = "pass" if complete else "inconclusive"
        summary = f"met in {'its only run' if len(items) == 1 else f'all {len(items)} runs'}"
    if margin.is_timed:
        # Which run was the worst, and by how much, another machine would find otherwise.
        message = f"{'not ' if failed else ''}met; the numbers depend on the machine and are with the times"
        return _made(check, verdict, None, len(items), message + _costs_on_target(runs), None)
    if check.volatile:
        check = on_target(check)
    if failed:
        summary = f"{summary}: {_names(run for _, run in failed)}"
    advised = [other for run in runs for other in run.margins if other.check == check.id and other.advisory]
    unmet = sum(not other.met for other in advised)
    if unmet and not margin.advisory:
        summary += f"; advisory: not met in {counted(unmet, 'run')} beyond what is required"
    margins = _spread([item.value for item, _ in items])
    return _made(check, verdict, margin, len(items), f"{margin.measured}; {summary}", run.scenario, margins)


def _spread(margins: Sequence[float]) -> tuple[float, ...]:
    """Order margins, and of very many take a part that keeps the least and the greatest."""
    ordered = sorted(significant(margin, _DIGITS) for margin in margins)
    if len(ordered) <= MOST_MARGINS:
        return tuple(ordered)
    step = (len(ordered) - 1) / (MOST_MARGINS - 1)
    return tuple(ordered[round(place * step)] for place in range(MOST_MARGINS))


def _names(runs: Iterable[JudgedRun]) -> str:
    names = list(dict.fromkeys(str(run.scenario["name"]) for run in runs))
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return ", ".join(names[:_NAMED]) + more


def _made(
    check: Check,
    verdict: str,
    margin: Margin | None,
    runs: int,
    message: str,
    scenario: dict[str, Any] | None,
    margins: tuple[float, ...] = (),
) -> CheckSection:
    return CheckSection.model_construct(
        id=check.id,
        requirement=check.requirement,
        source=check.source,
        subject=check.subject,
        level=check.level,
        limit=check.limit,
        verdict=verdict,
        margin=None if margin is None else margin.value,
        measured="" if margin is None else margin.measured,
        runs=runs,
        message=message,
        scenario=scenario,
        counterexample=scenario if verdict == "fail" else None,
        margins=margins,
        row=None if check.row is None else check.row.model_dump(mode="json", exclude_defaults=True),
    )


def candidate_verdict(
    outcomes: Sequence[CheckSection],
    faults: Sequence[Fault],
    baseline: Sequence[ComparisonSection] = (),
    *,
    fail_on: str = "required",
) -> tuple[str, int]:
    levels = counted_levels(fail_on)
    required = [outcome for outcome in outcomes if outcome.level in levels]
    found = {outcome.verdict for outcome in required}
    found |= {entry.verdict for entry in baseline if entry.level in levels} & {"fail"}
    # A waiver that is out of date is put right or removed, whatever its check's level.
    found |= {outcome.verdict for outcome in outcomes} & set(STALE_WAIVERS)
    if any(outcome.subject == "plant" and outcome.verdict == "fail" for outcome in required):
        return "harness fault", 3
    if faults:
        return faults[0].kind.value, 1
    for verdict in ("fail", *STALE_WAIVERS, NOT_WITNESSED, "inconclusive", NEVER_JUDGED):
        if verdict in found:
            return verdict, 1
    return next((verdict for verdict in ("contested", "waived") if verdict in found), "pass"), 0
