"""Options that several commands share, and the types of their values."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from math import inf, isfinite, nan
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any, TypeVar

import click

from drivegate.commands.completion import complete_drive
from drivegate_cases.documents.wording import shown

if TYPE_CHECKING:
    from drivegate_cases.drive.drive_document import DriveDocument
    from drivegate_cases.scenario.scenario import Scenario

_Function = TypeVar("_Function", bound=Callable[..., Any])


def json_flag(*, exposed: bool) -> Callable[[_Function], _Function]:
    """Make the flag ``--json``, as an argument `as_json` of the command if it is exposed."""
    return click.option(
        "--json", "as_json", is_flag=True, expose_value=exposed, help="Print one JSON document, errors too."
    )


json_option = json_flag(exposed=False)
"""The flag that the command line has read before; here it is only accepted and described."""


class WholeNumber(click.IntRange):
    """A whole number within limits, under a name that people use."""

    name = "whole number"


workers_option = click.option(
    "--workers",
    type=WholeNumber(1, 1024),
    help="Processes; by default one for each processor, fewer where memory is short.",
)


def _request_isolation(context: click.Context, _option: click.Parameter, value: str | None) -> None:
    """Set what isolates candidates for as long as the command runs."""
    from drivegate.isolation.layers import isolation_requested

    if value is not None:
        context.with_resource(isolation_requested(value))


def _name_roots(context: click.Context, _option: click.Parameter, folders: tuple[Path, ...]) -> None:
    """Name the folders that manifests may lead into for as long as the command runs."""
    from drivegate.isolation.layers import roots_named

    if any(os.pathsep in str(folder) for folder in folders):
        raise click.BadParameter(f"a folder's path must not contain '{os.pathsep}'")
    if folders:
        context.with_resource(roots_named([str(folder.resolve()) for folder in folders]))


_folder: Any = click.Path(exists=True, file_okay=False, path_type=Path)
_root_option = click.option(
    "--root",
    "roots",
    type=_folder,
    multiple=True,
    metavar="DIR",
    expose_value=False,
    callback=_name_roots,
    help="A further folder whose files a manifest may name and the candidate may read; may be given again.",
)
_isolation_option = click.option(
    "--isolation",
    type=click.Choice(["auto", "strict", "none"]),
    expose_value=False,
    callback=_request_isolation,
    help="Isolate the candidate by all that this machine has, refuse to run without all of it, or do not isolate it.",
)


def isolation_options(function: _Function) -> _Function:
    """Add the options that set how candidates are isolated, and where their files may be.

    By default, `DRIVEGATE_ISOLATION` and `DRIVEGATE_READ` do; else it is ``auto``, and each manifest's own folder.
    """
    return _isolation_option(_root_option(function))


def folder_option(default: str, help_text: str) -> Callable[[_Function], _Function]:
    path: Any = click.Path(path_type=Path)
    return click.option(
        "--output", type=path, default=default, show_default=True, metavar="DIR", help=help_text
    )


def effort_option(help_text: str) -> Callable[[_Function], _Function]:
    efforts = click.Choice(["quick", "default", "nightly"])
    return click.option("--effort", type=efforts, default="default", show_default=True, help=help_text)


def bounded(
    lowest: float, highest: float = inf, *, above: bool = False, unit: str = ""
) -> Callable[[str], float]:
    """Make the type of an option that is a finite number within limits, of a unit."""
    of_unit = f" of {unit}" if unit else ""
    lower = f"above {lowest:g}" if above else f"from {lowest:g}"
    upper = ("" if above else " upward") if highest == inf else f"{' and up' if above else ''} to {highest:g}"

    def number(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = nan
        if not isfinite(value) or value < lowest or (above and value == lowest) or value > highest:
            raise click.BadParameter(f"it is {shown(text)}, but must be a number{of_unit} {lower}{upper}")
        return value

    return number


drive_option = click.option(
    "--drive",
    metavar="NAME|FILE",
    shell_complete=complete_drive,
    help="An included drive, or a TOML or JSON file of one.",
)
drives_option = click.option(
    "--drive",
    "drives",
    multiple=True,
    metavar="NAME|FILE",
    shell_complete=complete_drive,
    help="An included drive, or a TOML or JSON file of one; given again, drives are compared.",
)
settings_option = click.option(
    "--set",
    "settings",
    metavar="KEY=VALUE",
    multiple=True,
    help="Set one key of the drive; may be given again.",
)


def drive_options(function: _Function) -> _Function:
    """Add the options that name a drive and set single values of it."""
    return drive_option(settings_option(function))


def drive_words(drive: str | None, settings: tuple[str, ...]) -> str:
    """Write the options again that name a drive and set values of it, with the space before each."""
    named = "" if drive is None else f" --drive {quote(drive)}"
    return named + "".join(f" --set {quote(setting)}" for setting in settings)


def chosen_drive(
    name: str | None, settings: tuple[str, ...], default: Callable[[], DriveDocument]
) -> DriveDocument:
    from drivegate_cases.drive.drive_document import load_drive

    drive = default() if name is None else load_drive(name)
    return looked_at(drive.with_overrides(settings))


def named_drive(name: str | None) -> DriveDocument | None:
    from drivegate_cases.drive.drive_document import load_drive

    return None if name is None else looked_at(load_drive(name))


def looked_at(drive: DriveDocument) -> DriveDocument:
    """Warn of values that are far off their kind, which change nothing else."""
    from drivegate.output.streams import write_to
    from drivegate_cases.drive.usual_values import unusual_values

    for words in unusual_values(drive):
        write_to(sys.stderr, f"warning: {words}\n")
    return drive


def chosen_scenario(
    case: str | None,
    drive: str | None,
    settings: tuple[str, ...],
    report: Path | None = None,
    run: str | None = None,
) -> Scenario:
    """Find the scenario that the options request, also the one in a counterexample or of a kept result."""
    scenario = _requested_scenario(case, report, run)
    if drive is None and not settings:
        looked_at(scenario.drive)
        return scenario
    return scenario.replaced(drive=chosen_drive(drive, settings, lambda: scenario.drive))


def _requested_scenario(case: str | None, report: Path | None, run: str | None) -> Scenario:
    if case is not None and report is None and run is None:
        return _loaded_scenario(case)
    if case is not None or report is None or run is None:
        raise click.UsageError(
            "name a scenario with --case, or a run of a report with --from FOLDER --run NAME"
        )
    from drivegate.output.result_file import RESULT_FILE
    from drivegate.output.result_reports import read_result
    from drivegate.results.named_runs import scenario_named
    from drivegate_cases.documents.wording import shown_path

    path = report / RESULT_FILE if report.is_dir() else report
    return scenario_named(read_result(path), run, shown_path(path))


def _loaded_scenario(case: str) -> Scenario:
    from drivegate_cases.documents.document import parse_document
    from drivegate_cases.documents.reading import read_mapping
    from drivegate_cases.documents.wording import shown_path
    from drivegate_cases.scenario.scenario import Scenario, load_scenario
    from drivegate_models.errors import InputError

    if case.lower().endswith(".json"):
        mapping = read_mapping(case)
        if mapping.get("kind") == "counterexample":
            scenario = mapping.get("scenario", {})
            if isinstance(scenario, dict) and scenario.get("kind") == "script":
                raise InputError(
                    f"{shown_path(case)} holds a script, which no plant runs; replay it: "
                    f"drivegate replay {quote(case)}"
                )
            return parse_document(scenario, Scenario, f"{case}, the table 'scenario'")
    return load_scenario(case)
