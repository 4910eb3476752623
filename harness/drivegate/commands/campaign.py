"""``drivegate campaign``: candidates, cases, parameters and drawn drives, in as many runs as that makes."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from shlex import quote
from typing import TYPE_CHECKING, Any

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import bounded, json_option
from drivegate.output.failure import ExitCode

if TYPE_CHECKING:
    from rich.console import Console


@click.command("campaign")
@click.argument("file", metavar="FILE.toml")
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    default="drivegate-campaign",
    show_default=True,
    help="Folder of the results; the same command goes on with what is there.",
)
@click.option(
    "--workers",
    type=click.IntRange(1, 1024),
    help="Local processes; by default as many as there are processors.",
)
@click.option(
    "--backend",
    type=click.Choice(["local", "dask"]),
    default="local",
    show_default=True,
    help="Processes on this machine, or an existing dask cluster.",
)
@click.option(
    "--scheduler", metavar="ADDRESS", help="Scheduler of the dask cluster, such as tcp://host:8786."
)
@click.option(
    "--confidence",
    type=bounded(0.5, 0.999999),
    default="0.95",
    show_default=True,
    help="Confidence of the intervals of probabilities.",
)
@json_option
def command(
    file: str, output: Path, workers: int | None, backend: str, scheduler: str | None, confidence: float
) -> Outcome:
    """Run the campaign of FILE.toml, or go on with it.

    Every candidate meets every case, at every point of a grid of parameters, with as many drives as are drawn. The
    results are a Parquet dataset in the output folder, the same bytes whatever the backend and the number of workers.
    A candidate's fault is a result too: the exit code is 0 when the campaign is complete.
    """
    _check_options(backend, scheduler, workers)

    from drivegate.containment.backend import Backend
    from drivegate.studies.campaign.file import read_campaign
    from drivegate.studies.campaign.table import require_parquet

    require_parquet("a campaign")
    where = Backend(backend, workers, scheduler)
    where.require()
    campaign = read_campaign(file)

    from drivegate.output.progress import progress_on, with_rate
    from drivegate.studies.campaign.engine import make_runs
    from drivegate.studies.campaign.folder import CampaignFolder
    from drivegate.studies.campaign.plan import planned
    from drivegate.studies.campaign.summary import broken_harness, summarised

    plan = planned(campaign, Path(file).resolve().parent)
    began = time.monotonic()
    with CampaignFolder(output, plan) as folder:
        with progress_on(sys.stderr) as display:
            made = make_runs(plan, folder, where, with_rate(display, campaign.name, plan.runs))
        document = summarised(plan, folder, confidence)
    timing = {"seconds": time.monotonic() - began, "runs_made": made}
    document |= {"output": str(output), "timing": timing}
    code = ExitCode.HARNESS_FAULT if broken_harness(document) else ExitCode.PASSED
    return Outcome(document, lambda console: _show(console, document), code)


def _check_options(backend: str, scheduler: str | None, workers: int | None) -> None:
    if backend == "dask" and scheduler is None:
        raise click.UsageError("--backend dask needs --scheduler ADDRESS, such as tcp://127.0.0.1:8786")
    if backend == "local" and scheduler is not None:
        raise click.UsageError("--scheduler goes with --backend dask only")
    if backend == "dask" and workers is not None:
        raise click.UsageError("--workers goes with --backend local only; a dask cluster has its own")


def _show(console: Console, document: dict[str, Any]) -> None:
    from drivegate.output.console import number, plain, table

    percent = f"{100.0 * document['confidence']:g} %"
    for candidate in document["candidates"]:
        verdicts = ", ".join(f"{count} {verdict}" for verdict, count in candidate["verdicts"].items())
        heading = f"{candidate['name']}: {verdicts}"
        columns = (
            "runs",
            "violations",
            "probability",
            f"{percent} interval",
            "worst margin",
            "5 %",
            "median",
        )
        listed = table("check", "level", *columns, "worst run", right=(*columns, "worst run"), title=heading)
        for check in candidate["checks"]:
            # The least, the 5 % quantile and the median.
            margins = dict(zip(document["quantiles"], check["margin_quantiles"], strict=False))
            listed.add_row(
                check["id"],
                check["level"],
                *_counted(check),
                *(number(margins.get(share)) for share in (0.0, 0.05, 0.5)),
                "–" if check["worst_run"] is None else str(check["worst_run"]),
            )
        listed.add_row("any required", "", *_counted(candidate["not_passed"]), "", "", "", "")
        console.print(listed)
        for fault in candidate["first_faults"]:
            console.print(
                plain(f"{fault['verdict']}: first in run {fault['run']}, {fault['file']}", "bold red")
            )
    console.print(plain(f"results: {document['output']}"))
    hint = _hint(document)
    if hint:
        console.print(plain(f"next: {hint}", "dim"))


def _counted(stated: dict[str, Any]) -> tuple[str, str, str, str]:
    if not stated["runs"]:
        return "0", "–", "–", "–"
    low, high = stated["interval"]
    return (
        str(stated["runs"]),
        str(stated["violations"]),
        f"{stated['probability']:.4g}",
        f"{low:.3g} to {high:.3g}",
    )


def _hint(document: dict[str, Any]) -> str:
    for candidate in document["candidates"]:
        for check in candidate["checks"]:
            if check["counterexample"]:
                return f"drivegate replay {quote(document['output'] + '/' + check['counterexample'])}"
    return ""
