"""Counterexamples that were run again on the console."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import Any, Final

from rich.console import Console

from drivegate.checks.margin import margin_in_words
from drivegate.contracts.catalogue import contract_of
from drivegate.output.console import ADVISED, STYLES, plain, print_ending, print_line
from drivegate.output.figures import figure_file, side_legend
from drivegate.output.result_file import COUNTEREXAMPLES
from drivegate.output.trace_files import write_plot
from drivegate.results.counterexample import Counterexample
from drivegate.studies.replay.replay import (
    FIXED,
    NOT_REPRODUCED,
    STILL_FAILS,
    VERDICTS,
    Replay,
    marked_angle,
)
from drivegate.studies.simulate import trace_frame
from drivegate_cases.documents.wording import counted, one_line
from drivegate_cases.scenario.script import Script

_PANELS: Final = (
    ((("speed_reference_rpm", "reference"), ("speed_rpm", "speed")), "speed (rpm)"),
    ((("current_sum_a", "Σ|i|"),), "current (A)"),
)


def next_step(document: dict[str, Any], file: Path, candidate: str | None) -> str:
    """State what to do with a counterexample that still fails, or no longer does."""
    named = "" if candidate is None else f" --candidate {quote(candidate)}"
    again = f"drivegate replay {quote(str(file))}{named}"
    if document["verdict"] == NOT_REPRODUCED:
        return (
            f"what differs: drivegate check {quote(candidate or document['candidate']['name'])}"
            f"{document['drive_option']} --only DET-1"
        )
    if document["verdict"] != STILL_FAILS:
        who = quote(candidate or document["candidate"]["name"]) + document["drive_option"]
        # A report's own folder is replaced by the next one, and is no place to keep anything.
        copied = f"mkdir -p corpus && cp {quote(str(file))} corpus/"
        return f"keep it in a corpus: {copied} && drivegate check {who} --corpus corpus"
    if document["fault"] is None and not document["files"]:
        return f"look at the signals: {again} --plot {document['check']}.svg"
    return f"change the controller, then {again}"


def show_replay(console: Console, document: dict[str, Any], hint: str) -> None:
    """Print what was measured then and now."""
    name, fault = document["candidate"]["name"], document["fault"]
    good = document["verdict"] == FIXED
    print_line(
        console, f"{document['check']} {document['verdict'].upper()}", "bold green" if good else "bold red"
    )
    print_line(console, f"  {document['requirement']}")
    print_line(console, f"  then {_margin_text(document['then'])}, by {document['found_with']['name']}")
    if fault is not None:
        print_line(console, f"  now  {fault['kind']}: {fault['message']}, by {name}")
        for line in fault["traceback"].splitlines():
            print_line(console, f"  {line}", "dim")
    elif document["now"] is None:
        print_line(console, f"  now  {document['reason']}; {name} ran")
    else:
        print_line(console, f"  now  {_margin_text(document['now'])}, by {name}")
        print_line(console, f"  limit {document['limit']}; in {document['scenario']}, {_where(document)}")
    if document["remark"]:
        print_line(console, f"  {document['remark']}", "bold red")
    for sentence in document["account"]:
        print_line(console, f"  {sentence}")
    print_ending(console, document["files"], hint)


def _where(document: dict[str, Any]) -> str:
    if document["rows"] is not None:
        first, last = document["rows"]
        return f"row {last}" if first == last else f"rows {first} to {last}"
    start, end = document["window_s"]
    return f"{start:g} s to {end:g} s"


def _margin_text(measured: dict[str, Any]) -> str:
    margin = measured["margin"]
    text = "margin –" if margin is None else f"margin {margin_in_words(margin, 4)}"
    return f"{text} ({measured['measured']})" if measured["measured"] else text


def next_step_of_all(document: dict[str, Any], candidate: str | None) -> str:
    """State what to do when one of a folder's counterexamples still fails, or none does."""
    replays = document["replays"]
    fails = [replay for replay in sorted(replays, key=_urgency) if replay["verdict"] == STILL_FAILS]
    failing = fails[0] if fails else None
    parted = next((replay for replay in replays if replay["verdict"] == NOT_REPRODUCED), None)
    if failing is None and parted is not None:
        return next_step(parted, Path(parted["file"]), candidate)
    if failing is not None:
        named = "" if candidate is None else f" --candidate {quote(candidate)}"
        return f"drivegate replay {quote(failing['file'])}{named} --plot {failing['check']}.svg"
    who = quote(candidate or replays[0]["candidate"]["name"]) + replays[0]["drive_option"]
    places = {Path(replay["file"]).parent for replay in replays}
    if len(places) > 1:
        return f"drivegate check {who}"
    place = places.pop()
    if place.name != COUNTEREXAMPLES:
        return f"drivegate check {who} --corpus {quote(str(place))}"
    # A report's own folder is replaced by the next one, and is no place to keep anything.
    copied = f"mkdir -p corpus && cp {quote(str(place))}/*.json corpus/"
    return f"keep them in a corpus: {copied} && drivegate check {who} --corpus corpus"


