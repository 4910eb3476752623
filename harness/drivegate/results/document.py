"""The result document: every key with its type and meaning, and the schema made from that.

A result that is read is validated. The gate builds one with `model_construct`: its parts were checked as they were
made, and numbers that JSON cannot write become null only when they are written.
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Annotated, Any, ClassVar, Literal

from pydantic import AfterValidator, ConfigDict, Field

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import Fault
from drivegate.contracts.recorded_trace import Closeup
from drivegate.results.counterexample import resolved_script_or_scenario
from drivegate.results.result import RESULT_SCHEMA, content_hash, finite
from drivegate.results.sections import BehaviourSection, EnvelopeSection, Number
from drivegate_cases.documents.document import Document, Section, parse_document
from drivegate_cases.drive.drive_document import DriveDocument
from drivegate_models.errors import InputError


def _of_a_drive(table: dict[str, Any]) -> dict[str, Any]:
    try:
        parse_document(table, DriveDocument, "the drive")
    except InputError as error:
        raise ValueError(str(error)) from error
    return table


def _of_a_scenario(table: dict[str, Any]) -> dict[str, Any]:
    resolved_script_or_scenario(table)
    return table


Text = str
Table = dict[str, Any]
DriveTable = Annotated[Table, AfterValidator(_of_a_drive)]
ScenarioTable = Annotated[Table, AfterValidator(_of_a_scenario)]


def _declared(declaration: Declaration) -> Table:
    """Write what a candidate declares; the user's own requirements are among the checks."""
    return {key: value for key, value in asdict(declaration).items() if key != "requirements"}


class CandidateSection(Section):
    """Who was checked."""

    name: Text = Field(description="name, by which waivers are matched")
    kind: Text = Field(description="kind of candidate, such as python")
    specification: Text = Field(description="the string that named it on the command line")
    hash: Text = Field(description="hash of its sources")
    declaration: Table = Field(description="what it declares of itself")

    @classmethod
    def of(cls, candidate: Candidate) -> CandidateSection:
        return cls.model_construct(
            name=candidate.name,
            kind=candidate.kind,
            specification=candidate.specification,
            hash=candidate.content_hash,
            declaration=_declared(candidate.declaration),
        )


class DriveSection(Section):
    """The drive that a result is of."""

    name: Text = Field(description="name, by which waivers are matched")
    kind: Text = Field(description="kind of drive, such as half-bridge")
    hash: Text = Field(description="hash of its values; equal ones are the same drive, whatever it is called")
    specification: Text | None = Field(
        default=None,
        description="the string that named it on the command line; null where a manifest or nothing did",
    )
    document: DriveTable | None = Field(
        default=None, description="the drive, fully resolved; null in results of earlier versions"
    )

    @classmethod
    def of(cls, drive: DriveDocument, named: str | None) -> DriveSection:
        """Describe a drive; `named` is the string that named it."""
        table = drive.to_mapping()
        return cls.model_construct(
            name=drive.name, kind=drive.kind, hash=drive.values_hash, specification=named, document=table
        )


class FoundSection(Section):
    """What a counterexample gave."""

    margin: Number = Field(description="its margin")
    measured: Text = Field(description="what the margin was measured as")
    size: int = Field(ge=0, description="number of things that differ from the plainest scenario")
    runs: int = Field(ge=0, description="runs that it took to make it simpler")


class WitnessedSection(Section):
    """A known good controller that meets the requirement where the candidate does not."""

    name: Text = Field(description="its name, as a candidate")
    margin: Number = Field(description="its margin in the scenario of the counterexample")
    measured: Text = Field(description="what the margin was measured as")
    knows_plant: bool = Field(description="whether it knows more of the drive than its nameplate states")


class RecordingSection(Section):
    """Where the signals of the run are that a report shows for a check."""

    trace: int = Field(ge=0, description="place in the list 'traces'")
    start_s: float = Field(description="begin of the stretch that the check was judged on, in seconds")
    end_s: float = Field(description="end of that stretch, in seconds")
    closeup: Closeup | None = Field(
        default=None,
        description="the moment that decides a counterexample, with its signals; null where there is none, and in "
        "results of earlier versions",
    )


