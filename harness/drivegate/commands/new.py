"""``drivegate new``: a small candidate that works, as a place to start from."""

from __future__ import annotations

import sys
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import drive_option, json_option, looked_at, named_drive
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from rich.console import Console

    from drivegate_cases.documents.quantity.question import Amount, Question

SCHEMA = 1
DRIVE = "drive"
REQUIREMENTS = "requirements"
SCENARIO = "scenario"
FILES = {DRIVE: "a drive", SCENARIO: "a scenario", REQUIREMENTS: "requirements"}
"""The kinds that are no candidates but single files, in words."""
SENSORLESS_DRIVE = "pm-ac-2kw-sensorless"
"""Drive of a controller without a position sensor, if none is named."""
CHOICES = (
    *("python", "numba", "c", "c++", "rust", "cortex-m", "fmu", "exec", "embedded-coder"),
    *FILES,
)


@click.command("new")
@click.argument("kind", type=click.Choice(CHOICES, case_sensitive=False), metavar="KIND")
@click.argument("name")
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Folder to make; by default NAME. Nothing is ever overwritten.",
)
@click.option(
    "--from-datasheet",
    is_flag=True,
    help="For the kind drive: ask for the values of a data sheet, convert them and write a PM AC drive.",
)
@click.option(
    "--ci",
    "service",
    type=click.Choice(["github", "gitlab", "none"]),
    default="github",
    show_default=True,
    help="Write the gate for this service, in an existing Git repository where it runs.",
)
@click.option(
    "--sensorless",
    is_flag=True,
    help="For the kinds c and embedded-coder: a controller without a position sensor, by default on "
    "pm-ac-2kw-sensorless.",
)
@drive_option
@json_option
def command(
    kind: str,
    name: str,
    output: Path | None,
    drive: str | None,
    service: str,
    from_datasheet: bool,
    sensorless: bool,
) -> Outcome:
    """Write a small controller called NAME into a new folder, with manifest, test, waivers and a workflow for CI.

    The kind drive is no controller: NAME is then a new file such as my-drive.toml. With --from-datasheet it asks for
    Kv, Kt or Ke, for resistance, inductance, currents and speeds in the units of your data sheet, and states each
    conversion. Otherwise the file has a comment for each key and the values of the drive of --drive, by default
    pm-ac-interior, to be replaced by your own.

    The kind scenario is one run on the drive of --drive, by default the PM AC drive pm-ac-interior: NAME is a new file
    such as my-run.toml with a step, and with a comment for every other key.

    The kind requirements is no controller either: NAME is then a new file such as requirements.toml, with five usual
    requirements for the drive of --drive, by default the one of duty ratios.

    The controller is field-oriented control in the language of the kind: python, numba, c, c++, rust, cortex-m (the
    image for a microcontroller, emulated), fmu, exec (any program), or embedded-coder (C as generated from Simulink).
    It passes every required check on pm-ac-interior. With --drive its manifest names that drive, whose file is copied
    into the folder. For a drive that takes a current reference and an advance angle, such as paper-5-phase, the
    controller is a speed regulator with a line of angles; what it fails is waived for 90 days and is the exercise.
    """
    if kind in FILES and output is not None:
        raise click.UsageError(f"--output goes with a candidate only; NAME is the file of {FILES[kind]}")
    if kind == DRIVE:
        return _new_drive(Path(name), drive, from_datasheet)
    if from_datasheet:
        raise click.UsageError("--from-datasheet goes with the kind drive only")
    if sensorless and kind in FILES:
        raise click.UsageError("--sensorless goes with a candidate only")
    if sensorless:
        drive = _unsensed(drive)
    if kind == SCENARIO:
        return _new_scenario(Path(name), drive)
    if kind == REQUIREMENTS:
        return _new_requirements(Path(name), drive)

    from drivegate.commands.file_schemas import schema_contents
    from drivegate.results.waivers import present_day
    from drivegate.studies.new import write_candidate

    folder = Path(name) if output is None else output
    named_drive(drive)
    schemas = schema_contents("candidate", "waivers", "drive", "requirements")
    written = write_candidate(kind, name, folder, present_day(), drive, service, schemas)
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": "new",
        "candidate": {"name": name, "kind": kind},
        "folder": str(folder),
        "files": [str(file) for file in written.files],
        "next": [
            f"cd {quote(str(folder))}",
            written.first_check,
        ],
    }
    if written.hint is not None:
        document["pipeline"] = written.hint
    return Outcome(document, lambda console: _show(console, document))


def _unsensed(drive: str | None) -> str:
    """Return the drive of a controller without a position sensor."""
    chosen = named_drive(drive or SENSORLESS_DRIVE)
    if chosen is not None and chosen.position != "none":
        raise click.UsageError(
            f"--sensorless is for a drive without a position sensor, but '{drive}' has one; state position = \"none\" "
            "in its [sensing], or leave --drive out"
        )
    return drive or SENSORLESS_DRIVE