def show_all_replays(console: Console, document: dict[str, Any], hint: str) -> None:
    """Print one line for each counterexample of a folder, and how many still fail."""
    replays = sorted(document["replays"], key=_urgency)
    widths = [max(len(replay[key]) for replay in replays) for key in ("verdict", "check")]
    for replay in replays:
        fails = STYLES[ADVISED] if replay["level"] == "advisory" else "bold red"
        style = {STILL_FAILS: fails, NOT_REPRODUCED: fails, FIXED: "bold green"}.get(replay["verdict"], "")
        line = plain(replay["verdict"].upper().ljust(widths[0]), style)
        line.append_text(
            plain(f"  {replay['check'].ljust(widths[1])}  {_in_short(replay)}  {replay['file']}")
        )
        console.print(line)
    failing = [replay for replay in replays if replay["verdict"] == STILL_FAILS]
    advised = sum(replay["level"] == "advisory" for replay in failing)
    words = {STILL_FAILS: STILL_FAILS if len(failing) == 1 else "still fail"}
    more = {STILL_FAILS: f" ({advised} of them advisory, which do not count)" if advised else ""}
    counts = [
        f"{count} {words.get(verdict, verdict)}{more.get(verdict, '')}"
        for verdict, count in document["counts"].items()
        if count
    ]
    print_line(console, f"{counted(len(replays), 'counterexample')}: {', '.join(counts)}", "bold")
    print_line(console, f"next: {hint}", "dim")


def _urgency(replay: dict[str, Any]) -> tuple[int, bool]:
    """Order by the verdict, and required checks before those that advise."""
    return VERDICTS.index(replay["verdict"]), replay["level"] != "required"


def _in_short(replay: dict[str, Any]) -> str:
    """State in short the outcome of a counterexample, and what it was."""
    name, fault = replay["candidate"]["name"], replay["fault"]
    if fault is not None:
        return f"{fault['kind']}: {fault['message']}, by {name}"
    if replay["now"] is None:
        return f"{replay['reason']}; {name} ran"
    then = replay["then"]["margin"]
    was = "" if then is None else f", was {then:+.4g}"
    return f"{_margin_text(replay['now'])}{was}, by {name}"


def draw(stored: Counterexample, ended: Replay, plot: Path, title: str) -> None:
    """Draw what was observed, and set off what the check was judged on."""
    if isinstance(stored.scenario, Script):
        _draw_script(stored.scenario, ended, plot, title)
    elif ended.run is not None:
        frame = trace_frame(stored.scenario, ended.run, ended.steps)
        panels = contract_of(stored.scenario.drive).panels_of(stored.scenario)
        write_plot(frame, plot, title, panels, moment=ended.moment, edge=marked_angle(stored, ended))


def _draw_script(script: Script, ended: Replay, plot: Path, title: str) -> None:
    """Draw what the controller sensed, row by row."""
    edges = [number + 0.5 for number in range(len(script.rows) + 1)]
    with figure_file(plot, 9.0, 6.0) as figure:
        all_axes = figure.subplots(len(_PANELS), 1, sharex=True)
        for axes, (lines, label) in zip(all_axes, _PANELS, strict=True):
            for key, name in lines:
                axes.stairs([getattr(row, key) for row in script.rows], edges, baseline=None, label=name)
            if ended.rows is not None:
                first, last = ended.rows
                axes.axvspan(first - 0.5, last + 0.5, color="tab:orange", alpha=0.15, label="judged here")
            axes.set_ylabel(label)
            axes.ticklabel_format(axis="y", useOffset=False)
            axes.grid(visible=True, alpha=0.3)
            side_legend(axes)
        all_axes[-1].xaxis.get_major_locator().set_params(integer=True)
        all_axes[-1].set_xlabel("row: one period of the search")
        measured = ended.margin.measured if ended.margin is not None else ""
        figure.suptitle(one_line(f"{title}, {measured}"), fontsize="small", wrap=True)
