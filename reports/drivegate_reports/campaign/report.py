"""The page of a campaign, from its summary alone: how often each candidate breaks each requirement."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from shlex import quote
from typing import Any, Final

import numpy as np

from drivegate.studies.campaign.display import (
    interval_text,
    listed_points,
    probability_text,
    share_text,
    shown_margins,
)
from drivegate.studies.campaign.summary import KIND, SCHEMA
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import counted
from drivegate_reports.campaign import distributions
from drivegate_reports.campaign.distributions import CheckDistribution
from drivegate_reports.page.page import clean, plain_number, require_document
from drivegate_reports.page.style import PageFigure, page_figure

REPORT_FILE: Final = "campaign.html"
"""Name of the page in the campaign's folder."""
Row = Mapping[str, Any]


def write(document: Mapping[str, Any], folder: Path) -> Path:
    path = folder / REPORT_FILE
    write_atomically(path, page(document))
    return path


def page(document: Mapping[str, Any]) -> str:
    from drivegate_reports.page.page import page_text

    return page_text("campaign.html.j2", view=view_of(document))


@dataclass(frozen=True)
class ShareRow:
    name: str
    level: str
    requirement: str
    """The check, its level and what it requires; of a point its case and values in place of what is required."""
    share: str
    probability: str
    interval: str
    """How often it happened, of how many runs; the estimate, and its interval."""
    low: float
    high: float
    at: float | None
    """The interval and the estimate as percentages of a bar; None where there is no one probability."""
    tone: str
    """``pass``, ``caution`` or ``fail``."""
    margins: tuple[str, str, str] = ("–", "–", "–")
    """Least margin, that of 5 % of the runs, and the median."""


@dataclass(frozen=True)
class WorstRow:
    """A run that can be run again."""

    what: str
    """The check, or the kind of fault."""
    run: str
    facts: str
    """Its case and the values of its parameters."""
    margin: str
    measured: str
    """What was found."""
    tone: str
    """``pass``, ``caution`` or ``fail``."""
    command: str
    """What runs it again, in the folder of the page."""


@dataclass(frozen=True)
class CandidateView:
    name: str
    tone: str
    outcome: str
    sentence: str
    """Whether any of its runs failed: as a colour, in short, and with the probability."""
    rows: tuple[ShareRow, ...]
    """Any required check, then each check; below each the points at which that happened, where several were chosen."""
    worst: tuple[WorstRow, ...]
    """First of each kind of fault, then the worst run of each check, those that are violated first."""
    figure: PageFigure | None
    """The distribution of margins; None where no check decided."""


@dataclass(frozen=True)
class CampaignView:
    name: str
    confidence: str
    """Its name, and the confidence of the intervals."""
    facts: tuple[tuple[str, str], ...]
    candidates: tuple[CandidateView, ...]


def view_of(document: Row) -> CampaignView:
    require_document(document, KIND, SCHEMA, "the summary")
    confidence = f"{100.0 * document['confidence']:g} %"
    shares = document["quantiles"]
    candidates = tuple(
        _candidate(entry, specification, f"margins-{place}", shares, confidence)
        for place, (entry, specification) in enumerate(
            zip(document["candidates"], document["specifications"], strict=True), 1
        )
    )
    facts = (
        ("runs", str(document["runs"])),
        ("seed", str(document["seed"])),
        ("confidence of intervals", confidence),
        ("candidates", str(len(candidates))),
    )
    return CampaignView(clean(document["campaign"]), confidence, facts, candidates)


def _candidate(
    entry: Row, specification: str, identifier: str, shares: Sequence[float], confidence: str
) -> CandidateView:
    stated, checks = entry["not_passed"], entry["checks"]
    tone = "fail" if stated["violations"] else ("pass" if stated["runs"] else "quiet")
    outcome = ", ".join(f"{count} {clean(verdict)}" for verdict, count in entry["verdicts"].items())
    sentence = (
        f"{share_text(stated)} runs violate a required check or end in a fault{_likely(stated, confidence)}."
        if stated["runs"]
        else "No run says anything about this candidate."
    )
    everything = _share_row(
        "any", stated, "required", "A required check is violated, or a fault ends the run."
    )
    return CandidateView(
        name=clean(entry["name"]),
        tone=tone,
        outcome=outcome,
        sentence=sentence,
        rows=(
            everything,
            *_point_rows("any", stated),
            *(
                row
                for check in checks
                for row in (_check_row(check, shares), *_point_rows(check["id"], check))
            ),
        ),
        worst=tuple(_worst(entry, specification)),
        figure=_figure(entry, identifier),
    )


