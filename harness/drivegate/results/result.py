"""The result of a check, and the document that every report is made from."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault
from drivegate.candidates.kinds import KINDS
from drivegate.checks.margin import margin_in_words
from drivegate.results.provenance import hash_of_content

if TYPE_CHECKING:
    from drivegate.checks.check import InfeasibleScenario
    from drivegate_cases.drive.drive_document import DriveDocument

RESULT_SCHEMA: Final = 2
"""Version of the result document."""
MOST_MARGINS: Final = 1000
"""Most margins of a check that a result keeps."""
STALE_WAIVERS: Final = ("waiver expired", "unexpectedly passes")
"""Verdicts of checks whose waiver has to be renewed or removed."""


def counted_levels(fail_on: str | None) -> tuple[str, ...]:
    """Return the levels of checks whose failure fails a candidate; earlier results state none, which means required."""
    return ("required", "advisory") if fail_on == "advisory" else ("required",)


@dataclass(frozen=True)
class Found:
    """What a counterexample gave."""

    margin: float
    """Its margin."""
    measured: str
    """What the margin was measured as."""
    size: int
    """How much the scenario differs from the plainest one."""
    runs: int
    """Number of runs that it took to make it simpler."""


@dataclass(frozen=True)
class Witnessed:
    """A known good controller that meets a requirement where the candidate does not."""

    name: str
    """Its name, as a candidate."""
    margin: float
    """Its margin in the scenario of the counterexample."""
    measured: str
    """What the margin was measured as."""
    knows_plant: bool
    """Whether it knows more of the drive than its nameplate states."""

    def sentence(self) -> str:
        """State that the requirement can be met, in one clause."""
        knowing = ", which knows more than its nameplate," if self.knows_plant else ""
        return f"{self.name}{knowing} meets it there with margin {margin_in_words(self.margin)}"


@dataclass(frozen=True)
class Recording:
    """Where the signals of the run that a report shows for a check are."""

    trace: int
    """Place among the recorded signals of the result."""
    start_s: float
    end_s: float
    """The stretch that the check was judged on (s)."""
    closeup: dict[str, Any] | None = None
    """The deciding moment of a counterexample, `drivegate.contracts.recorded_trace.Closeup` as plain data."""


@dataclass(frozen=True)
class FixedMargins:
    """A fixed scenario and its margins, with which a later result can be compared."""

    name: str
    """Name of the scenario."""
    scenario: dict[str, Any]
    """The scenario as plain data."""
    margins: dict[str, float]
    """Margins by check."""


@dataclass(frozen=True)
class CheckOutcome:
    """What one check came to over all runs."""

    id: str
    requirement: str
    source: str
    subject: str
    level: str
    limit: str
    """As in `drivegate.checks.check.Check`."""
    verdict: str
    """``pass``, ``fail``, ``contested``, ``waived``, ``waiver expired``, ``unexpectedly passes``,
    ``not applicable`` or ``inconclusive``."""
    margin: float | None
    """Least margin; None where the check did not apply, or depends on the machine."""
    measured: str
    """What the least margin was measured as; empty where there is none."""
    runs: int
    """Number of runs that the check applied to."""
    message: str
    """The outcome in one sentence."""
    scenario: dict[str, Any] | None
    """Worst scenario, as plain data."""
    counterexample: dict[str, Any] | None
    """When the check failed, the simplest scenario found that breaks it, as plain data."""
    found: Found | None = None
    """What the counterexample gave."""
    waiver: dict[str, Any] | None = None
    """Reason, owner, last day and margin of the waiver for the check."""
    margins: tuple[float, ...] = ()
    """Margins of all runs that decide, from the least to the greatest; of more than `MOST_MARGINS` a part
    that is spread evenly over their order. None of a check whose numbers depend on the machine."""
    recording: Recording | None = None
    """Signals of the counterexample, or of the worst scenario."""
    witness: Witnessed | None = None
    """A known good controller that meets the requirement in the counterexample; None where none did, or none was
    run."""


@dataclass(frozen=True)
class BaselineComparison:
    """How the margins of one check have changed."""

    check: str
    level: str
    """The check."""
    pairs: int
    """Number of scenarios that have a margin in both results."""
    median_change: float | None
    """Median of the new margin less the old one; None without pairs."""
    p_value: float | None
    """Probability of such a loss by chance, one-sided; None where nothing was tested."""
    verdict: str
    """``pass``, ``fail``, ``no difference`` or ``too few pairs``."""
    message: str
    """The same in one sentence."""


@dataclass(frozen=True)
class CheckResult:
    """Everything that a check of one candidate came to."""

    candidate: Candidate
    """The candidate."""
    drive: DriveDocument
    """The drive that it was checked on."""
    verdict: str
    """``pass``, ``contested``, ``waived``, ``fail``, ``waiver expired``, ``unexpectedly passes``, ``inconclusive``,
    ``harness fault``, or the kind of the candidate's fault."""
    exit_code: int
    """0, 1 or 3."""
    seed: int
    """Seed of the search."""
    effort: str
    """``quick``, ``default`` or ``nightly``."""
    checks: tuple[CheckOutcome, ...]
    """In the order of the catalogue."""
    faults: tuple[Fault, ...]
    """The candidate's faults."""
    runs: int
    """Number of runs made."""
    infeasible: tuple[InfeasibleScenario, ...]
    """Drawn scenarios that no controller could do, which were not run."""
    provenance: dict[str, Any]
    """Versions and machine-independent origin."""
    timing: dict[str, Any]
    """Times, outside the content hash, and under ``checks`` the numbers of checks that depend on the machine.
    """
    corpus_runs: int = 0
    """Number of scenarios of the corpus that were run."""
    fixed: tuple[FixedMargins, ...] = ()
    """The fixed scenarios and their margins."""
    baseline: tuple[BaselineComparison, ...] | None = None
    """How margins have changed since an earlier result; None where it was not compared with one."""
    fail_on: str = "required"
    """``required``, or ``advisory`` where advisory checks count like required ones."""
    contested: str = "pass"
    """``fail`` where failures count that no witness has shown to be avoidable, else ``pass``."""
    traces: tuple[dict[str, list[float]], ...] = ()
    """Recorded signals: lists of equal length by column."""
    behaviour: dict[str, Any] | None = None
    """What its report shows of a controller of duty ratios beside its checks; None where that was not
    measured."""
    steps: dict[str, dict[str, Any]] | None = None
    """Greatest costs of a step of an image on its target; None for other candidates."""
    focus: dict[str, Any] | None = None
    """Under ``only`` the checks that were judged (empty for all), under ``stopped_at_first`` whether the
    check ended with the first failure; None for a whole check."""
    incomplete: str | None = None
    """``interrupted`` or ``max time`` where the check ended before all of it was done; None for a check to its end."""
    isolation: tuple[str, ...] | None = None
    """The layers that isolated the candidate's processes; None for a built-in controller, which has none."""
    drive_named: str | None = None
    """The string that named the drive; None where the candidate's manifest or nothing did."""

    def document(self) -> dict[str, Any]:
        """Write the result as plain data, with what its drive can do."""
        # It brings the compiler, which reading results does not need.
        from drivegate.drives.envelope_document import envelope_of

        candidate = self.candidate
        content: dict[str, Any] = {
            "schema": RESULT_SCHEMA,
            "kind": "check",
            "candidate": {
                "name": candidate.name,
                "kind": candidate.kind,
                "specification": candidate.specification,
                "hash": candidate.content_hash,
                "declaration": asdict(candidate.declaration),
            },
            "drive": {
                **self.drive.identity(),
                "specification": self.drive_named,
                "document": self.drive.to_mapping(),
            },
            "envelope": envelope_of(self.drive),
            "verdict": self.verdict,
            "exit_code": self.exit_code,
            "seed": self.seed,
            "effort": self.effort,
            "judged_by": "own code" if KINDS[candidate.kind].is_included else "playback",
            "isolation": None if self.isolation is None else list(self.isolation),
            "fail_on": self.fail_on,
            "contested": self.contested,
            "focus": self.focus,
            "incomplete": self.incomplete,
            "checks": [asdict(outcome) for outcome in self.checks],
            "faults": [_fault_document(fault) for fault in self.faults],
            "runs": self.runs,
            "set_aside": len(self.infeasible),
            "infeasible": [asdict(drawn) for drawn in self.infeasible],
            "corpus_runs": self.corpus_runs,
            "fixed": [asdict(run) for run in self.fixed],
            "baseline": None if self.baseline is None else [asdict(entry) for entry in self.baseline],
            "traces": list(self.traces),
            "behaviour": self.behaviour,
            "steps": self.steps,
            "provenance": self.provenance,
        }
        content = _finite_table(content)
        content["provenance"] = {**content["provenance"], "content_hash": content_hash(content)}
        content["timing"] = _finite_table(self.timing)
        return content


def content_hash(document: Mapping[str, Any]) -> str:
    """Hash all that a result says but its times, a signature in it and what dying processes printed."""
    hashed = {key: value for key, value in document.items() if key not in ("timing", "signature")}
    # What a dying process printed differs from run to run.
    hashed["faults"] = [{**fault, "traceback": ""} for fault in document["faults"]]
    return hash_of_content(hashed)


def _fault_document(fault: Fault) -> dict[str, Any]:
    document = asdict(fault)
    document["kind"] = fault.kind.value
    document["time_s"] = document.pop("time")
    return document


def _finite_table(table: dict[str, Any]) -> dict[str, Any]:
    return {key: finite(item) for key, item in table.items()}


def finite(value: Any) -> Any:
    """Replace numbers that JSON cannot write by null, and tuples by lists."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return _finite_table(value)
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return value
