"""The user's own requirements in a check: what they must be on a drive, and the scenarios that they bring."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.declaration import Declaration
from drivegate.checks.check import JudgedRun, ShardOutcome, judged
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.catalogue import all_checks, checks_of, contract_of, row_checks
from drivegate.contracts.contract import Contract
from drivegate.drives.running import recorded
from drivegate.results.document import CheckSection
from drivegate_cases.documents.wording import figure, nearest, one_line
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.requirements.file import OwnRequirements
from drivegate_cases.requirements.quantities import QUANTITIES, quantities_of
from drivegate_cases.requirements.row import Row
from drivegate_cases.requirements.vocabulary import TIME_UNITS
from drivegate_cases.scenario.scenario import LONGEST_CONTROL_PERIOD_S, Scenario
from drivegate_models.errors import InputError

_FAR: Final = 100.0
"""Limit over the size of its quantity on the drive beyond which its unit is doubted."""
_OF_DUTY: Final = {
    "step of torque reference": "torque_reference_nm",
    "failure": "torque_reference_nm",
    "release": "torque_reference_nm",
}
"""Events that only drives have whose controllers may follow a torque, with a signal that these have."""
_SETTLING_TIMES: Final = 100.0
"""Times over the drive's settling time from which a unit is doubted, unless a scenario of the user's lasts as long."""


def with_requirements(candidate: Candidate, own: OwnRequirements | None) -> Candidate:
    """Return a candidate with what a user requires of it; None leaves what its manifest names."""
    if own is None:
        return candidate
    return replace(candidate, declaration=replace(candidate.declaration, requirements=own))


def with_evidence(outcomes: Iterable[CheckSection], declaration: Declaration) -> tuple[CheckSection, ...]:
    """Add to each outcome the user's own identifiers of what the check is evidence for."""
    own = declaration.requirements
    stated = () if own is None else own.evidence
    return tuple(
        outcome.model_copy(
            update={"evidence_for": tuple(one.id for one in stated if outcome.id in one.checks)}
        )
        for outcome in outcomes
    )


def require_fitting(declaration: Declaration, drive: DriveDocument) -> None:
    """Refuse rows that no run on a drive could be judged by, or whose numbers are far off the drive's."""
    own = declaration.requirements
    if own is None:
        return
    for row in own.rows:
        for problem in _problems(row, contract_of(drive), drive):
            raise InputError(f"{own.where}: {row.id} {problem}")
    known = all_checks()
    for evidence in own.evidence:
        for check in evidence.checks:
            if check not in known:
                raise InputError(
                    f"{own.where}: the evidence {one_line(evidence.id)} names the check '{one_line(check)}', but must "
                    f"name one that there is, the nearest is '{nearest(check, known)}'"
                )
    scenarios = own.scenarios_on(drive) + own.drawn_on(drive, 2, 0)
    longest = max((scenario.duration_s for scenario in scenarios), default=0.0)
    for row in own.rows:
        for problem in _times(row, drive, longest):
            raise InputError(f"{own.where}: {row.id} {problem}")


def _problems(row: Row, contract: Contract, drive: DriveDocument) -> Iterator[str]:
    if row.id.upper() in all_checks():
        yield "has the identifier of a check of drivegate; give it another one"
    shown = contract.signal_names_on(drive)
    known = [each.name for each in quantities_of(shown)]
    if row.quantity not in known:
        yield (
            f"limits {row.quantity}, which runs on the drive '{drive.name}' do not show; the nearest that they show is "
            f"'{nearest(row.quantity, known)}'"
        )
    for name in row.when.ranges():
        if name not in shown and name != "link_voltage_v":
            yield f"has a state of {name}, which runs on the drive '{drive.name}' do not have"
    signal = _OF_DUTY.get(row.when.event or "")
    if signal is not None and signal not in shown:
        yield f"waits for a {row.when.event}, which cannot occur on a drive of the contract '{contract.name}'"
    if row.when.direction == "backward" and drive.one_way_because is not None:
        yield f"waits for a shaft that turns backward, which cannot occur, since {drive.one_way_because}"
    yield from _sizes(row, drive)


def _sizes(row: Row, drive: DriveDocument) -> Iterator[str]:
    """Find numbers that only another unit explains."""
    quantity = QUANTITIES[row.quantity]
    scale = quantity.scale(drive)
    limits = [abs(limit) for limit in (*row.limits, *(row.until or ())) if limit is not None]
    if row.statistic not in ("time until", "sign changes"):
        greatest = max(limits)
        if greatest > _FAR * scale:
            yield (
                f"has a limit of {figure(greatest)} {quantity.unit}, but the drive's own size of {row.quantity} is "
                f"{figure(scale)} {quantity.unit}, so the row would never fail; is it in another unit?"
            )


def _times(row: Row, drive: DriveDocument, longest_s: float) -> Iterator[str]:
    """Find times that no run lasts for; `longest_s` is the length of the longest scenario of the user's."""
    unit, (begin, _) = row.window
    settling = float(limits_of(drive).settling_s)
    start = begin * TIME_UNITS[unit].seconds(drive, drive.control_period_s or LONGEST_CONTROL_PERIOD_S)
    waited = row.limits[1] if row.statistic == "time until" else None
    for what, time in (("has a window that begins after", start), ("waits for at most", waited)):
        if time is not None and time > max(_SETTLING_TIMES * settling, longest_s):
            yield (
                f"{what} {figure(time)} s, but the drive settles in {figure(settling)} s and no run lasts as long; is "
                "it in another unit? Otherwise add a [[scenario]] that does"
            )


@dataclass(frozen=True)
class OwnRuns:
    """A scenario of the user's."""

    scenario: Scenario


def own_job(scenario: Scenario) -> Job[ShardOutcome]:
    return Job(run_own, OwnRuns(scenario))


def run_own(loaded: JudgedCandidate, plan: OwnRuns) -> ShardOutcome:
    """Run a scenario of the user's; the checks judge it too where they could have been run on it themselves."""
    scenario, declaration = plan.scenario, loaded.candidate.declaration
    fair = contract_of(scenario.drive).is_fair(scenario)
    checks = (
        checks_of(scenario.drive, declaration) if fair else row_checks(scenario.drive.contract, declaration)
    )
    run: JudgedRun = judged(recorded(loaded, scenario, loaded.controller()), checks)
    return ShardOutcome((run,))