def _likely(stated: Row, confidence: str) -> str:
    if stated["interval"] is None:
        listed = bool(listed_points(stated))
        where = "the probability differs from point to point, see below" if listed else ""
        return (
            f"; {where or f'with {confidence} confidence the probability lies from {interval_text(stated)}'}"
        )
    return f": with {confidence} confidence the probability lies from {interval_text(stated)}"


def _point_rows(name: str, stated: Row) -> list[ShareRow]:
    return [_share_row(clean(name), point, "", clean(words)) for words, point in listed_points(stated)]


def _check_row(check: Row, shares: Sequence[float]) -> ShareRow:
    least, of_few, median = map(_number, shown_margins(shares, check))
    advised = check["advisory_runs"]
    level = clean(check["level"])
    if advised:
        level += f", advises alone in {counted(advised, 'run')}"
    return _share_row(clean(check["id"]), check, level, clean(check["requirement"]), (least, of_few, median))


def _share_row(
    name: str,
    stated: Row,
    level: str = "",
    requirement: str = "",
    margins: tuple[str, str, str] = ("–", "–", "–"),
) -> ShareRow:
    low, high = (100.0 * float(bound) for bound in stated["interval"] or (0.0, 1.0))
    probability = stated["probability"]
    return ShareRow(
        name=name,
        level=level,
        requirement=requirement,
        share=share_text(stated),
        probability=probability_text(probability),
        interval=interval_text(stated),
        low=low,
        high=high,
        at=None if probability is None else 100.0 * probability,
        tone=_tone(stated["violations"], level),
        margins=margins,
    )


def _tone(violations: int, level: str) -> str:
    if not violations:
        return "pass"
    return "caution" if level.startswith("advisory") else "fail"


def _worst(entry: Row, specification: str) -> list[WorstRow]:
    words = quote(specification)
    rows = [
        WorstRow(
            what=clean(fault["verdict"]),
            run=str(fault["run"]),
            facts="the first run that ended so",
            margin="–",
            measured="–",
            tone="fail",
            command=clean(f"drivegate simulate {words} --case {quote(fault['file'])}"),
        )
        for fault in entry["first_faults"]
    ]
    violated = [check for check in entry["checks"] if check["counterexample"] is not None]
    met = [check for check in entry["checks"] if check["worst_scenario"] is not None]
    for check in (*sorted(violated, key=lambda check: check["level"] != "required"), *met):
        counterexample = check["counterexample"]
        values = [f"{clean(key)} {value:g}" for key, value in check["worst_parameters"].items()]
        rows.append(
            WorstRow(
                what=clean(check["id"]),
                run=str(check["worst_run"]),
                facts="; ".join([clean(check["worst_case"]), *values]),
                margin=_number(check["worst_margin"]),
                measured=clean(check["worst_measured"]) or "–",
                tone=_tone(check["violations"], check["level"]),
                command=clean(
                    f"drivegate simulate {words} --case {quote(check['worst_scenario'])}"
                    if counterexample is None
                    else f"drivegate replay {quote(counterexample)} --candidate {words}"
                ),
            )
        )
    return rows


def _number(value: float | None) -> str:
    return "–" if value is None else plain_number(value)


def _figure(entry: Row, identifier: str) -> PageFigure | None:
    rows = [
        CheckDistribution(
            clean(check["id"], 40),
            # An infinite loss cannot be written as JSON.
            np.array([-np.inf if value is None else value for value in check["margins"]], dtype=np.float64),
            share_text(check),
        )
        for check in entry["checks"]
        if check["margins"]
    ]
    if not rows:
        return None
    title = f"{distributions.TITLE}: {clean(entry['name'], 80)}"
    words = distributions.alternative(rows), distributions.CAPTION
    return page_figure(identifier, title, lambda: distributions.draw(rows), *words)
