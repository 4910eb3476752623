"""From the result document to what the conformance page shows: bounded, printable text and plain numbers."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from shlex import quote
from typing import Any, Final

from drivegate.check_display import scenario_in_short
from drivegate.handlers.result_file import counterexample_name
from drivegate.result import RESULT_SCHEMA
from drivegate_models.errors import InputError

LONGEST_TEXT: Final = 2_000
"""Longest text of a cell (characters)."""
LONGEST_BLOCK: Final = 20_000
"""Longest scenario or traceback (characters)."""
MOST_FAULTS: Final = 20
"""Most faults that are shown one by one."""

_TONES: Final = {
    "pass": "pass",
    "waived": "caution",
    "waiver expired": "fail",
    "unexpectedly passes": "caution",
    "inconclusive": "caution",
    "not applicable": "quiet",
}


@dataclass(frozen=True)
class MarginBar:
    """A margin as a bar from the middle of a box of 100 by 10, to the right where it is met.

    Attributes
    ----------
    start, width : float
        Of the bar, in the box's units.
    """

    start: float
    width: float


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
        The worst scenario in one line; empty where there is none.
    scenario : str
        The worst scenario as plain data.
    file : str
        The counterexample's file beside the page; empty where the check did not fail.
    """

    id: str
    requirement: str
    source: str
    subject: str
    level: str
    verdict: str
    tone: str
    margin: str
    bar: MarginBar | None
    measured: str
    limit: str
    runs: int
    message: str
    worst: str
    scenario: str
    file: str


@dataclass(frozen=True)
class FaultRow:
    """A fault as the page shows it; texts are bounded and printable.

    Attributes
    ----------
    kind, message, phase, error, traceback : str
        As in the result document.
    when : str
        Step and simulated time; empty where the candidate was not stepped.
    sense : str
        What the candidate had been told; empty where it was not stepped.
    """

    kind: str
    message: str
    phase: str
    error: str
    traceback: str
    when: str
    sense: str


@dataclass(frozen=True)
class ResultView:
    """A result document as the page shows it.

    Attributes
    ----------
    candidate, kind, specification, candidate_hash : str
        The candidate.
    verdict, tone, meaning : str
        The verdict, its colour, and what it means in one sentence.
    exit_code, seed, runs, set_aside : int
        As in the result document.
    effort : str
        As in the result document.
    failing : tuple of str
        Identifiers of the required checks that fail.
    next_step : str
        A command to go on with.
    checks : tuple of CheckRow
        In the order of the document.
    faults : tuple of FaultRow
        The first `MOST_FAULTS` of them.
    more_faults : int
        Number of further ones.
    provenance : tuple of tuple of str
        Names and values.
    """

    candidate: str
    kind: str
    specification: str
    candidate_hash: str
    verdict: str
    tone: str
    meaning: str
    exit_code: int
    seed: int
    runs: int
    set_aside: int
    effort: str
    failing: tuple[str, ...]
    next_step: str
    checks: tuple[CheckRow, ...]
    faults: tuple[FaultRow, ...]
    more_faults: int
    provenance: tuple[tuple[str, str], ...]

    def verdict_of(self, check: str) -> CheckRow | None:
        """Find a check.

        Parameters
        ----------
        check : str
            Its identifier.

        Returns
        -------
        CheckRow or None
            None where the result does not hold it.
        """
        return next((row for row in self.checks if row.id == check), None)


def view_of(document: Mapping[str, Any]) -> ResultView:
    """Prepare a result document for the page.

    Parameters
    ----------
    document : mapping
        A result document of a check.

    Returns
    -------
    ResultView
        Texts are bounded and printable, but not escaped for HTML.

    Raises
    ------
    InputError
        When it is no result of a check, or of a newer schema.
    """
    if document.get("kind") != "check":
        raise InputError(
            f"the document is of kind {document.get('kind')!r}, but must be a result of kind 'check'"
        )
    schema = document.get("schema")
    if not isinstance(schema, int) or schema > RESULT_SCHEMA:
        raise InputError(
            f"the result has the schema {schema!r}, but this version reads up to {RESULT_SCHEMA}"
        )
    candidate = document["candidate"]
    checks = tuple(_check_row(check) for check in document["checks"])
    faults = tuple(_fault_row(fault) for fault in document["faults"][:MOST_FAULTS])
    failing = tuple(row.id for row in checks if row.verdict == "fail" and row.level == "required")
    verdict = clean(document["verdict"])
    return ResultView(
        candidate=clean(candidate["name"]),
        kind=clean(candidate["kind"]),
        specification=clean(candidate["specification"]),
        candidate_hash=clean(candidate["hash"]),
        verdict=verdict,
        tone=_TONES.get(verdict, "fail"),
        meaning=_meaning(verdict, failing),
        exit_code=int(document["exit_code"]),
        seed=int(document["seed"]),
        runs=int(document["runs"]),
        set_aside=int(document["set_aside"]),
        effort=clean(document["effort"]),
        failing=failing,
        next_step=clean(_next_step(document, failing)),
        checks=checks,
        faults=faults,
        more_faults=len(document["faults"]) - len(faults),
        provenance=_provenance(document),
    )


