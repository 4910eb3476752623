"""`check`, `simulate`, `compare`, `replay` and `load_drive`, which call what the commands call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, TypeAlias

from drivegate.commands.options import chosen_scenario, looked_at, named_drive
from drivegate.commands.stated_options import MANIFEST, stated_by
from drivegate.interactive.arguments import (
    candidate_text,
    named_text,
    one_of,
    optional_path,
    report_folder,
    seconds,
    settings_words,
    texts,
    whole_number,
)
from drivegate.interactive.results import CheckResult, Comparison, Replayed, Simulation
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    from drivegate.results.counterexample import Counterexample

Drive: TypeAlias = str | Path | DriveDocument
"""An included drive, a file of one, or what `load_drive` returns."""
EFFORTS: Final = ("quick", "default", "nightly")


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

    named = named_text(name, "the drive", "the name of an included drive, or a TOML or JSON file of one")
    return looked_at(load(named).with_overrides(settings_words(settings)))


def check(
    candidate: str | Path = MANIFEST,
    *,
    drive: Drive | None = None,
    effort: Literal["quick", "default", "nightly"] | None = None,
    seed: int | None = None,
    workers: int | None = None,
    max_time: float | None = None,
    search: bool = True,
    only: str | Sequence[str] = (),
    stop_at_first: bool = False,
    last_failed: bool = False,
    corpus: str | Path | None = None,
    waivers: str | Path | None = None,
    baseline: str | Path | None = None,
    requirements: str | Path | None = None,
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
    effort, seed, corpus, waivers, baseline, requirements, fail_on, contested : optional
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
        If the candidate, the drive, a file or an option is refused.
    """
    from drivegate.gate.options import CheckOptions
    from drivegate.studies.check.check_all import Records, check_all
    from drivegate.studies.check.part import Part

    if last_failed and output is None:
        raise InputError(
            "last_failed reads the last report, which is kept in a folder only; name it with output"
        )
    named = candidate_text(candidate)
    stated = stated_by(named)
    given = {
        "effort": one_of(effort, "effort", EFFORTS),
        "seed": whole_number(seed, "seed", 0),
        "fail_on": one_of(fail_on, "fail_on", ("required", "advisory")),
        "contested": one_of(contested, "contested", ("pass", "fail")),
    }
    chosen: dict[str, Any] = {
        name: stated.get(name) if value is None else value for name, value in given.items()
    }
    own_drive = _drive(drive) if drive is not None else named_drive(stated.get("drive"))
    options = CheckOptions(
        drive=own_drive,
        drive_named=drive if isinstance(drive, str) else None,
        workers=whole_number(workers, "workers", 1),
        max_time=seconds(max_time, "max_time"),
        search=search,
        **{name: value for name, value in chosen.items() if value is not None},
    )
    files = {
        name: stated.get(name) if value is None else value
        for name, value in (
            ("corpus", corpus),
            ("waivers", waivers),
            ("baseline", baseline),
            ("requirements", requirements),
        )
    }
    records = Records(**{name: optional_path(value, name) for name, value in files.items()})
    part = Part(
        texts(only, "only", "the name of a check, such as 'DEC-1', or a list of them"),
        stop_at_first,
        last_failed,
    )
    with report_folder(output) as folder:
        (checked,) = check_all(
            [named],
            folder,
            options,
            records,
            part,
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

    resolved = resolve_candidate(candidate_text(candidate))
    if not isinstance(case, Scenario):
        case = chosen_scenario(
            named_text(case, "the case", "the name of an included scenario, a file of one, or a Scenario"),
            None,
            (),
        )
    scenario = case
    if drive is not None or settings:
        chosen = scenario.drive if drive is None else _drive(drive)
        scenario = scenario.replaced(drive=looked_at(chosen.with_overrides(settings_words(settings))))
    scenario = scenario_at_declared_timing(scenario, [resolved])
    ended = simulated(resolved, scenario)
    trace = pandas.DataFrame() if isinstance(ended, Fault) else trace_frame(scenario, ended.run)
    return Simulation(document_of(resolved, scenario, ended), trace)


def compare(
    *candidates: str | Path,
    drives: Drive | Sequence[Drive] = (),
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
    drives : str, Path or DriveDocument, or a sequence of them
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
        If a candidate, a drive or an option is refused.
    """
    from drivegate.candidates.resolution import resolve_candidate
    from drivegate.studies.compare.compare import compare as compare_all
    from drivegate.studies.compare.compared_drive import ComparisonOptions

    if not candidates:
        raise InputError(
            "no candidate is named; name one or more, such as drivegate.compare('foc', 'foc-mtpa')"
        )
    named = list(map(candidate_text, candidates))
    # A name that is wrong shows here, and not after the others' runs.
    for name in named:
        resolve_candidate(name)
    options = ComparisonOptions(
        one_of(effort, "effort", EFFORTS) or "default",
        whole_number(seed, "seed", 0),
        whole_number(workers, "workers", 1),
        checks,
        cycle,
    )
    chosen = [drives] if isinstance(drives, str | Path | DriveDocument) else drives
    with report_folder(output) as folder:
        ending = compare_all(named, [_drive(drive) for drive in chosen], folder, options)
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
    from drivegate.results.counterexample import Counterexample, read_counterexample
    from drivegate.studies.replay.replay import candidate_for, document_of, replayed
    from drivegate.studies.simulate import trace_frame

    stored = counterexample
    if not isinstance(stored, Counterexample):
        what = "the file of a counterexample, or what counterexample(check) of a CheckResult returns"
        stored = read_counterexample(Path(named_text(stored, "the counterexample", what)))
    resolved = candidate_for(stored, None if candidate is None else candidate_text(candidate))
    ended = replayed(stored, resolved)
    trace = pandas.DataFrame()
    # A script is run on no plant.
    if isinstance(stored.scenario, Scenario) and not isinstance(ended, Fault) and ended.run is not None:
        trace = trace_frame(stored.scenario, ended.run)
    return Replayed(document_of(stored, resolved, ended), trace)


def _drive(drive: Drive) -> DriveDocument:
    return drive if isinstance(drive, DriveDocument) else load_drive(drive)
