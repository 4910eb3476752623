"""Running a counterexample again: whether its check still fails, and where in the run that shows."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from shlex import quote
from typing import Any, Final

from numpy.typing import NDArray

import drivegate_models
from drivegate import version
from drivegate.candidates.builtin.candidates import is_builtin_name
from drivegate.candidates.candidate import Candidate
from drivegate.candidates.contract import ANSWERS
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import Fault
from drivegate.candidates.kinds import KINDS
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import Check
from drivegate.checks.margin import Margin, Moment
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.catalogue import check_of as check_named
from drivegate.contracts.catalogue import contract_of, on_drive
from drivegate.contracts.contract import RecordedTrace
from drivegate.contracts.current.flowchart.judging import judge_script
from drivegate.contracts.parting import SEED_IN_RESET, empty_commands
from drivegate.contracts.recorded_trace import deciding_moment, trace_of_run
from drivegate.drives.kinds import drive_for
from drivegate.drives.running import recorded, with_repetitions
from drivegate.gate.own_requirements import with_requirements
from drivegate.gate.plan import REPEATED
from drivegate.gate.repetition import Repetition, different_elsewhere, explanation_jobs, repetition_job
from drivegate.output.waiting import report_slow, with_compiled_kernels
from drivegate.results.counterexample import Counterexample
from drivegate.results.provenance import versions
from drivegate.results.result import finite
from drivegate.studies.simulate import MOST_ROWS
from drivegate_cases.documents.wording import one_line
from drivegate_cases.drive.drive_document import DriveDocument, is_included, load_drive
from drivegate_cases.requirements.file import OwnRequirements
from drivegate_cases.scenario.scenario import Scenario
from drivegate_cases.scenario.script import Script
from drivegate_models.errors import InputError

SCHEMA: Final = 1
STILL_FAILS: Final = "still fails"
FIXED: Final = "fixed"
NOT_REPRODUCED: Final = "not reproduced"
"""Verdict where nothing was changed and the check is met all the same."""
NOT_APPLICABLE: Final = "not applicable"
VERDICTS: Final = (STILL_FAILS, NOT_REPRODUCED, FIXED, NOT_APPLICABLE)
_PARTED: Final = (
    "two runs of the same scenario differ: neither the candidate nor drivegate has changed since then, and the margin "
    f"has; {SEED_IN_RESET}"
)


@dataclass(frozen=True)
class Replay:
    """The outcome of running a counterexample again."""

    margin: Margin | None
    """The check's margin; None where the check has nothing to judge."""
    run: Any = None
    """The run of the scenario's contract, with its trace; None of a script."""
    moment: Moment | None = None
    """The stretch of the run that decides, and what a figure marks there; None of a script."""
    rows: tuple[int, int] | None = None
    """First and last row of a script that the check was judged on, counted from 1; None of a scenario."""
    steps: NDArray[Any] | None = None
    """What the controller sensed and answered, as in `Record.steps`; None of a script."""

    @property
    def window(self) -> tuple[float, float] | None:
        """Start and end of the stretch that the check was judged on (s); None of a script."""
        return None if self.moment is None else (self.moment.start_s, self.moment.end_s)


def candidate_for(stored: Counterexample, given: str | None) -> Candidate:
    """Choose the candidate to run: the given one, or the one that comes with drivegate and has the file's name.

    A file never says what is executed: its candidate's name is looked up among those that are included.
    """
    if given is not None:
        return resolve_candidate(given)
    name = stored.candidate.name
    if is_builtin_name(name):
        candidate = resolve_candidate(name)
        if _is_included(candidate):
            return candidate
    raise InputError(
        f"the counterexample is about the candidate '{one_line(name)}', which does not come with drivegate; "
        "say which one to run with --candidate, such as --candidate controller.py:Controller"
    )


def _is_included(candidate: Candidate) -> bool:
    """Return True if all of a candidate's code is drivegate's own; resolving it has run none."""
    if KINDS[candidate.kind].is_included:
        return True
    homes = [Path(package.__file__ or "").resolve().parent for package in (version, drivegate_models)]
    inside = (any(source.is_relative_to(home) for home in homes) for source in candidate.sources)
    return bool(candidate.sources) and all(inside)


def _own(stored: Counterexample) -> OwnRequirements | None:
    """Return the user's row that a counterexample breaks, as it was then; None where it breaks a check."""
    return None if stored.row is None else OwnRequirements((stored.row,))


def replayed(stored: Counterexample, candidate: Candidate) -> Replay | Fault:
    required = stored.scenario.drive.contract
    if candidate.contract not in (None, required):
        raise InputError(
            f"the candidate '{one_line(candidate.name)}' answers with {ANSWERS[str(candidate.contract)]}, but the "
            f"counterexample's drive takes {ANSWERS[required]}; name a candidate that answers so with --candidate"
        )
    with_compiled_kernels([stored.scenario.drive])
    candidate = with_requirements(candidate, _own(stored))
    with Judge(candidate, on_slow=report_slow) as judge:
        replay = judge.run(Job(run_replay, stored))
        if isinstance(replay, Fault) or isinstance(stored.scenario, Script) or stored.check != REPEATED:
            return replay
        return _repeated_elsewhere(judge, replay, stored.scenario)


def _repeated_elsewhere(judge: Judge, replay: Replay, scenario: Scenario) -> Replay | Fault:
    if replay.margin is None or not replay.margin.met or replay.run is None:
        return replay
    elsewhere = judge.run(repetition_job(scenario))
    if isinstance(elsewhere, Fault):
        return elsewhere
    if elsewhere.digest == replay.run.digest:
        return replay
    endings: list[Repetition | Fault] = []
    for job in explanation_jobs(scenario):
        # Without the name, mypy would expect jobs whose results may be faults.
        ending = judge.run(job)
        endings.append(ending)
    return replace(replay, margin=different_elsewhere(scenario, endings))


