"""``drivegate diff``: two candidates step by step, up to the first difference."""

from __future__ import annotations

from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import bounded, chosen_scenario, json_option, motor_options

if TYPE_CHECKING:
    from rich.console import Console

_SENSE = (
    ("speed_reference", "rad/s"),
    ("speed", "rad/s"),
    ("current_magnitude_sum", "A"),
    ("half_supply_voltage", "V"),
)
_FIELDS = ("current_reference", "advance_angle", "input_power")
_AROUND_IN_FIGURE = 100


@click.command("diff")
@click.argument("first")
@click.argument("second")
@click.option(
    "--case", required=True, metavar="NAME|FILE", help="A scenario that comes along, or a file of one."
)
@click.option(
    "--tolerance",
    type=bounded(0.0),
    metavar="X",
    help="Greatest difference, relative, absolute below 1; by default none, bit for bit.",
)
@click.option(
    "--ignore",
    type=click.Choice(_FIELDS),
    multiple=True,
    help="Leave out a field of the command; may be given again.",
)
@click.option(
    "--before",
    type=click.IntRange(0, 1000),
    default=3,
    show_default=True,
    metavar="N",
    help="Steps to show before the first difference.",
)
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Draw both commands around the first difference; the name ends in .png or .svg.",
)
@motor_options
@json_option
def command(
    first: str,
    second: str,
    case: str,
    tolerance: float | None,
    ignore: tuple[str, ...],
    before: int,
    plot: Path | None,
    motor: str | None,
    settings: tuple[str, ...],
) -> Outcome:
    """Compare two candidates step by step, and show the first step at which their commands differ.

    FIRST drives the plant; SECOND is told the same at each step. Both are a built-in or installed controller's name,
    module:Class, a file or a manifest. The exit code is 0 when all commands are equal, 1 when they differ or one of
    the candidates has a fault.
    """
    from drivegate.candidates.resolution import resolve_candidate
    from drivegate.output.trace_files import check_targets

    if len(set(ignore)) == len(_FIELDS):
        raise click.UsageError("--ignore leaves no field to compare; leave one out")
    candidates = (resolve_candidate(first), resolve_candidate(second))
    scenario = chosen_scenario(case, motor, settings)
    check_targets(None, None, plot)

    from drivegate.studies.diff.diff import compared
    from drivegate.studies.diff.document import document_of
    from drivegate.studies.diff.jobs import BITWISE, Rule

    judged = tuple(name for name in _FIELDS if name not in ignore)
    rule = Rule(BITWISE if tolerance is None else tolerance, judged)
    around = 0 if plot is None else _AROUND_IN_FIGURE
    comparison = compared(*candidates, scenario, rule, before=max(before, around), after=around)
    document = document_of(candidates, scenario, rule, comparison)
    found = document["difference"]
    if found is not None:
        found["before"] = found["before"][len(found["before"]) - min(before, len(found["before"])) :]
        del found["after"]
    if plot is not None and comparison.difference is not None:
        from drivegate.studies.diff.figure import draw

        names = (candidates[0].name, candidates[1].name)
        draw(comparison.difference, names, plot, f"{names[0]} and {names[1]}: {scenario.name}")
        document["files"] = [str(plot)]
    words = " ".join(quote(word) for word in (first, second, "--case", case))
    return Outcome(document, lambda console: _show(console, document, words), document["exit_code"])


def _show(console: Console, document: dict[str, Any], words: str) -> None:
    from drivegate.output.console import plain

    one, other = (candidate["name"] for candidate in document["candidates"])
    rule = "bit for bit" if document["tolerance"] is None else f"within {document['tolerance']:g}"
    console.print(plain(f"first: {one}, second: {other}; {document['scenario']}, {rule}"))
    fault, found = document["fault"], document["difference"]
    if fault is not None:
        told = f"{fault['kind'].upper()} of the {fault['place']}, {fault['candidate']}: {fault['message']}"
        console.print(plain(told, "bold red"))
        console.print(plain(f"  {document['steps_equal']} steps before"))
        for line in fault["traceback"].splitlines():
            console.print(plain(f"  {line}", "dim"))
    elif found is None:
        console.print(plain(f"EQUAL in all {document['steps_equal']} steps", "bold green"))
    else:
        console.print(plain(f"DIFFERENT first in step {found['step']}, at {found['time_s']:g} s", "bold red"))
        _show_difference(console, found)
    for path in document["files"]:
        console.print(plain(f"written: {path}"))
    if found is not None and not document["files"]:
        console.print(plain(f"next: drivegate diff {words} --plot difference.svg draws both", "dim"))


def _show_difference(console: Console, found: dict[str, Any]) -> None:
    from drivegate.output.console import plain, table
    from drivegate.studies.diff.document import in_words

    told = table("both were told", "value", "unit", right=("value",))
    for key, unit in _SENSE:
        told.add_row(key, repr(found["sense"][key]), unit)
    for phase, current in enumerate(found["sense"]["phase_currents"], 1):
        told.add_row(f"phase current {phase}", repr(current), "A")
    console.print(told)
    plant = found["plant"]
    currents = ", ".join(f"{current:.4g}" for current in plant["phase_currents"])
    console.print(
        plain(
            f"the plant: {plant['speed_rpm']:.6g} rpm, electrical angle {plant['electrical_angle_deg']:.2f}°, "
            f"phase currents {currents} A"
        )
    )
    answers = table(
        "step", "field", "first", "second", "unit", "difference", right=("step", "first", "second")
    )
    rows = [*found["before"], {"step": found["step"], "commands": found["commands"]}]
    for row in rows:
        for field in row["commands"]:
            style = "bold red" if field["differs"] else ""
            values = (_number(field["first"]), _number(field["second"]))
            cells = (row["step"], field["field"], *values, field["unit"], in_words(field))
            answers.add_row(*(plain(cell, style) for cell in cells))
    console.print(answers)


def _number(value: float) -> str:
    return "none" if value != value else repr(value)
