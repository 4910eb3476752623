"""`check`, `simulate`, `compare`, `replay` and `load_drive`, which call what the commands call."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeAlias

from drivegate.commands.options import chosen_scenario, looked_at, named_drive
from drivegate.commands.stated_options import MANIFEST, stated_by
from drivegate.interactive.results import CheckResult, Comparison, Replayed, Simulation
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario

if TYPE_CHECKING:
    from drivegate.results.counterexample import Counterexample

Drive: TypeAlias = str | Path | DriveDocument
"""An included drive, a file of one, or what `load_drive` returns."""


def load_drive(name: str | Path, settings: Mapping[str, Any] | None = None) -> DriveDocument:
    """Load an included drive, or a TOML or JSON file of one.

    Parameters
    ----------
    name : str or Path
        Its name or file, as ``--drive`` takes it.
    settings : mapping, optional
        Values of single keys, such as ``{"machine.resistance_ohm": 0.1}``.

    Returns
    -------
    DriveDocument
        The drive.

    Raises
    ------
    drivegate.InputError
        If there is no such drive or key, or a value is outside its bounds.
    """
    from drivegate_cases.drive.drive_document import load_drive as load

    drive = load(str(name))
    return looked_at(drive.with_overrides([f"{key}={value}" for key, value in (settings or {}).items()]))


def check(
    candidate: str | Path = MANIFEST,
    *,
    drive: Drive | None = None,
    effort: Literal["quick", "default", "nightly"] | None = None,
    seed: int | None = None,
    workers: int | None = None,
    max_time: float | None = None,
    search: bool = True,
    only: Sequence[str] = (),
    stop_at_first: bool = False,
    last_failed: bool = False,
    corpus: str | Path | None = None,
    waivers: str | Path | None = None,
    baseline: str | Path | None = None,
    fail_on: Literal["required", "advisory"] | None = None,
    contested: Literal["pass", "fail"] | None = None,
    output: str | Path | None = None,
    quiet: bool = True,
) -> CheckResult:
    """Check a candidate, as ``drivegate check`` does.

    Parameters
    ----------
    candidate : str or Path
        What the command takes, such as ``"controller.py:Controller"``. By default the manifest in this folder.
    drive : str, Path or DriveDocument, optional
        By default that of the manifest, or the default drive of the candidate's contract.
    effort, seed, corpus, waivers, baseline, fail_on, contested : optional
        Options of the command. By default what the table ``[check]`` of the manifest states, else those of the
        command.
    workers, max_time, search, only, stop_at_first, last_failed : optional
        Further options of the command.
    output : str or Path, optional
        Folder of the report. By default no report is kept.
    quiet : bool
        False prints the progress to standard error.

    Returns
    -------
    CheckResult
        The verdict, a table of the checks, counterexamples and traces.

    Raises
    ------
    drivegate.InputError
        If the candidate, the drive or a file is refused.
    """
    from drivegate.gate.options import CheckOptions
    from drivegate.studies.check.check_all import Records, check_all
    from drivegate.studies.check.part import Part

    stated = stated_by(str(candidate))
    given = {"effort": effort, "seed": seed, "fail_on": fail_on, "contested": contested}
    chosen: dict[str, Any] = {
        name: stated.get(name) if value is None else value for name, value in given.items()
    }
    own_drive = _drive(drive) if drive is not None else named_drive(stated.get("drive"))
    options = CheckOptions(
        drive=own_drive,
        drive_named=drive if isinstance(drive, str) else None,
        workers=workers,
        max_time=max_time,
        search=search,
        **{name: value for name, value in chosen.items() if value is not None},
    )
    files = {
        name: stated.get(name) if value is None else value
        for name, value in (("corpus", corpus), ("waivers", waivers), ("baseline", baseline))
    }
    records = Records(**{name: None if value is None else Path(value) for name, value in files.items()})
    with _report_folder(output) as folder:
        (checked,) = check_all(
            [str(candidate)],
            folder,
            options,
            records,
            Part(tuple(only), stop_at_first, last_failed),
            quiet=quiet,
        )
        if checked.document is None:
            assert checked.error is not None, "without a result there is a reason"
            raise checked.error
    return CheckResult(checked.document, None if output is None else checked.folder)


def simulate(
    candidate: str | Path,
    case: str | Path | Scenario,
    *,
    drive: Drive | None = None,
    settings: Mapping[str, Any] | None = None,
) -> Simulation:
    """Run a candidate once through a scenario, as ``drivegate simulate`` does.

    Parameters
    ----------
    candidate : str or Path
        What the command takes.
    case : str, Path or Scenario
        An included scenario, or a file of one, also of a counterexample.
    drive : str, Path or DriveDocument, optional
        By default the scenario's.
    settings : mapping, optional
        Values of single keys of the drive, such as ``{"machine.resistance_ohm": 0.1}``.

    Returns
    -------
    Simulation
        The trace as a data frame, and the summary.

    Raises
    ------
    drivegate.InputError
        If the candidate, the scenario or the drive is refused.
    """
    import pandas

    from drivegate.candidates.fault import Fault
    from drivegate.candidates.resolution import resolve_candidate
    from drivegate.drives.kinds import scenario_at_declared_timing
    from drivegate.studies.simulate import document_of, simulated, trace_frame

    resolved = resolve_candidate(str(candidate))
    scenario = case if isinstance(case, Scenario) else chosen_scenario(str(case), None, ())
    if drive is not None or settings:
        chosen = scenario.drive if drive is None else _drive(drive)
        words = [f"{key}={value}" for key, value in (settings or {}).items()]
        scenario = scenario.replaced(drive=looked_at(chosen.with_overrides(words)))
    scenario = scenario_at_declared_timing(scenario, [resolved])
    ended = simulated(resolved, scenario)
    trace = pandas.DataFrame() if isinstance(ended, Fault) else trace_frame(scenario, ended.run)
    return Simulation(document_of(resolved, scenario, ended), trace)


def compare(
    *candidates: str | Path,
    drives: Sequence[Drive] = (),
    effort: Literal["quick", "default", "nightly"] = "default",
    seed: int | None = None,
    workers: int | None = None,
    checks: bool = True,
    cycle: str | None = None,
    output: str | Path | None = None,
) -> Comparison:
    """Compare candidates over the same operating points, as ``drivegate compare`` does.

    Parameters
    ----------
    *candidates : str or Path
        What the command takes.
    drives : sequence of str, Path or DriveDocument
        By default the candidates' own drive.
    effort, seed, workers, checks, cycle : optional
        Options of the command.
    output : str or Path, optional
        Folder of the report. By default no report is kept.

    Returns
    -------
    Comparison
        The tables of the report as data frames.

    Raises
    ------
    drivegate.InputError
        If a candidate or a drive is refused.
    """
    from drivegate.studies.compare.compare import compare as compare_all
    from drivegate.studies.compare.compared_drive import ComparisonOptions

    options = ComparisonOptions(effort, seed, workers, checks, cycle)
    with _report_folder(output) as folder:
        ending = compare_all(list(map(str, candidates)), [_drive(drive) for drive in drives], folder, options)
    for _, error in ending.refused:
        raise error
    assert ending.document is not None, "no candidate was refused"
    return Comparison(ending.document, () if output is None else ending.pages)


def replay(counterexample: str | Path | Counterexample, candidate: str | Path | None = None) -> Replayed:
    """Run a counterexample again, as ``drivegate replay`` does.

    Parameters
    ----------
    counterexample : str, Path or Counterexample
        A file of one, or what `CheckResult.counterexample` returns.
    candidate : str or Path, optional
        The candidate to run; by default the one that is named in it, if it is included in drivegate.

    Returns
    -------
    Replayed
        Whether the check still fails, and the trace as a data frame.

    Raises
    ------
    drivegate.InputError
        If the file or the candidate is refused.
    """
    import pandas

    from drivegate.candidates.fault import Fault
    from drivegate.results.counterexample import read_counterexample
    from drivegate.studies.replay.replay import candidate_for, document_of, replayed
    from drivegate.studies.simulate import trace_frame

    stored = (
        read_counterexample(Path(counterexample))
        if isinstance(counterexample, str | Path)
        else counterexample
    )
    resolved = candidate_for(stored, None if candidate is None else str(candidate))
    ended = replayed(stored, resolved)
    trace = pandas.DataFrame()
    # A script is run on no plant.
    if isinstance(stored.scenario, Scenario) and not isinstance(ended, Fault) and ended.run is not None:
        trace = trace_frame(stored.scenario, ended.run)
    return Replayed(document_of(stored, resolved, ended), trace)


def _drive(drive: Drive) -> DriveDocument:
    return drive if isinstance(drive, DriveDocument) else load_drive(drive)


@contextmanager
def _report_folder(output: str | Path | None) -> Iterator[Path]:
    """Return the folder of a report, which is deleted at the end unless it was named."""
    if output is not None:
        yield Path(output)
        return
    with tempfile.TemporaryDirectory(prefix="drivegate-") as scratch:
        yield Path(scratch) / "report"
