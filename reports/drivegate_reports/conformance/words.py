"""Words and drawings of the conformance page for the sections of a result document."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import median
from typing import Any, Final, TypeGuard

from drivegate.checks.margin import margin_in_words
from drivegate.output import rerun
from drivegate.output.result_file import counterexample_name
from drivegate.output.wording import scenario_in_short
from drivegate.results.result import witness_in_words
from drivegate_reports.page.page import LONGEST_BLOCK, clean, plain_data

TONES: Final = {
    "pass": "pass",
    "contested": "caution",
    "not yet witnessed": "caution",
    "waived": "caution",
    "waiver expired": "fail",
    "unexpectedly passes": "caution",
    "inconclusive": "caution",
    "never judged": "caution",
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


def tone_of(section: Mapping[str, Any]) -> str:
    """Choose the tone of a section with a verdict: ``pass``, ``fail``, ``caution`` or ``quiet``."""
    return TONES.get(section["verdict"], "caution" if section.get("level") == "advisory" else "fail")


def is_known(margin: object) -> TypeGuard[float]:
    return isinstance(margin, int | float) and math.isfinite(margin)


def margin_bar(margin: float) -> MarginBar:
    length = min(abs(margin), 1.0) * 48.0
    return MarginBar(50.0 if margin >= 0.0 else 50.0 - length, max(length, 0.6))


def margin_text(margin: object) -> str:
    return _signed(margin) if is_known(margin) else "–"


def _signed(margin: float) -> str:
    return margin_in_words(margin).replace("-", "−")


def shown_run(check: Mapping[str, Any]) -> Mapping[str, Any] | None:
    run: Mapping[str, Any] | None = check["scenario"]
    return run if check["counterexample"] is None else check["counterexample"]


def run_in_short(check: Mapping[str, Any]) -> str:
    scenario = shown_run(check) or {}
    try:
        return clean(scenario_in_short(dict(scenario)))
    except (KeyError, TypeError, ValueError, AttributeError):
        return clean(scenario.get("name", "scenario"))


def block(value: object) -> str:
    return clean(plain_data(value), LONGEST_BLOCK)


def outcome_in_words(check: Mapping[str, Any]) -> str:
    """Return the message of a check without the measured value, which is shown beside it."""
    return str(check["message"]).removeprefix(f"{check['measured']}; ")


def counterexample_file(check: Mapping[str, Any]) -> str:
    return clean(counterexample_name(str(check["id"])))


def replay_command(check: Mapping[str, Any], result: Mapping[str, Any]) -> str:
    return clean(rerun.replay_command(result, str(check["id"]), plot=True))


def waiver_items(check: Mapping[str, Any]) -> list[tuple[str, str]]:
    return [
        (clean(key).replace("_", " "), clean(value)) for key, value in (check.get("waiver") or {}).items()
    ]


def found_in_words(check: Mapping[str, Any]) -> str:
    """State what the counterexample of a check gave; empty where there is none."""
    found = check.get("found")
    if not isinstance(found, Mapping):
        return ""
    runs = found.get("runs")
    simplified = f", made simpler in {runs} runs" if isinstance(runs, int) and runs > 0 else ""
    return f"{clean(found.get('measured', ''))}{simplified}"


def met_by_witness(check: Mapping[str, Any]) -> str:
    """Name the known good controller that meets a requirement in the counterexample; empty where there is none."""
    witness = check.get("witness")
    if not isinstance(witness, Mapping) or not isinstance(witness.get("margin"), int | float):
        return ""
    return clean(witness_in_words(witness))


def spread_of(check: Mapping[str, Any]) -> str:
    """Write least, median and greatest margin of all runs of a check; empty where they are not all known."""
    margins = check.get("margins")
    if not isinstance(margins, list) or not margins or not all(map(is_known, margins)):
        return ""
    least, middle, greatest = map(_signed, (min(margins), median(margins), max(margins)))
    return f"least {least}, median {middle}, greatest {greatest}"


def when_of(fault: Mapping[str, Any]) -> str:
    """Write step and simulated time of a fault; empty where the candidate was not stepped."""
    step, time = fault["step"], fault["time_s"]
    return f"after {step} steps, at {time:g} s" if step is not None and time is not None else ""
