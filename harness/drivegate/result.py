"""The result of a check, and the document that every report is made from."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import asdict, dataclass
from typing import Any, Final

from drivegate.candidate import Candidate
from drivegate.fault import Fault

RESULT_SCHEMA: Final = 1
"""Version of the result document."""


@dataclass(frozen=True)
class CheckOutcome:
    """What one check came to over all runs.

    Attributes
    ----------
    id, requirement, source, subject, level, limit : str
        As in `drivegate.check.Check`.
    verdict : str
        ``pass``, ``fail``, ``not applicable`` or ``inconclusive``.
    margin : float or None
        Least margin; None where the check did not apply.
    measured : str
        What the least margin was measured as.
    runs : int
        Number of runs that the check applied to.
    message : str
        The outcome in one sentence.
    scenario : dict or None
        Worst scenario, as plain data.
    counterexample : dict or None
        The scenario again when the check failed.
    """

    id: str
    requirement: str
    source: str
    subject: str
    level: str
    limit: str
    verdict: str
    margin: float | None
    measured: str
    runs: int
    message: str
    scenario: dict[str, Any] | None
    counterexample: dict[str, Any] | None


@dataclass(frozen=True)
class CheckResult:
    """Everything that a check of one candidate came to.

    Attributes
    ----------
    candidate : Candidate
        The candidate.
    verdict : str
        ``pass``, ``fail``, ``inconclusive``, or the kind of the candidate's fault.
    exit_code : int
        0, 1 or 3.
    seed : int
        Seed of the search.
    effort : str
        ``quick``, ``default`` or ``nightly``.
    checks : tuple of CheckOutcome
        In the order of the catalogue.
    faults : tuple of Fault
        The candidate's faults.
    runs : int
        Number of runs made.
    set_aside : int
        Number of drawn scenarios that no angle can satisfy.
    provenance : dict
        Versions and machine-independent origin.
    timing : dict
        Times, outside the content hash.
    """

    candidate: Candidate
    verdict: str
    exit_code: int
    seed: int
    effort: str
    checks: tuple[CheckOutcome, ...]
    faults: tuple[Fault, ...]
    runs: int
    set_aside: int
    provenance: dict[str, Any]
    timing: dict[str, Any]

    def document(self) -> dict[str, Any]:
        """Write the result as plain data.

        Returns
        -------
        dict
            The result document; its provenance holds the hash of everything but `timing` and tracebacks.
        """
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
            "verdict": self.verdict,
            "exit_code": self.exit_code,
            "seed": self.seed,
            "effort": self.effort,
            "checks": [asdict(outcome) for outcome in self.checks],
            "faults": [_fault_document(fault) for fault in self.faults],
            "runs": self.runs,
            "set_aside": self.set_aside,
            "provenance": self.provenance,
        }
        content = _finite_table(content)
        # What a dying process printed differs from run to run.
        hashed = {**content, "faults": [{**fault, "traceback": ""} for fault in content["faults"]]}
        digest = hashlib.sha256(json.dumps(hashed, sort_keys=True).encode()).hexdigest()
        content["provenance"] = {**self.provenance, "content_hash": digest}
        content["timing"] = self.timing
        return content


def _fault_document(fault: Fault) -> dict[str, Any]:
    document = asdict(fault)
    document["kind"] = fault.kind.value
    document["time_s"] = document.pop("time")
    return document


def _finite_table(table: dict[str, Any]) -> dict[str, Any]:
    return {key: finite(item) for key, item in table.items()}


def finite(value: Any) -> Any:
    """Replace numbers that JSON cannot write by null, and tuples by lists.

    Parameters
    ----------
    value : object
        Plain data.

    Returns
    -------
    object
        The same with every NaN and infinity as None.
    """
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, dict):
        return _finite_table(value)
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    return value
