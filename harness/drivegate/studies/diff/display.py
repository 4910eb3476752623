"""The first difference of two candidates on the console."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from rich.console import Console

from drivegate.candidates.step_costs import StepCosts
from drivegate.checks.every_contract import costs_in_words
from drivegate.contracts.contract import Contract
from drivegate.output.console import plain, print_ending, print_line, table
from drivegate.output.figures import figure_file, side_legend
from drivegate.studies.diff.diff import Difference
from drivegate.studies.diff.document import in_words
from drivegate_cases.documents.wording import one_line
from drivegate_models.units import RPM

_LAST_DIGITS: Final = 1e-5
"""Relative difference that rounding explains, of a step that computes in single precision (1)."""
_ROUNDING: Final = (
    "likely: rounding. Compilers for a target fuse multiplications with additions, and its mathematics library may be "
    "another one; build both with -ffp-contract=off, or state a tolerance with --tolerance"
)


def show_difference(
    console: Console, document: dict[str, Any], sensed: Mapping[str, str], words: str
) -> None:
    """Print whether two candidates are equal, and where they are not.

    `sensed` has the unit of each field of a sense to print, and `words` repeats the command.
    """
    one, other = (candidate["name"] for candidate in document["candidates"])
    rule = "bit for bit" if document["tolerance"] is None else f"within {document['tolerance']:g}"
    print_line(console, f"first: {one}, second: {other}; {document['scenario']}, {rule}")
    fault, found = document["fault"], document["difference"]
    if fault is not None:
        message = f"{fault['kind'].upper()} of the {fault['place']}, {fault['candidate']}: {fault['message']}"
        print_line(console, message, "bold red")
        print_line(console, f"  {document['steps_equal']} steps before")
        for line in fault["traceback"].splitlines():
            print_line(console, f"  {line}", "dim")
    elif found is None:
        print_line(console, f"EQUAL in all {document['steps_equal']} steps", "bold green")
    else:
        print_line(console, f"DIFFERENT first in step {found['step']}, at {found['time_s']:g} s", "bold red")
        _show_difference(console, found, sensed)
    for candidate in document["candidates"]:
        if costs := costs_in_words(StepCosts(**candidate["step_costs"])):
            print_line(console, f"on its target, {candidate['name']} takes at most {costs}")
    if found is not None and is_rounding_of_a_target(document):
        print_line(console, _ROUNDING)
    hint = f"drivegate diff {words} --plot difference.svg draws both"
    print_ending(console, document["files"], hint if found is not None and not document["files"] else "")


def is_rounding_of_a_target(document: dict[str, Any]) -> bool:
    """Return True if one candidate alone is an image, and the first difference is one of the last digits."""
    kinds = [candidate["kind"] for candidate in document["candidates"]]
    differing = [field for field in document["difference"]["commands"] if field["differs"]]
    return kinds.count("elf") == 1 and all(
        field["ulps"] is not None
        and abs(field["difference"]) <= _LAST_DIGITS * max(abs(field["first"]), abs(field["second"]))
        for field in differing
    )


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
    print_line(
        console,
        f"the plant: {plant['speed_rpm']:.6g} rpm, electrical angle {plant['electrical_angle_deg']:.2f}°, "
        f"phase currents {currents} A",
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


def draw(found: Difference, contract: Contract, names: tuple[str, str], plot: Path, title: str) -> None:
    """Draw both commands around the first difference, their differences, and the speed."""
    rows = 2 * len(contract.plotted) + 1
    with figure_file(plot, 9.0, 1.8 * rows) as figure:
        all_axes = figure.subplots(rows, 1, sharex=True)
        _draw_panels(all_axes, found, contract, names)
        for axes in all_axes:
            axes.axvline(found.step, color="tab:red", linewidth=1.0, linestyle=":")
            axes.grid(visible=True, alpha=0.3)
            axes.ticklabel_format(axis="both", useOffset=False)
        time = found.rows["sense"]["time"][found.step - found.begin]
        all_axes[-1].set_xlabel(f"step (dotted: step {found.step}, {time:g} s)")
        figure.suptitle(one_line(title))


def _draw_panels(all_axes: Any, found: Difference, contract: Contract, names: tuple[str, str]) -> None:
    steps = found.begin + np.arange(len(found.rows))
    answered = steps[: len(found.answers)]
    for place, (field, (unit, factor)) in enumerate(contract.plotted.items()):
        first, second = found.rows["command"][field] * factor, found.answers[field] * factor
        commands, apart = all_axes[2 * place], all_axes[2 * place + 1]
        commands.step(steps, first, where="post", label=one_line(names[0]))
        commands.step(answered, second, where="post", label=one_line(names[1]), linestyle="--")
        commands.set_ylabel(f"{contract.outputs[field][0]} ({unit})")
        side_legend(commands)
        apart.step(answered, second - first[: len(second)], where="post", color="tab:red")
        apart.set_ylabel(f"difference ({unit})")
    all_axes[-1].plot(steps, found.rows["sense"]["speed"] * RPM, color="tab:gray")
    all_axes[-1].set_ylabel("speed sensed (rpm)")