class CheckSection(Section):
    """What one check came to over all runs."""

    id: Text = Field(description="identifier, such as CNV-1")
    requirement: Text = Field(description="requirement in one sentence")
    source: Text = Field(description="what it rests on, such as P6")
    subject: Literal["candidate", "plant"] = Field(description="whose requirement it is")
    level: Literal["required", "advisory"] = Field(description="whether a failure fails the candidate")
    limit: Text = Field(description="the limit in people's units")
    verdict: Text = Field(
        description="pass, fail, contested, not yet witnessed, waived, waiver expired, unexpectedly passes, "
        "not applicable, never judged or inconclusive"
    )
    margin: Number = Field(
        description="least margin: distance from the limit over the limit, negative when not met"
    )
    measured: Text = Field(description="what the least margin was measured as")
    runs: int = Field(ge=0, description="number of runs that decide")
    message: Text = Field(description="the outcome in one sentence")
    scenario: ScenarioTable | None = Field(description="worst scenario, fully resolved")
    counterexample: ScenarioTable | None = Field(description="simplest scenario that breaks the check")
    found: FoundSection | None = Field(default=None, description="what the counterexample gave")
    evidence_for: tuple[Text, ...] = Field(
        default=(), description="your own identifiers of what the check is evidence for"
    )
    waiver: Table | None = Field(default=None, description="the waiver for the check")
    row: Table | None = Field(
        default=None, description="the user's row that was judged; left out for a check of drivegate's own"
    )
    margins: tuple[Number, ...] = Field(
        default=(),
        description="margins of all runs that decide, from the least to the greatest; an even part of over 1000",
    )
    recording: RecordingSection | None = Field(
        default=None, description="signals of the run that reports show"
    )
    witness: WitnessedSection | None = Field(
        default=None,
        description="a known good controller that meets the requirement in the counterexample; null where none did, or "
        "none was run",
    )


class FaultSection(Section):
    """A fault of the candidate, which no waiver covers."""

    kind: Text = Field(
        description="exception, crash, hang, invalid output, foreign memory, non-deterministic, sanitizer report or "
        "different builds"
    )
    message: Text = Field(description="what happened, in one sentence")
    phase: Text = Field(description="when: loading, reset or step")
    error: Text = Field(default="", description="type of the exception, or name of the signal")
    traceback: Text = Field(
        default="", description="what the candidate left behind; not part of the content hash"
    )
    step: int | None = Field(default=None, description="number of steps before")
    time_s: Number = Field(default=None, description="simulated time, in seconds")
    sense: Table | None = Field(default=None, description="what the candidate had sensed")
    scenario: ScenarioTable | None = Field(
        default=None,
        description="the scenario in which it happened, fully resolved; of a sanitizer's report the simplest that was "
        "found; null outside of a run, and in results of earlier versions",
    )

    @classmethod
    def of(cls, fault: Fault) -> FaultSection:
        stated = asdict(fault) | {"kind": fault.kind.value}
        return cls.model_construct(time_s=stated.pop("time"), **stated)


class FixedSection(Section):
    """A fixed scenario and its margins, with which later results are compared."""

    name: Text = Field(description="name of the scenario")
    scenario: ScenarioTable = Field(description="the scenario, fully resolved")
    margins: dict[str, Number] = Field(description="margins by check")


class RunSection(Section):
    """One run, with which a reviewer can find and make it again."""

    name: Text = Field(description="name of the scenario")
    seed: int = Field(ge=0, description="seed of what is random in the run")
    hash: Text = Field(description="hash of the scenario, fully resolved")
    margins: dict[str, Number] = Field(
        description="margins by check, without those that depend on the machine"
    )


class ComparisonSection(Section):
    """How the margins of one check have changed since the baseline."""

    check: Text = Field(description="identifier of the check")
    level: Text = Field(description="required or advisory")
    pairs: int = Field(ge=0, description="number of scenarios in both results")
    median_change: Number = Field(description="new margin less old one, in the median")
    p_value: Number = Field(description="probability of such a loss by chance")
    verdict: Text = Field(description="pass, fail, no difference or too few pairs")
    message: Text = Field(description="the same in one sentence")


class InfeasibleSection(Section):
    """A drawn scenario that no controller could do, and that was not run."""

    scenario: Text = Field(description="its name")
    reason: Text = Field(description="why no controller could do what it requires")


