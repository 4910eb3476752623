"""``drivegate diff``: two candidates step by step, up to the first difference."""

from __future__ import annotations

from pathlib import Path
from shlex import quote

import click

from drivegate.commands.completion import complete_candidate, complete_case
from drivegate.commands.conduct import Outcome
from drivegate.commands.options import (
    WholeNumber,
    bounded,
    chosen_scenario,
    drive_options,
    drive_words,
    isolation_options,
    json_option,
)
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.contract import Contract
from drivegate.contracts.current.columns import CurrentColumns
from drivegate.contracts.duty.columns import DutyColumns

_FIELDS = tuple(dict.fromkeys((*CurrentColumns.outputs, *DutyColumns.outputs)))
_AROUND_IN_FIGURE = 100


@click.command("diff")
@click.argument("first", shell_complete=complete_candidate)
@click.argument("second", shell_complete=complete_candidate)
@click.option(
    "--case",
    required=True,
    metavar="NAME|FILE",
    shell_complete=complete_case,
    help="An included scenario, or a file of one.",
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
    type=WholeNumber(0, 1000),
    default=3,
    show_default=True,
    metavar="N",
    help="Steps to show before the first difference.",
)
@click.option(
    "--again",
    is_flag=True,
    help="Have the instance of SECOND run the scenario once before: against itself, what reset keeps.",
)
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Draw both commands around the first difference; the name ends in .png or .svg.",
)
@drive_options
@isolation_options
@json_option
def command(
    first: str,
    second: str,
    case: str,
    tolerance: float | None,
    ignore: tuple[str, ...],
    before: int,
    again: bool,
    plot: Path | None,
    drive: str | None,
    settings: tuple[str, ...],
) -> Outcome:
    """Compare two candidates step by step, and show the first step at which their commands differ.

    FIRST drives the plant; SECOND is given the same Sense at each step. Both are a built-in or installed
    controller's name, module:Class, a file or a manifest. The exit code is 0 when all commands are equal,
    1 when they differ or one of the candidates has a fault.
    """
    from drivegate.candidates.resolution import resolve_candidate
    from drivegate.output.trace_files import check_targets

    candidates = (resolve_candidate(first), resolve_candidate(second))
    scenario = chosen_scenario(case, drive, settings)
    contract = contract_of(scenario.drive)
    _require_fields(contract, ignore)
    check_targets(None, None, plot)

    from drivegate.drives.kinds import require_contract, scenario_at_declared_timing
    from drivegate.studies.diff.diff import BITWISE, Rule, compared
    from drivegate.studies.diff.display import draw, show_difference
    from drivegate.studies.diff.document import document_of

    for candidate in candidates:
        require_contract(candidate, scenario.drive)
    scenario = scenario_at_declared_timing(scenario, candidates)
    rule = Rule(BITWISE if tolerance is None else tolerance, ignore)
    around = 0 if plot is None else _AROUND_IN_FIGURE
    comparison = compared(*candidates, scenario, rule, before=max(before, around), after=around, again=again)
    document = document_of(candidates, scenario, rule, comparison)
    found = document["difference"]
    if found is not None:
        found["before"] = found["before"][len(found["before"]) - min(before, len(found["before"])) :]
        del found["after"]
    if plot is not None and comparison.difference is not None:
        names = (candidates[0].name, candidates[1].name)
        draw(comparison.difference, contract, names, plot, f"{names[0]} and {names[1]}: {scenario.name}")
        document["files"] = [str(plot)]
    words = " ".join(quote(word) for word in (first, second, "--case", case, *(["--again"] if again else [])))
    words += drive_words(drive, settings)
    return Outcome(
        document,
        lambda console: show_difference(console, document, contract.sensed, words),
        document["exit_code"],
    )


def _require_fields(contract: Contract, ignored: tuple[str, ...]) -> None:
    """Refuse to leave out what no command of a contract has, or all that it has."""
    unknown = next((name for name in ignored if name not in contract.outputs), None)
    if unknown is not None:
        fields = ", ".join(contract.outputs)
        raise click.UsageError(f"--ignore {unknown} names no field of the drive's contract; it has {fields}")
    if set(contract.outputs) <= set(ignored):
        raise click.UsageError("--ignore leaves no field to compare; leave one out")
