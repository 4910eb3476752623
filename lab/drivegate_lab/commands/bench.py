"""``drivegate bench``: how fast drivegate is on this machine, each number with a check of its result."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import json_option
from drivegate.output.failure import ExitCode

if TYPE_CHECKING:
    from collections.abc import Sequence

    from rich.console import Console

    from drivegate_lab.bench.plan import Planned
    from drivegate_lab.bench.record import BenchRow
    from drivegate_lab.bench.workbench import Workbench


@click.command("bench")
@click.option("--quick", is_flag=True, help="Few and short rounds, and the gate at quick effort.")
@click.option(
    "--cold",
    is_flag=True,
    help="Also measure a check on each kind of drive, warm and with nothing compiled.",
)
@click.option(
    "--only",
    "names",
    metavar="NAME",
    multiple=True,
    help="Measure only this row, or group of rows such as loop, loop.python or steady; may be given again.",
)
@click.option(
    "--compare",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Compare each number with that of a file that --output wrote before.",
)
@click.option(
    "--output", type=click.Path(path_type=Path), metavar="FILE", help="Keep the document in a JSON file."
)
@json_option
def command(
    quick: bool, cold: bool, names: tuple[str, ...], compare: Path | None, output: Path | None
) -> Outcome:
    """Measure how fast drivegate is on this machine.

    Each number is the best of several rounds, and its work is checked: the exit code is 1 when one gave a
    wrong result. A bar that is missed is reported, and changes no exit code.
    """
    from drivegate_lab.bench.plan import planned

    plan = planned(quick=quick, cold=cold)
    return bench_outcome(
        "drivegate bench", plan, quick=quick, cold=cold, names=names, compare=compare, output=output
    )


def bench_outcome(
    program: str,
    plan: Sequence[Planned],
    *,
    quick: bool,
    cold: bool,
    names: tuple[str, ...],
    compare: Path | None,
    output: Path | None,
) -> Outcome:
    """Measure what is chosen from a plan; compare and keep it where requested."""
    from drivegate.containment.temporary_folder import temporary_folder
    from drivegate_lab.bench.plan import chosen
    from drivegate_lab.bench.record import bench_document, compared_with, load_now, read_bench, save_bench
    from drivegate_lab.bench.workbench import Workbench

    plan = chosen(plan, names)
    earlier = None if compare is None else read_bench(compare)
    if output is not None:
        _check_output(output)

    from datetime import UTC, datetime

    began, started, load_before = time.monotonic(), datetime.now(UTC), load_now()
    with temporary_folder() as scratch:
        rows = _measured(plan, Workbench(scratch, quick))
    document = bench_document(
        rows,
        command=_command(program, quick, cold, names),
        started=started,
        seconds=time.monotonic() - began,
        load_average=(load_before, load_now()),
    )
    if earlier is not None and compare is not None:
        document = compared_with(document, earlier, compare)
    if output is not None:
        save_bench(document, output)
    code = ExitCode.PASSED if document["valid"] else ExitCode.FAILED
    return Outcome(document, lambda console: _show(console, document, output), code)


def _check_output(output: Path) -> None:
    from drivegate.output.trace_files import check_writable
    from drivegate_cases.documents.wording import one_line, shown_path
    from drivegate_models.errors import InputError

    if output.suffix.lower() != ".json":
        raise InputError(
            f"--output {shown_path(output)}: the name ends in '{one_line(output.suffix)}', but must end in .json"
        )
    check_writable(output)


def _command(program: str, quick: bool, cold: bool, names: tuple[str, ...]) -> str:
    words = [program, *(["--quick"] if quick else []), *(["--cold"] if cold else [])]
    return " ".join((*words, *(f"--only {quote(name)}" for name in names)))


def _measured(plan: Sequence[Planned], bench: Workbench) -> list[BenchRow]:
    from drivegate.drives.kinds import DRIVE_KINDS
    from drivegate.gate.warm_up import compile_missing
    from drivegate.output.progress import progress_on
    from drivegate_cases.drive.drive_document import load_drive

    # A gate starts its own processes; everything else is compiled by the first round, which is not timed.
    names = {one.name for one in plan}
    warm = [kind for kind in DRIVE_KINDS.values() if f"gate.warm.{kind.name}" in names]
    compile_missing(load_drive(kind.default_drive) for kind in warm)
    rows = []
    with progress_on(sys.stderr) as display:
        display.begin("bench", len(plan))
        for done, one in enumerate(plan):
            display.advance(done, len(plan), one.name)
            rows.append(one.row(bench))
        display.advance(len(plan), len(plan), "done", always=True)
    return rows


def _show(console: Console, document: dict[str, Any], output: Path | None) -> None:
    from drivegate.output.console import plain, table

    compared = document["compared"]
    numbers = ("best", "median", "bar", *(("earlier", "× as good") if compared else ()))
    listed = table("name", "what", "unit", *numbers, "check", right=numbers, title=_where(document))
    for row in document["rows"]:
        listed.add_row(
            plain(row["name"]),
            plain(row["title"]),
            plain(row["unit"]),
            *(plain(text, style) for text, style in _cells(row, compared is not None)),
            plain(row["check"], "" if row["valid"] else "yellow" if row["valid"] is None else "bold red"),
        )
    console.print(listed)
    missed = [row["name"] for row in document["rows"] if _misses_bar(row)]
    if missed:
        console.print(
            plain(f"below the bar on this machine and under this load: {', '.join(missed)}", "yellow")
        )
    if not document["valid"]:
        wrong = ", ".join(row["name"] for row in document["rows"] if row["valid"] is False)
        console.print(plain(f"wrong results, so that their times say nothing: {wrong}", "bold red"))
    if compared and not compared["same_machine"]:
        console.print(plain(f"{compared['file']} was measured on another machine", "yellow"))
    if output is not None:
        console.print(plain(f"written: {output}"))
    elif not compared:
        console.print(
            plain("next: the same with --output bench.json, and later with --compare bench.json", "dim")
        )


def _where(document: dict[str, Any]) -> str:
    machine = document["machine"]
    loads = " and ".join("unknown" if load is None else f"{load:.2f}" for load in document["load_average"])
    return (
        f"{document['command']}: {machine['processor']}, {machine['processors']} processors, load {loads}, "
        f"{document['started_utc']}"
    )


def _cells(row: dict[str, Any], compared: bool) -> list[tuple[str, str]]:
    style = "" if row["valid"] else "dim"
    cells = [(_number(row["value"]), style), (_number(row["median"]), "dim")]
    bar = "" if row["bar"] is None else f"{'≥' if row['better'] == 'more' else '≤'} {_number(row['bar'])}"
    cells.append((bar, "yellow" if _misses_bar(row) else "dim"))
    if compared:
        ratio = row["times_as_good"]
        cells += [(_number(row["earlier"]), "dim"), ("–" if ratio is None else f"{ratio:.3f}", "")]
    return cells


def _misses_bar(row: dict[str, Any]) -> bool:
    bar, value = row["bar"], row["value"]
    if bar is None or value is None or not row["valid"]:
        return False
    return bool(value < bar if row["better"] == "more" else value > bar)


def _number(value: float | None) -> str:
    if value is None:
        return "–"
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.3g}"
