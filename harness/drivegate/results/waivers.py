"""Waivers: failures that somebody answers for, until a day and down to a margin."""

from __future__ import annotations

import os
from collections.abc import Collection, Iterable
from datetime import UTC, date, datetime
from pathlib import Path
from typing import Annotated, Any, Final

from pydantic import BeforeValidator, Field

from drivegate.checks.margin import margin_in_words
from drivegate.contracts.catalogue import all_checks
from drivegate.results.document import CheckSection
from drivegate.results.result import NOT_WITNESSED
from drivegate_cases.documents.document import Document, Section, read_document
from drivegate_cases.documents.wording import nearest, one_line, shown, shown_path
from drivegate_models.errors import InputError

DAY_VARIABLE: Final = "SOURCE_DATE_EPOCH"
"""Environment variable that stands for the present time (s since 1970), for results that can be made again."""

NEVER_WAIVED: Final = frozenset({"DET-1"})
"""Checks whose failure is a fault of the candidate."""

Text = Annotated[str, Field(min_length=1, max_length=500)]


def _day(value: Any) -> Any:
    """Take a day from JSON, which has no type for it, and refuse a time of day."""
    if isinstance(value, str):
        try:
            return date.fromisoformat(value)
        except ValueError as error:
            raise ValueError("must be a day such as 2030-12-31") from error
    if not isinstance(value, date) or isinstance(value, datetime):
        raise ValueError("must be a day such as 2030-12-31")
    return value


class Waiver(Section):
    """A failure of one check by one candidate that is accepted for a while."""

    id: Text | None = Field(default=None, description="your own identifier of the waiver, such as DEV-7")
    check: Text = Field(description="identifier of the check")
    candidate: Text = Field(description="name of the candidate")
    drive: Text | None = Field(
        default=None, description="name of the drive that it fails on, by default the paper's"
    )
    reason: Text = Field(description="reason why the failure is accepted")
    owner: Text = Field(description="person or team that answers for it")
    expires: Annotated[date, BeforeValidator(_day)] = Field(description="last day on which it holds")
    margin: float = Field(lt=0.0, description="margin below which it no longer holds, below 0")


class WaiverFile(Document):
    """A file of waivers."""

    waiver: tuple[Waiver, ...] = Field(default=(), description="list of waivers, each a table [[waiver]]")


def read_waivers(path: Path, candidates: Collection[str], own: Collection[str] = ()) -> tuple[Waiver, ...]:
    """Read a file of waivers for some candidates; `own` are the identifiers of the user's rows."""
    waivers = read_document(path, WaiverFile).waiver
    problems = [
        f"waiver {number} {problem}"
        for number, waiver in enumerate(waivers, start=1)
        for problem in _problems(waiver, waivers[: number - 1], candidates, own)
    ]
    if problems:
        raise InputError(f"{shown_path(path)}: {'; '.join(problems)}")
    return waivers


def _problems(
    waiver: Waiver, earlier: Iterable[Waiver], candidates: Collection[str], own: Collection[str]
) -> Iterable[str]:
    named = f"is for the check {shown(waiver.check)}"
    checks, known = all_checks(), [*all_checks(), *own]
    if waiver.check not in known:
        yield f"{named}, but must be for one that there is, the nearest is '{nearest(waiver.check, known)}'"
    elif waiver.check in checks and checks[waiver.check].subject == "plant":
        yield f"{named}, but must be for one of the candidate, since a failure of the plant is never accepted"
    elif waiver.check in NEVER_WAIVED:
        yield f"{named}, but must be for another one, since a candidate that is not deterministic is never accepted"
    elif waiver.check in checks and checks[waiver.check].volatile:
        yield f"{named}, but must be for another one, since its margin depends on the machine and it only advises"
    if waiver.candidate not in candidates:
        listed = ", ".join(f"'{one_line(name)}'" for name in candidates)
        yield f"is for the candidate {shown(waiver.candidate)}, but must be for one of those checked, {listed}"
    if any((waiver.check, waiver.candidate) == (other.check, other.candidate) for other in earlier):
        yield f"{named} and the candidate {shown(waiver.candidate)}, for which there is one before; keep one of them"


def under_waivers(
    outcomes: Iterable[CheckSection], candidate: str, waivers: Iterable[Waiver], today: date
) -> tuple[CheckSection, ...]:
    own = {waiver.check: waiver for waiver in waivers if waiver.candidate == candidate}
    return tuple(
        _waived(outcome, own[outcome.id], today) if outcome.id in own else outcome for outcome in outcomes
    )


def _waived(outcome: CheckSection, waiver: Waiver, today: date) -> CheckSection:
    verdict, sentence = outcome.verdict, f"{waiver.owner} has a waiver for it"
    is_unwitnessed = outcome.verdict == NOT_WITNESSED
    holds = outcome.margin is not None and outcome.margin >= waiver.margin
    if outcome.verdict == "pass":
        verdict = "unexpectedly passes"
        sentence = f"the waiver of {waiver.owner} is no longer needed; remove it"
    elif outcome.verdict == "fail" and today > waiver.expires:
        verdict = "waiver expired"
        sentence = f"the waiver of {waiver.owner} expired after {waiver.expires}"
    elif outcome.verdict == "fail" and not holds:
        found = "" if outcome.margin is None else f", not {margin_in_words(outcome.margin)}"
        sentence = f"the waiver of {waiver.owner} accepts margins down to {waiver.margin:g}{found}"
    elif outcome.verdict == "fail" or (is_unwitnessed and holds and today <= waiver.expires):
        verdict = "waived"
        sentence = f"waived by {waiver.owner} until {waiver.expires}: {waiver.reason}"
    message = f"{outcome.message}; {one_line(sentence)}"
    shown_keys = {"id", "drive", "reason", "owner", "expires", "margin"}
    table = waiver.model_dump(mode="json", include=shown_keys, exclude_none=True)
    return outcome.model_copy(update={"verdict": verdict, "message": message, "waiver": table})


def present_day() -> date:
    """Return which day it is, in UTC."""
    text = os.environ.get(DAY_VARIABLE)
    if text is None:
        return datetime.now(UTC).date()
    try:
        return datetime.fromtimestamp(int(text), UTC).date()
    except (ValueError, OverflowError, OSError) as error:
        raise InputError(
            f"the variable {DAY_VARIABLE} is {shown(text)}, but must be a whole number of seconds since 1970"
        ) from error