class FocusSection(Section):
    """What a check was confined to."""

    only: tuple[Text, ...] = Field(default=(), description="checks that were judged; empty for all")
    stopped_at_first: bool = Field(
        default=False, description="whether the check ended with the first failure"
    )


class MeasuredSection(Section):
    """The numbers of a check that depend on the machine."""

    margin: Number = Field(description="least margin")
    measured: Text = Field(description="what the least margin was measured as")


class ProvenanceSection(Section):
    """What computed the result; further keys name further versions."""

    model_config = ConfigDict(extra="allow")
    drivegate: Text = Field(description="version of drivegate")
    content_hash: Text | None = Field(default=None, description="hash of all but times and signature")


class TimingSection(Section):
    """Times, and what else depends on the machine."""

    model_config = ConfigDict(extra="allow")
    seconds: float = Field(default=0.0, ge=0.0, description="duration of the check, in seconds")
    checks: dict[str, MeasuredSection] = Field(
        default_factory=dict, description="numbers of the checks that depend on the machine, by identifier"
    )
    places: dict[str, str] = Field(
        default_factory=dict,
        description="ways between the report's folder and the one in which the check ran: 'to_working_folder' and "
        "'to_report'",
    )


class StepCostSection(Section):
    """A cost of the steps of an image on its target."""

    most: int = Field(ge=0, description="that of the most costly step")
    limit: int | None = Field(description="limit that the manifest states; null where it states none")
    scenario: Text = Field(description="name of the run with that step")


class StepsSection(Section):
    """What the steps of an image cost on its target."""

    instructions: StepCostSection = Field(description="instructions, those that a condition skips included")
    cycles: StepCostSection | None = Field(
        default=None, description="estimated cycles without wait states, on a Cortex-M4"
    )
    stack_bytes: StepCostSection | None = Field(default=None, description="depth of the stack, in bytes")


class CountSection(Section):
    """How much of a candidate's code was reached."""

    reached: int = Field(ge=0, description="number that ran at least once")
    total: int = Field(ge=0, description="number that there are, without what comments exclude")
    at_least_percent: float | None = Field(
        default=None, description="least share that --coverage-at-least requires; null where it requires none"
    )


class CodeFileSection(Section):
    """What was reached of one file."""

    name: Text = Field(description="path from the candidate's folder")
    unreached_lines: tuple[int, ...] = Field(default=(), description="numbers of the lines that never ran")
    unreached_branches: tuple[tuple[int, int], ...] = Field(
        default=(), description="line and place, from 1, of each way out of a line that was never taken"
    )


class CodeCoverageSection(Section):
    """What the runs reached of the candidate's code."""

    lines: CountSection = Field(description="lines of code")
    branches: CountSection = Field(description="ways out of lines with a condition")
    files: tuple[CodeFileSection, ...] = Field(default=(), description="the candidate's files")
    message: Text = Field(description="the same in one sentence")


