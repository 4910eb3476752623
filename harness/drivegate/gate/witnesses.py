"""Run known good controllers in the scenarios of an accusation, to show that the requirement can be met there."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from drivegate.candidates.fault import Fault
from drivegate.checks.check import JudgedRun
from drivegate.checks.margin import Margin
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.contract import Witness
from drivegate.gate.shrinking import shown_by
from drivegate.gate.witness_runs import UNWITNESSED, met_by, witnesses_for, witnesses_on
from drivegate.results.document import CheckSection, WitnessedSection
from drivegate.results.result import NOT_WITNESSED, witness_in_words
from drivegate.results.verdict import considered
from drivegate.scenarios.simplification import size_of
from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario

MOST_SCENARIOS: Final = 4
"""Scenarios of a failed check that witnesses are run in before the failure is contested."""


@dataclass(frozen=True)
class Accusation:
    """A failed check of the candidate, and scenarios in which it fails."""

    check: str
    failures: tuple[tuple[Mapping[str, Any], Margin], ...]
    """The scenarios as plain data with the candidate's margins, the counterexample first."""

    def job(self) -> Job[Acquittal | Defence | Fault]:
        return Job(hear_witnesses, self)


@dataclass(frozen=True)
class Defence:
    """A witness has met the requirement, so the accusation stands."""

    witnessed: WitnessedSection
    place: int
    """Which of the accusation's scenarios it was run in."""


@dataclass(frozen=True)
class Acquittal:
    """No witness has met the requirement, so the accusation is contested."""

    witnesses: tuple[str, ...]


def accusations(
    outcomes: Iterable[CheckSection], runs: Sequence[JudgedRun], drive: DriveDocument
) -> list[Accusation]:
    """List the failed checks that a witness can speak on: not those of a repeated run, a script or a target."""
    if not witnesses_for(drive):
        return []
    return [
        Accusation(outcome.id, _failures(outcome, runs))
        for outcome in outcomes
        if outcome.verdict == "fail"
        and outcome.subject == "candidate"
        and outcome.id not in UNWITNESSED
        and outcome.counterexample is not None
        and outcome.counterexample.get("kind") != "script"
    ]


def _failures(
    outcome: CheckSection, runs: Sequence[JudgedRun]
) -> tuple[tuple[Mapping[str, Any], Margin], ...]:
    """Return the counterexample, the worst run, and of the other failed runs the simplest ones."""
    failed = [(run.scenario, margin) for margin, run in considered(outcome.id, runs) if not margin.met]
    failed.sort(key=lambda failure: (failure[0] != outcome.scenario, size_of(failure[0])))
    assert outcome.counterexample is not None, "only a failed check is an accusation"
    found = outcome.found
    if found is not None and found.margin is not None:
        margin = Margin(outcome.id, found.margin, found.measured)
        failed = [(outcome.counterexample, margin), *failed]
    chosen: list[tuple[Mapping[str, Any], Margin]] = []
    for failure in failed:
        if all(failure[0] != scenario for scenario, _ in chosen):
            chosen.append(failure)
    return tuple(chosen[:MOST_SCENARIOS])


def hear_witnesses(loaded: JudgedCandidate, accusation: Accusation) -> Acquittal | Defence:
    """Run witnesses in an accusation's scenarios until one meets the requirement; this is what the worker does.

    They are judged by the declaration of the candidate that is accused: by the same requirement in the same scenario.
    """
    declaration = loaded.candidate.declaration
    heard: tuple[Witness, ...] = ()
    for place, (mapping, _) in enumerate(accusation.failures):
        scenario = parse_document(mapping, Scenario, "the scenario")
        heard = witnesses_on(accusation.check, scenario.drive)
        if (found := met_by(accusation.check, scenario, declaration)) is not None:
            witness, margin = found
            witnessed = WitnessedSection.model_construct(
                name=witness.candidate,
                margin=margin.value,
                measured=margin.measured,
                knows_plant=witness.knows_plant,
            )
            return Defence(witnessed, place)
    return Acquittal(tuple(witness.candidate for witness in heard))


def with_witnesses(
    outcomes: Iterable[CheckSection],
    heard: Mapping[str, tuple[Accusation, Acquittal | Defence | Fault | None]],
    *,
    counts: bool = False,
) -> tuple[CheckSection, ...]:
    """Put what the witnesses did into the outcomes, None where they were not heard.

    A failure that is contested, or not witnessed yet, remains one where it `counts`.
    """
    return tuple(
        _with_witness(outcome, *heard[outcome.id], counts) if outcome.id in heard else outcome
        for outcome in outcomes
    )


def _with_witness(
    outcome: CheckSection, accusation: Accusation, ending: Acquittal | Defence | Fault | None, counts: bool
) -> CheckSection:
    if ending is None or isinstance(ending, Fault):
        sentence = f"{NOT_WITNESSED}: the check ended before known good controllers were run there"
        return _uncounted(outcome, sentence, NOT_WITNESSED, counts)
    if isinstance(ending, Defence):
        message = f"{outcome.message}; {witness_in_words(dict(ending.witnessed))}"
        made = outcome.model_copy(update={"witness": ending.witnessed, "message": message})
        return made if ending.place == 0 else shown_by(made, *accusation.failures[ending.place])
    names = ", ".join(ending.witnesses)
    return _uncounted(outcome, f"contested: none of {names} meets it there", "contested", counts)


def _uncounted(outcome: CheckSection, sentence: str, verdict: str, counts: bool) -> CheckSection:
    """Let a failure not count, unless the user has every failure without a witness count."""
    sentence += ", but --contested fail counts it" if counts else ", so it does not count"
    return outcome.model_copy(
        update={
            "verdict": outcome.verdict if counts else verdict,
            "message": f"{outcome.message}; {sentence}",
        }
    )
