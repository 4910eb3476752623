"""The first difference of two candidates on the console."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from drivegate.output.console import plain, table
from drivegate.studies.diff.field import in_words

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rich.console import Console


def show_difference(
    console: Console, document: dict[str, Any], sensed: Mapping[str, str], words: str
) -> None:
    """Print whether two candidates are equal, and where they are not.

    `sensed` has the unit of each field of a sense to print, and `words` repeats the command.
    """
    one, other = (candidate["name"] for candidate in document["candidates"])
    rule = "bit for bit" if document["tolerance"] is None else f"within {document['tolerance']:g}"
    console.print(plain(f"first: {one}, second: {other}; {document['scenario']}, {rule}"))
    fault, found = document["fault"], document["difference"]
    if fault is not None:
        message = f"{fault['kind'].upper()} of the {fault['place']}, {fault['candidate']}: {fault['message']}"
        console.print(plain(message, "bold red"))
        console.print(plain(f"  {document['steps_equal']} steps before"))
        for line in fault["traceback"].splitlines():
            console.print(plain(f"  {line}", "dim"))
    elif found is None:
        console.print(plain(f"EQUAL in all {document['steps_equal']} steps", "bold green"))
    else:
        console.print(plain(f"DIFFERENT first in step {found['step']}, at {found['time_s']:g} s", "bold red"))
        _show_difference(console, found, sensed)
    for path in document["files"]:
        console.print(plain(f"written: {path}"))
    if found is not None and not document["files"]:
        console.print(plain(f"next: drivegate diff {words} --plot difference.svg draws both", "dim"))


def _show_difference(console: Console, found: dict[str, Any], sensed: Mapping[str, str]) -> None:
    shown = table("both sensed", "value", "unit", right=("value",))
    for key, unit in sensed.items():
        value = found["sense"][key]
        several = isinstance(value, tuple)
        for number, one in enumerate(value if several else (value,), 1):
            shown.add_row(f"{key}[{number}]" if several else key, repr(one), unit)
    console.print(shown)
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