def clean(value: object, longest: int = LONGEST_TEXT) -> str:
    """Make any text printable and bounded; line ends are kept.

    Parameters
    ----------
    value : object
        A text, or something to be written as one.
    longest : int
        Greatest length (characters); of a longer text the end is left out.

    Returns
    -------
    str
        The text with every other unprintable character, also marks of writing direction, as an escape.
    """
    text = str(value)[: longest + 1]
    shown = "".join(
        character
        if character == "\n" or character.isprintable()
        else character.encode("unicode_escape").decode("ascii")
        for character in text
    )
    return shown if len(shown) <= longest else shown[: longest - 1] + "…"


def plain_data(value: object, indent: int = 0) -> str:
    """Write plain data so that it reads well: a line for each key, lists on one line.

    Parameters
    ----------
    value : object
        What JSON can hold.
    indent : int
        Depth of the value.

    Returns
    -------
    str
        Lines of ``key: value`` with JSON values.
    """
    if not isinstance(value, Mapping) or not value:
        return json.dumps(value, ensure_ascii=False, default=str)
    lines = []
    for key, item in value.items():
        nested = isinstance(item, Mapping) and bool(item)
        written = plain_data(item, indent + 1)
        lines.append(f"{'  ' * indent}{key}:{chr(10) if nested else ' '}{written}")
    return "\n".join(lines)


def margin_bar(margin: float) -> MarginBar:
    """Turn a margin into a bar.

    Parameters
    ----------
    margin : float
        Distance from the limit over the limit.

    Returns
    -------
    MarginBar
        A margin of 1 or more, or of -1 or less, fills its half of the box.
    """
    length = min(abs(margin), 1.0) * 48.0
    return MarginBar(50.0 if margin >= 0.0 else 50.0 - length, max(length, 0.6))


def _check_row(check: Mapping[str, Any]) -> CheckRow:
    verdict, level = clean(check["verdict"]), clean(check["level"])
    margin, scenario = check["margin"], check["scenario"]
    known = isinstance(margin, int | float) and math.isfinite(margin)
    tone = _TONES.get(verdict, "caution" if level == "advisory" else "fail")
    return CheckRow(
        id=clean(check["id"]),
        requirement=clean(check["requirement"]),
        source=clean(check["source"]),
        subject=clean(check["subject"]),
        level=level,
        verdict=verdict,
        tone=tone,
        margin=f"{margin:+.3g}".replace("-", "−") if known else "–",
        bar=margin_bar(float(margin)) if known else None,
        measured=clean(check["measured"]),
        limit=clean(check["limit"]),
        runs=int(check["runs"]),
        message=clean(str(check["message"]).removeprefix(f"{check['measured']}; ")),
        worst=clean(_in_short(scenario)) if scenario is not None else "",
        scenario=clean(plain_data(scenario), LONGEST_BLOCK) if scenario is not None else "",
        file=clean(counterexample_name(str(check["id"]))) if check["counterexample"] is not None else "",
    )


def _in_short(scenario: Mapping[str, Any]) -> str:
    try:
        return scenario_in_short(dict(scenario))
    except (KeyError, TypeError, ValueError, AttributeError):
        return str(scenario.get("name", "scenario"))


def _fault_row(fault: Mapping[str, Any]) -> FaultRow:
    step, time = fault["step"], fault["time_s"]
    return FaultRow(
        kind=clean(fault["kind"]),
        message=clean(fault["message"]),
        phase=clean(fault["phase"]),
        error=clean(fault["error"]),
        traceback=clean(fault["traceback"], LONGEST_BLOCK),
        when=f"after {step} steps, at {time:g} s" if step is not None and time is not None else "",
        sense=clean(plain_data(fault["sense"]), LONGEST_BLOCK) if fault["sense"] else "",
    )


def _meaning(verdict: str, failing: Sequence[str]) -> str:
    meanings = {
        "pass": "Every required check is met in every run that it applies to.",
        "inconclusive": "Not all planned runs were made, so that the required checks could not all be judged.",
        "harness fault": "A check of the plant itself failed: the result says nothing about the candidate.",
        "exception": "The candidate raised an exception.",
        "crash": "The candidate's process died.",
        "hang": "The candidate did not answer in time.",
        "invalid output": "The candidate answered with what is no command.",
        "non-deterministic": "The candidate answered the same scenario in two ways.",
    }
    if verdict == "fail":
        return f"{'A required check fails' if len(failing) == 1 else 'Required checks fail'}: {', '.join(failing)}."
    return meanings.get(verdict, "")


def _next_step(document: Mapping[str, Any], failing: Sequence[str]) -> str:
    specification = quote(str(document["candidate"]["specification"]))
    if failing:
        first = failing[0]
        return f"drivegate simulate {specification} --case {counterexample_name(first)} --plot {first}.png"
    if document["verdict"] == "pass" and document["effort"] != "nightly":
        return f"drivegate check {specification} --effort nightly"
    return f"drivegate check {specification} --effort {document['effort']} --seed {document['seed']}"


def _provenance(document: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    candidate = document["candidate"]
    entries: list[tuple[str, object]] = [
        ("candidate", candidate["name"]),
        ("specification", candidate["specification"]),
        ("kind", candidate["kind"]),
        ("hash of its sources", candidate["hash"]),
        *(
            (f"declares {key}", json.dumps(value, default=str))
            for key, value in candidate["declaration"].items()
        ),
    ]
    for section in ("provenance", "timing"):
        for key, value in document.get(section, {}).items():
            items = value.items() if isinstance(value, Mapping) else [("", value)]
            entries += [(f"{key} {name}".strip().replace("_", " "), item) for name, item in items]
    return tuple((clean(name), clean(value)) for name, value in entries)
