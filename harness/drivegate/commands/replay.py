"""``drivegate replay``: run a counterexample again, or every one of a folder."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from drivegate.commands.completion import complete_candidate
from drivegate.commands.conduct import Outcome
from drivegate.commands.options import isolation_options, json_option


@click.command("replay")
@click.argument("file", type=click.Path(path_type=Path), metavar="FILE|FOLDER")
@click.option(
    "--candidate",
    metavar="CANDIDATE",
    shell_complete=complete_candidate,
    help="The candidate to run; by default the file's, if it comes with drivegate.",
)
@click.option(
    "--plot",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Write a figure; the name ends in .png or .svg.",
)
@isolation_options
@json_option
def command(file: Path, candidate: str | None, plot: Path | None) -> Outcome:
    """Run the counterexample in FILE again, and show whether its check STILL FAILS or is FIXED.

    Of a FOLDER, such as drivegate-report, every counterexample is run again, and shown on one line.

    The exit code is 1 when one still fails, or is not reproduced by the very candidate that was at fault; it is 0 when
    all are fixed or do not apply to the candidate. Of a folder, advisory checks do not count.
    """
    if file.is_dir():
        if plot is not None:
            raise click.UsageError(
                "--plot draws one counterexample, but a folder is named; name one of its files"
            )
        return _replay_all(file, candidate)
    from drivegate.output.trace_files import check_targets
    from drivegate.results.counterexample import read_counterexample

    stored = read_counterexample(file)
    check_targets(None, None, plot)

    from drivegate.candidates.fault import Fault
    from drivegate.studies.replay.display import draw, next_step, show_replay
    from drivegate.studies.replay.replay import candidate_for, document_of, replayed

    resolved = candidate_for(stored, candidate)
    ended = replayed(stored, resolved)
    document = document_of(stored, resolved, ended)
    if plot is not None and not isinstance(ended, Fault):
        title = f"{stored.check} {document['verdict']}: {resolved.name}, {stored.scenario.name}"
        draw(stored, ended, plot, title)
        document["files"] = [str(plot)]
    hint = next_step(document, file, candidate)
    return Outcome(document, lambda console: show_replay(console, document, hint), document["exit_code"])


def _replay_all(folder: Path, candidate: str | None) -> Outcome:
    from drivegate.output.progress import progress_on
    from drivegate.output.waiting import with_compiled_kernels
    from drivegate.studies.replay.display import next_step_of_all, show_all_replays
    from drivegate.studies.replay.folder import document_of_all, kept_in, replayed_all

    all_kept = kept_in(folder, candidate)
    with_compiled_kernels(kept.stored.scenario.drive for kept in all_kept)
    with progress_on(sys.stderr) as display:
        document = document_of_all(folder, replayed_all(all_kept, display))
    hint = next_step_of_all(document, candidate)
    return Outcome(document, lambda console: show_all_replays(console, document, hint), document["exit_code"])