def run_replay(loaded: JudgedCandidate, stored: Counterexample) -> Replay:
    if isinstance(stored.scenario, Script):
        return _script_again(loaded, stored.scenario)
    return _scenario_again(loaded, stored.scenario, check_of(stored))


def _scenario_again(loaded: JudgedCandidate, scenario: Scenario, check: Check) -> Replay:
    controller = loaded.controller()
    every = -(-scenario.control_periods // MOST_ROWS)
    kept = empty_commands(scenario) if check.id == REPEATED else None
    record = recorded(loaded, scenario, controller, trace_every=every, kept=kept, keeps_steps=True)
    if kept is not None:
        record = with_repetitions(loaded, record, kept, controller)
    applies = check.reason_not_applicable(record.declaration, scenario.drive) is None
    margin = check.evaluate(record) if applies else None
    return Replay(margin, record.run, deciding_moment(check, record, margin), steps=record.steps)


def _script_again(loaded: JudgedCandidate, script: Script) -> Replay:
    profile = loaded.candidate.declaration.flowchart
    if profile is None:
        return Replay(None, rows=(1, len(script.rows)))
    verdict = judge_script(loaded.controller(), profile, script)
    # A script is followed up to the first departure, which is in the last row that was looked at.
    first = 1 if verdict.margin.met else verdict.rows
    return Replay(verdict.margin, rows=(first, verdict.rows))


def check_of(stored: Counterexample) -> Check:
    scenario = stored.scenario
    contract = "current" if isinstance(scenario, Script) else scenario.drive.contract
    return check_named(contract, stored.check, Declaration(requirements=_own(stored)))


def _trace(stored: Counterexample, ended: Replay | Fault) -> RecordedTrace | None:
    """Return the signals of what was run; None where that was on no plant."""
    if isinstance(ended, Fault) or ended.run is None or ended.window is None:
        return None
    assert isinstance(stored.scenario, Scenario), "a script is run on no plant"
    return trace_of_run(stored.scenario, ended.run, ended.window)


def marked_angle(stored: Counterexample, ended: Replay) -> tuple[float, float] | None:
    """Return from when on, and at what angle, a plot marks the feasible edge; None where there is none."""
    trace = _trace(stored, ended)
    return None if trace is None else contract_of(trace.scenario.drive).marked_angle(trace)


def verdict_on(ended: Replay | Fault, remark: str) -> str:
    if isinstance(ended, Fault):
        return STILL_FAILS
    if ended.margin is None:
        return NOT_APPLICABLE
    if not ended.margin.met:
        return STILL_FAILS
    return NOT_REPRODUCED if remark else FIXED


def remark_on(stored: Counterexample, candidate: Candidate, ended: Replay | Fault) -> str:
    """State that the same candidate has another margin than then, which the same commands cannot give."""
    if (
        isinstance(ended, Fault)
        or ended.margin is None
        or stored.margin in (None, finite(ended.margin.value))
    ):
        return ""
    # A file may also state where it was found, on which nothing depends.
    used = all(stored.versions.get(name) == number for name, number in versions().items())
    same = used and stored.candidate.hash == candidate.content_hash
    return _PARTED if same and not check_of(stored).volatile else ""


def _drive_option(drive: DriveDocument, candidate: Candidate) -> str:
    """Write the option by which ``drivegate check`` takes a drive, with a space before it; empty where none is needed.

    Of a drive that is not included only the name is known, and with it the usual name of its file.
    """

    def is_that(named: DriveDocument | None) -> bool:
        found = drive_for(candidate, named)
        return found.values_hash == drive.values_hash

    if candidate.contract in (None, drive.contract) and is_that(None):
        return ""
    included = is_included(drive.name) and is_that(load_drive(drive.name))
    return f" --drive {quote(drive.name if included else f'{drive.name}.toml')}"


def document_of(stored: Counterexample, candidate: Candidate, ended: Replay | Fault) -> dict[str, Any]:
    drive, remark = stored.scenario.drive, remark_on(stored, candidate, ended)
    trace = _trace(stored, ended)
    check = on_drive(check_of(stored), drive, candidate.declaration)
    verdict, reason = verdict_on(ended, remark), ""
    if verdict == NOT_APPLICABLE:
        reason = check.reason_not_applicable(candidate.declaration, drive) or (
            f"applies to {check.scenarios}, which this run is not"
        )
    margin = None if isinstance(ended, Fault) else ended.margin
    fault = asdict(ended) | {"kind": ended.kind.value} if isinstance(ended, Fault) else None
    failed_code = 3 if check.subject == "plant" and fault is None else 1
    return {
        "schema": SCHEMA,
        "kind": "replay",
        "verdict": verdict,
        "exit_code": failed_code if verdict in (STILL_FAILS, NOT_REPRODUCED) else 0,
        "check": check.id,
        "level": check.level,
        "requirement": check.requirement,
        "limit": check.limit,
        "candidate": {"name": candidate.name, "kind": candidate.kind, "hash": candidate.content_hash},
        "found_with": stored.candidate.model_dump(),
        "scenario": stored.scenario.name,
        "drive": drive.name,
        "drive_option": _drive_option(drive, candidate),
        "then": {"margin": stored.margin, "measured": stored.measured},
        "now": None if margin is None else {"margin": margin.value, "measured": margin.measured},
        "window_s": None if isinstance(ended, Fault) or ended.window is None else list(ended.window),
        "rows": None if isinstance(ended, Fault) or ended.rows is None else list(ended.rows),
        "account": [] if trace is None else list(contract_of(drive).account(trace)),
        "reason": reason,
        "remark": remark,
        "fault": fault,
        "files": [],
    }