class ResultDocument(Document):
    """The result of the check of one candidate."""

    schema_current: ClassVar[int] = RESULT_SCHEMA
    kind: Literal["check"] = Field(description="kind of document")
    candidate: CandidateSection = Field(description="who was checked")
    drive: DriveSection | None = Field(
        default=None, description="the drive that it was checked on; left out in results of earlier versions"
    )
    envelope: EnvelopeSection | None = Field(
        default=None,
        description="what the drive can do, as 'drivegate drive --json' prints it, at fewer speeds; null in results of "
        "earlier versions",
    )
    verdict: Text = Field(description="verdict on the candidate")
    exit_code: int = Field(ge=0, le=3, description="exit code of the check")
    seed: int = Field(ge=0, description="seed of the search")
    effort: Text = Field(description="quick, default or nightly")
    judged_by: Literal["playback", "own code"] = Field(
        default="own code",
        description="'playback' where the candidate's commands were played back in a process that never loaded it, "
        "'own code' where the candidate is included in drivegate and ran beside what judges it",
    )
    isolation: tuple[Literal["Landlock", "namespaces", "seccomp"], ...] | None = Field(
        default=None,
        description="what isolated the candidate's processes from the machine, empty for nothing; null for a built-in "
        "controller, which has no process of its own, and in results of earlier versions",
    )
    fail_on: Literal["required", "advisory"] = Field(
        default="required", description="'advisory' where advisory checks count like required ones"
    )
    contested: Literal["pass", "fail"] = Field(
        default="pass",
        description="'fail' where failures count that no known good controller has shown to be avoidable",
    )
    focus: FocusSection | None = Field(
        default=None, description="what the check was confined to; null for a whole one"
    )
    incomplete: Literal["interrupted", "max time"] | None = Field(
        default=None,
        description="what ended the check before all of it was done: a signal, or the option --max-time; null where "
        "nothing did",
    )
    checks: tuple[CheckSection, ...] = Field(
        description="outcome of every check that was judged, in the order of the catalogue"
    )
    faults: tuple[FaultSection, ...] = Field(description="the candidate's faults")
    runs: int = Field(ge=0, description="number of runs")
    set_aside: int = Field(ge=0, description="drawn scenarios that no controller could do")
    infeasible: tuple[InfeasibleSection, ...] = Field(
        default=(), description="those scenarios, each with the reason"
    )
    corpus_runs: int = Field(default=0, ge=0, description="number of scenarios of the corpus that were run")
    fixed: tuple[FixedSection, ...] = Field(default=(), description="fixed scenarios and their margins")
    run_list: tuple[RunSection, ...] = Field(
        default=(), description="all runs, in the order in which they are judged; empty in earlier results"
    )
    baseline: tuple[ComparisonSection, ...] | None = Field(
        default=None, description="comparison with an earlier result; null where there was none"
    )
    traces: tuple[dict[str, tuple[float, ...]], ...] = Field(
        default=(), description="recorded signals: lists of equal length by column, units in the names"
    )
    behaviour: BehaviourSection | None = Field(
        default=None,
        description="how a controller of duty ratios behaves in plain runs; null for other controllers, where not all "
        "was judged, and in results of earlier versions",
    )
    steps: StepsSection | None = Field(
        default=None,
        description="what the steps of an image cost on its target; null for other candidates and in results of "
        "earlier versions",
    )
    remarks: tuple[Text, ...] = Field(
        default=(),
        description="what a candidate in Python warned of, such as an overflow in numpy, with file and line; it fails "
        "nothing",
    )
    code_coverage: CodeCoverageSection | None = Field(
        default=None,
        description="what the runs reached of the candidate's code; null without --coverage and in results of earlier "
        "versions",
    )
    sanitizers: tuple[Text, ...] = Field(
        default=(), description="sanitizers that looked into the candidate's code, empty for none"
    )
    provenance: ProvenanceSection = Field(description="versions, commit and content hash")
    timing: TimingSection = Field(
        description="times and what else depends on the machine; not part of the content hash"
    )
    signature: dict[Text, Text] | None = Field(
        default=None,
        description="signature that an earlier version made; not checked, and not part of the content hash",
    )

    def written(self) -> dict[str, Any]:
        """Write a result that the gate made as plain data, with its content hash and what its drive can do."""
        # It brings the compiler, which reading results does not need.
        from drivegate.drives.envelope_document import envelope_of

        assert self.drive is not None
        assert self.drive.document is not None, "only results of earlier versions have no drive"
        drive = parse_document(self.drive.document, DriveDocument, "the drive")
        # What jobs made is plain data already.
        made = self.model_dump(by_alias=True, exclude={"signature"}, warnings=False)
        content: dict[str, Any] = finite(made | {"schema": RESULT_SCHEMA, "envelope": envelope_of(drive)})
        for check in content["checks"]:
            if check["row"] is None:
                del check["row"]
        for fault in content["faults"]:
            fault["time_s"] = fault.pop("time_s")
        timing = content.pop("timing")
        content["provenance"] |= {"content_hash": content_hash(content)}
        return content | {"timing": timing}


def result_schema() -> dict[str, Any]:
    schema = ResultDocument.model_json_schema(by_alias=True)
    properties = schema["properties"]
    properties["schema"] = {"const": RESULT_SCHEMA, "description": "number of the document's schema"}
    schema["required"] = ["schema", *schema["required"]]
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": f"drivegate result, schema {RESULT_SCHEMA}",
        **{key: value for key, value in schema.items() if key != "title"},
    }
