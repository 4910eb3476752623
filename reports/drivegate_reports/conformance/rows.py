"""Checks and faults of a result document as rows of the conformance page."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import median
from typing import Any, Final

from drivegate.checks.margin import margin_in_words
from drivegate.output.result_file import counterexample_name
from drivegate.output.wording import scenario_in_short
from drivegate.results.result import witness_in_words
from drivegate_reports.page.page import LONGEST_BLOCK, clean, plain_data

TONES: Final = {
    "pass": "pass",
    "contested": "caution",
    "waived": "caution",
    "waiver expired": "fail",
    "unexpectedly passes": "caution",
    "inconclusive": "caution",
    "not applicable": "quiet",
    "no difference": "quiet",
    "too few pairs": "quiet",
}
"""Tone of each verdict; of any other it is ``fail``."""


@dataclass(frozen=True)
class MarginBar:
    """A margin as a bar from the middle of a box of 100 by 10, to the right where it is met."""

    start: float
    width: float
    """Of the bar, in the box's units."""


@dataclass(frozen=True)
class CheckRow:
    """A check as the page shows it; texts are bounded and printable.

    Attributes
    ----------
    id, requirement, source, subject, level, verdict, measured, limit : str
        As in the result document.
    message : str
        The outcome, without the measured value that is shown beside it.
    tone : str
        ``pass``, ``fail``, ``caution`` or ``quiet``.
    margin : str
        The margin, or a dash.
    bar : MarginBar or None
        The margin as a bar.
    runs : int
        Number of runs.
    worst : str
        The counterexample, or the worst scenario, in one line; empty where there is neither.
    scenario : str
        The same as plain data.
    file : str
        The counterexample's file beside the page; empty where the check did not fail.
    found : str
        What the counterexample gave; empty where there is none.
    spread : str
        Least, median and greatest margin of all runs; empty where they are not kept.
    witness : str
        The known good controller that meets the requirement in the counterexample; empty where there is none.
    waiver : tuple of tuple of str
        Names and values of the waiver; empty where there is none.
    """

    id: str
    requirement: str
    source: str
    subject: str
    level: str
    verdict: str
    tone: str
    margin: str
    margin_value: float | None
    bar: MarginBar | None
    measured: str
    limit: str
    runs: int
    message: str
    worst: str
    scenario: str
    file: str
    found: str
    spread: str
    witness: str
    waiver: tuple[tuple[str, str], ...]


@dataclass(frozen=True)
class ComparisonRow:
    """A check against the baseline as the page shows it; texts are bounded and printable.

    Attributes
    ----------
    check, level, verdict, message : str
        As in the result document.
    tone : str
        ``pass``, ``fail``, ``caution`` or ``quiet``.
    """

    check: str
    level: str
    verdict: str
    tone: str
    message: str


@dataclass(frozen=True)
class ShownFault:
    """A fault as the page shows it; texts are bounded and printable."""

    kind: str
    message: str
    phase: str
    error: str
    traceback: str
    """As in the result document."""
    when: str
    """Step and simulated time; empty where the candidate was not stepped."""
    sense: str
    """What the candidate had sensed; empty where it was not stepped."""


def margin_bar(margin: float) -> MarginBar:
    """Turn a margin into a bar."""
    length = min(abs(margin), 1.0) * 48.0
    return MarginBar(50.0 if margin >= 0.0 else 50.0 - length, max(length, 0.6))


def check_row(check: Mapping[str, Any]) -> CheckRow:
    """Prepare the outcome of a check."""
    verdict, level = clean(check["verdict"]), clean(check["level"])
    margin = check["margin"]
    scenario = check["scenario"] if check["counterexample"] is None else check["counterexample"]
    known = isinstance(margin, int | float) and math.isfinite(margin)
    tone = TONES.get(verdict, "caution" if level == "advisory" else "fail")
    return CheckRow(
        id=clean(check["id"]),
        requirement=clean(check["requirement"]),
        source=clean(check["source"]),
        subject=clean(check["subject"]),
        level=level,
        verdict=verdict,
        tone=tone,
        margin=margin_in_words(margin).replace("-", "−") if known else "–",
        margin_value=float(margin) if known else None,
        bar=margin_bar(float(margin)) if known else None,
        measured=clean(check["measured"]),
        limit=clean(check["limit"]),
        runs=int(check["runs"]),
        message=clean(str(check["message"]).removeprefix(f"{check['measured']}; ")),
        worst=clean(_in_short(scenario)) if scenario is not None else "",
        scenario=clean(plain_data(scenario), LONGEST_BLOCK) if scenario is not None else "",
        file=clean(counterexample_name(str(check["id"]))) if check["counterexample"] is not None else "",
        found=_found(check),
        spread=_spread(check.get("margins")),
        witness=_witness(check.get("witness")),
        waiver=tuple(
            (clean(key).replace("_", " "), clean(value)) for key, value in (check.get("waiver") or {}).items()
        ),
    )


def _found(check: Mapping[str, Any]) -> str:
    found = check.get("found")
    if not isinstance(found, Mapping):
        return ""
    runs = found.get("runs")
    simplified = f", made simpler in {runs} runs" if isinstance(runs, int) and runs > 0 else ""
    return f"{clean(found.get('measured', ''))}{simplified}"


def _witness(witness: object) -> str:
    if not isinstance(witness, Mapping) or not isinstance(witness.get("margin"), int | float):
        return ""
    return clean(witness_in_words(witness))


def _spread(margins: object) -> str:
    if not isinstance(margins, list) or not margins:
        return ""
    known = [value for value in margins if isinstance(value, int | float)]
    if len(known) < len(margins) or not known:
        return ""
    listed = (min(known), median(known), max(known))
    least, middle, greatest = (margin_in_words(value).replace("-", "−") for value in listed)
    return f"least {least}, median {middle}, greatest {greatest}"


def comparison_row(entry: Mapping[str, Any]) -> ComparisonRow:
    """Prepare the comparison of a check with the baseline."""
    verdict, level = clean(entry["verdict"]), clean(entry["level"])
    tone = TONES.get(verdict, "caution" if level == "advisory" else "fail")
    return ComparisonRow(clean(entry["check"]), level, verdict, tone, clean(entry["message"]))


def _in_short(scenario: Mapping[str, Any]) -> str:
    try:
        return scenario_in_short(dict(scenario))
    except (KeyError, TypeError, ValueError, AttributeError):
        return str(scenario.get("name", "scenario"))


def fault_row(fault: Mapping[str, Any]) -> ShownFault:
    """Prepare a fault."""
    step, time = fault["step"], fault["time_s"]
    return ShownFault(
        kind=clean(fault["kind"]),
        message=clean(fault["message"]),
        phase=clean(fault["phase"]),
        error=clean(fault["error"]),
        traceback=clean(fault["traceback"], LONGEST_BLOCK),
        when=f"after {step} steps, at {time:g} s" if step is not None and time is not None else "",
        sense=clean(plain_data(fault["sense"]), LONGEST_BLOCK) if fault["sense"] else "",
    )
