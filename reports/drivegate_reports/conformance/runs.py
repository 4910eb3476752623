"""The runs that a result document shows: figures, signals to zoom into, and the account of each run."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Final

import numpy as np

from drivegate.checks.margin import Moment
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.contract import Columns, RecordedTrace
from drivegate.contracts.current.words import run_signals
from drivegate.contracts.drawings import TIME, Panel, panels_for
from drivegate.contracts.recorded_trace import recorded_closeup, recorded_trace
from drivegate_cases.documents.document import parse_document
from drivegate_cases.documents.wording import counted
from drivegate_cases.scenario.script import Script
from drivegate_models.errors import InputError
from drivegate_reports.conformance.figures import (
    closeup,
    duty_run,
    margin_distribution,
    plain_run,
    recorded_run,
    torque_ripple,
)
from drivegate_reports.conformance.figures import script as script_figure
from drivegate_reports.conformance.figures.run_panels import reused_run_panels
from drivegate_reports.conformance.figures.torque_ripple import ripple_of
from drivegate_reports.page.page import clean
from drivegate_reports.page.style import PageFigure, page_figure


def trace_data(
    trace: RecordedTrace, closeup: tuple[Moment, Columns] | None, panels: tuple[Panel, ...]
) -> str:
    """Return a run as JSON, at full resolution where it has a close-up; names are those of the contract alone."""
    columns = trace.columns if closeup is None else _merged(trace.columns, closeup[1])
    start, end = trace.judged_s
    shown: dict[str, Any] = {
        "panels": [
            {"label": label, "lines": [line._asdict() for line in lines]}
            for label, lines in panels_for(panels, columns)
        ],
        "columns": {name: values.tolist() for name, values in columns.items()},
        "start": start,
        "end": end,
        # Words of a document are for the page's own text; here are numbers, and a column that is known.
        "column": closeup[0].column if closeup is not None and closeup[0].column in columns else "",
        "levels": [] if closeup is None else [level.value for level in closeup[0].levels],
    }
    return json.dumps(shown, separators=(",", ":"), allow_nan=False)


def _merged(whole: Columns, near: Columns) -> Columns:
    """Put the rows of a close-up in the place of the means that it replaces."""
    time, first, last = whole[TIME], near[TIME][0], near[TIME][-1]
    before, after = time < first, time > last
    return {
        name: np.concatenate([values[before], near[name], values[after]])
        for name, values in whole.items()
        if name in near
    }


@dataclass(frozen=True)
class ShownRun:
    account: tuple[str, ...]
    """What happened in it, in sentences."""
    figure: PageFigure
    drawn_before: bool
    """Whether an earlier check already has the figure."""
    ripple: PageFigure | None = None
    """The torque over one electrical period, where a check of the ripple fails."""
    closeup: PageFigure | None = None
    """The moment that decides, where the check fails."""
    data: str = ""
    """The signals as JSON, where they do not stand with an earlier check."""


@reused_run_panels()
def shown_runs(document: Mapping[str, Any]) -> dict[str, ShownRun]:
    shown: dict[str, ShownRun] = {}
    drawn: dict[tuple[int, tuple[float, float]], PageFigure] = {}
    for check in sorted(document["checks"], key=lambda check: check["counterexample"] is None):
        trace = recorded_trace(document, check)
        if trace is None:
            script = _script_of(check)
            if script is not None:
                shown[str(check["id"])] = _shown_script(script, check)
            continue
        contract = contract_of(trace.scenario.drive)
        key = (check["recording"]["trace"], trace.judged_s)
        known = key in drawn
        if not known:
            drawn[key] = _RUN_OF.get(contract.name, _plain_figure)(trace, f"run-{len(drawn) + 1}")
        ripple = _RIPPLE_OF.get(contract.name)
        panels = contract.panels_of(trace.scenario)
        near = recorded_closeup(check, contract.recorded_names, contract.further_names)
        shown[str(check["id"])] = ShownRun(
            tuple(map(clean, contract.account(trace))),
            drawn[key],
            known,
            None if ripple is None else ripple(check, trace),
            None if near is None else _closeup(check, panels, *near),
            "" if known and near is None else trace_data(trace, near, panels),
        )
    return shown


def _closeup(
    check: Mapping[str, Any], panels: tuple[Panel, ...], moment: Moment, columns: Columns
) -> PageFigure | None:
    """Draw the moment that decides a counterexample; None where its column is not there."""
    if moment.column and not moment.courses and moment.column not in columns:
        return None
    return page_figure(
        f"closeup-{clean(check['id'], 40)}",
        closeup.title(moment),
        lambda: closeup.draw(moment, columns, panels),
        clean(closeup.alternative(moment, panels)),
        closeup.caption(moment),
    )


def _figure(trace: RecordedTrace, name: str) -> PageFigure:
    signals = run_signals(trace)
    title = f"Run {clean(signals.scenario.name)}"
    caption = (
        "Means over equal stretches of the run. Dashed: what is demanded, and the smallest angle that can give it at "
        "the operating point of the judged stretch, which is set off."
    )
    words = recorded_run.alternative(signals), caption
    return page_figure(name, title, lambda: recorded_run.draw(signals), *words)


def _duty_figure(trace: RecordedTrace, name: str) -> PageFigure:
    title, words = f"Run {clean(trace.scenario.name)}", duty_run.alternative(trace)
    return page_figure(name, title, lambda: duty_run.draw(trace), words, duty_run.CAPTION)


def _ripple_figure(check: Mapping[str, Any], trace: RecordedTrace) -> PageFigure | None:
    ripple = None if check["counterexample"] is None else ripple_of(str(check["id"]), run_signals(trace))
    if ripple is None:
        return None
    name = f"torque-{clean(check['id'], 40)}"
    words = torque_ripple.alternative(ripple), torque_ripple.caption(ripple)
    return page_figure(name, torque_ripple.TITLE, lambda: torque_ripple.draw(ripple), *words)


def _plain_figure(trace: RecordedTrace, name: str) -> PageFigure:
    title, words = f"Run {clean(trace.scenario.name)}", plain_run.alternative(trace)
    return page_figure(name, title, lambda: plain_run.draw(trace), words, plain_run.CAPTION)


_RUN_OF: Final[Mapping[str, Callable[[RecordedTrace, str], PageFigure]]] = {
    "current": _figure,
    "duty": _duty_figure,
}
"""What draws the signals of a run, by the name of a contract that has a drawing of its own."""
_RIPPLE_OF: Final = {"current": _ripple_figure}
"""What draws the torque over one electrical period, where a check of the ripple fails."""


def _script_of(check: Mapping[str, Any]) -> Script | None:
    """Read the counterexample of a check where it is a script."""
    stored = check["counterexample"]
    if not isinstance(stored, Mapping) or stored.get("kind") != "script":
        return None
    try:
        return parse_document(stored, Script, "the script")
    except InputError:
        return None


def _shown_script(script: Script, check: Mapping[str, Any]) -> ShownRun:
    sensed = f"Script of {counted(len(script.rows), 'row')}, each held for one period of the search"
    name, title = f"script-{clean(check['id'], 40)}", f"Script {clean(script.name)}"
    words = script_figure.alternative(script), script_figure.CAPTION
    figure = page_figure(name, title, lambda: script_figure.draw(script), *words)
    return ShownRun((clean(f"{sensed}: {check['measured']}."),), figure, drawn_before=False)


def margin_figure(document: Mapping[str, Any]) -> PageFigure | None:
    rows = [
        margin_distribution.CheckMargins(clean(check["id"], 40), margins)
        for check in document["checks"]
        if (margins := _margins(check)) is not None
    ]
    if not rows:
        return None
    words = margin_distribution.alternative(rows), margin_distribution.caption(rows)
    return page_figure("margins", margin_distribution.TITLE, lambda: margin_distribution.draw(rows), *words)


def _margins(check: Mapping[str, Any]) -> np.ndarray[Any, np.dtype[np.float64]] | None:
    values = check.get("margins")
    if not isinstance(values, list) or not values:
        return None
    if not all(value is None or isinstance(value, int | float) for value in values):
        return None
    # An infinite loss cannot be written as JSON.
    return np.sort(np.array([-np.inf if value is None else value for value in values], dtype=np.float64))
