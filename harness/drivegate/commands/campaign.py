"""``drivegate campaign``: candidates, cases, parameters and drawn drives, in as many runs as that makes."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import click

from drivegate.commands.conduct import Outcome
from drivegate.commands.options import (
    WholeNumber,
    bounded,
    drive_option,
    isolation_options,
    json_option,
    looked_at,
    named_drive,
)
from drivegate.output.failure import ExitCode


@click.command("campaign")
@click.argument("file", metavar="FILE.toml")
@click.option(
    "--output",
    type=click.Path(path_type=Path),
    default="drivegate-campaign",
    show_default=True,
    help="Folder of the results; the same command goes on with what is there.",
)
@drive_option
@click.option(
    "--workers",
    type=WholeNumber(1, 1024),
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
@isolation_options
@json_option
def command(
    file: str,
    output: Path,
    drive: str | None,
    workers: int | None,
    backend: str,
    scheduler: str | None,
    confidence: float,
) -> Outcome:
    """Run the campaign of FILE.toml, or go on with it.

    Every candidate meets every case, at every point of a grid of parameters, with as many drives as are drawn. The
    results are a Parquet dataset and a page in the output folder, the same bytes whatever the backend and the number
    of workers.
    A candidate's fault is a result too: the exit code is 0 when the campaign is complete.
    """
    if backend == "dask" and scheduler is None:
        raise click.UsageError("--backend dask needs --scheduler ADDRESS, such as tcp://127.0.0.1:8786")
    if backend == "local" and scheduler is not None:
        raise click.UsageError("--scheduler goes with --backend dask only")
    if backend == "dask" and workers is not None:
        raise click.UsageError("--workers goes with --backend local only; a dask cluster has its own")

    from drivegate.containment.backend import Backend
    from drivegate.studies.campaign.file import read_campaign
    from drivegate.studies.campaign.folder import require_parquet

    require_parquet("a campaign")
    where = Backend(backend, workers, scheduler)
    where.require()
    campaign = read_campaign(file)

    from drivegate.output.progress import progress_on, with_rate
    from drivegate.studies.campaign.display import show_campaign
    from drivegate.studies.campaign.engine import make_runs, write_pages
    from drivegate.studies.campaign.folder import CampaignFolder
    from drivegate.studies.campaign.plan import planned
    from drivegate.studies.campaign.summary import broken_harness, summarised

    chosen = named_drive(drive)
    plan = planned(campaign, Path(file).resolve().parent, chosen)
    for case_drive in dict.fromkeys(case.drive for case in plan.cases if case.drive is not chosen):
        looked_at(case_drive)
    began = time.monotonic()
    with CampaignFolder(output, plan) as folder:
        with progress_on(sys.stderr) as display:
            made = make_runs(plan, folder, where, with_rate(display, campaign.name, plan.runs))
        document = summarised(plan, folder, confidence)
        document["specifications"] = [candidate.specification for candidate in plan.candidates]
        pages = write_pages(document, folder)
    timing = {"seconds": time.monotonic() - began, "runs_made": made}
    document |= {"output": str(output), "timing": timing, "pages": [str(page) for page in pages]}
    code = ExitCode.HARNESS_FAULT if broken_harness(document) else ExitCode.PASSED
    return Outcome(document, lambda console: show_campaign(console, document), code)