def _new_requirements(file: Path, drive: str | None) -> Outcome:
    from drivegate.commands.file_schemas import schema_line, write_missing
    from drivegate.drives.kinds import DEFAULT_DRIVES
    from drivegate.output.new_file import refuse_new_file
    from drivegate.studies.new_requirements import requirements_toml
    from drivegate_cases.documents.atomic_write import write_atomically
    from drivegate_cases.drive.drive_document import load_drive

    refuse_new_file(file, "a requirements")
    chosen = named_drive(drive) or load_drive(DEFAULT_DRIVES["duty"])
    write_atomically(file, f"{schema_line(REQUIREMENTS)}\n{requirements_toml(chosen)}")
    write_missing(REQUIREMENTS, file.parent)
    named = "" if drive is None else f" --drive {quote(drive)}"
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": "new",
        "drive": chosen.identity(),
        "folder": str(file.parent),
        "files": [file.name],
        "next": [
            f"put your requirements into {file}",
            f"drivegate check CANDIDATE{named} --requirements {quote(str(file))}",
        ],
    }
    return Outcome(document, lambda console: _show(console, document))


def _new_drive(file: Path, start: str | None, from_datasheet: bool) -> Outcome:
    if from_datasheet and start is not None:
        raise click.UsageError("--drive and --from-datasheet do not go together")

    from drivegate.commands.file_schemas import write_missing
    from drivegate.drives.kinds import DEFAULT_DRIVES
    from drivegate.output.new_file import refuse_new_file
    from drivegate.studies.data_sheet_drive import QUESTIONS, data_sheet_drive
    from drivegate.studies.new import drive_to_edit, write_drive
    from drivegate_cases.drive.drive_document import load_drive

    # Refused ahead of all questions.
    refuse_new_file(file, "a drive's")
    if from_datasheet:
        answers = {key: _answer(question) for key, question in QUESTIONS.items()}
        written = looked_at(data_sheet_drive(file.stem, answers))
    else:
        written = drive_to_edit(file.stem, named_drive(start) or load_drive(DEFAULT_DRIVES["duty"]))
    write_drive(file, written)
    write_missing("drive", file.parent)
    look = f"drivegate drive {quote(str(file))}"
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": "new",
        "drive": written.identity(),
        "folder": str(file.parent),
        "files": [file.name],
        "next": [look] if from_datasheet else [f"put your values into {file}", look],
    }
    if from_datasheet:
        document["values"] = [
            {"key": f"{table}.{key}", "value": written.value(key), "source": sentence}
            for table, sentences in written.provenance.items()
            for key, sentence in sentences.items()
        ]
    return Outcome(document, lambda console: _show(console, document))


def _new_scenario(file: Path, drive: str | None) -> Outcome:
    from drivegate.contracts.catalogue import contract_of
    from drivegate.drives.kinds import DEFAULT_DRIVES
    from drivegate.studies.new_scenario import write_scenario
    from drivegate_cases.drive.drive_document import SENSORLESS, is_included, load_drive

    chosen = DEFAULT_DRIVES["duty"] if drive is None else drive
    known = named_drive(chosen) or load_drive(chosen)
    # A file's path is read from the folder of the scenario.
    named = chosen if is_included(chosen) else str(Path(chosen).resolve())
    write_scenario(file, known, named)
    candidate = contract_of(known).usual_candidate
    if known.position == "none":
        candidate += SENSORLESS
    document: dict[str, Any] = {
        "schema": SCHEMA,
        "kind": "new",
        "scenario": {"name": file.stem, "drive": known.name},
        "folder": str(file.parent),
        "files": [file.name],
        "next": [f"drivegate simulate {candidate} --case {quote(str(file))} --plot run.svg"],
    }
    return Outcome(document, lambda console: _show(console, document))


def _answer(question: Question) -> Amount:
    """Ask on a terminal until an answer is understood; otherwise read one line, and refuse it if it is not."""
    if not sys.stdin.isatty():
        line = sys.stdin.readline()
        if not line:
            raise InputError(f"{question.quantity}: there is no answer, such as {question.examples}")
        return question.read(line.strip() or question.default)
    while True:
        text = click.prompt(
            f"{question.quantity}, such as {question.examples}\n ", default=question.default or None, err=True
        )
        try:
            return question.read(str(text))
        except InputError as error:
            click.echo(f"error: {error}", err=True)


def _show(console: Console, document: dict[str, Any]) -> None:
    from drivegate.output.console import print_line

    print_line(console, f"written into {document['folder']}:")
    for file in document["files"]:
        print_line(console, f"  {file}")
    for stated in document.get("values", []):
        assigned = f"{stated['key']} = {stated['value']:g}"
        print_line(console, f"  {assigned:<44} {stated['source']}")
    if "pipeline" in document:
        print_line(console, f"for the pipeline, {document['pipeline']}")
    joint = ", then " if "drive" in document else " && "
    print_line(console, f"next: {joint.join(document['next'])}", "dim")
