"""The part of a campaign that one task does: the runs of one file, anywhere a worker can be."""

from __future__ import annotations

import hashlib
import pickle
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault
from drivegate.containment.contained_runs import contained_runs
from drivegate.results.provenance import versions
from drivegate.studies.campaign.plan import CampaignPlan, Chunk
from drivegate.studies.campaign.row import CampaignRow, RowRequest, fault_row, run_row
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError


@dataclass(frozen=True)
class ChunkResult:
    """What the runs of one file came to."""

    chunk: Chunk
    """Which runs."""
    rows: tuple[CampaignRow, ...]
    """One for each of them."""


def packed(plan: CampaignPlan) -> bytes:
    """Make a plan ready to be sent to workers."""
    sources = tuple(fingerprint(candidate) for candidate in plan.candidates)
    return pickle.dumps((plan, sources, _versions()), pickle.HIGHEST_PROTOCOL)


def fingerprint(candidate: Candidate) -> str:
    """Hash what a candidate's files hold at this moment."""
    digest = hashlib.sha256()
    for source in candidate.sources:
        try:
            content = source.read_bytes()
        except OSError as error:
            raise InputError(
                f"{shown_path(source)}, a file of the candidate '{one_line(candidate.name)}', cannot be read by a "
                f"worker: {error.strerror}; every worker must see it at the same path"
            ) from error
        digest.update(hashlib.sha256(content).digest())
    return digest.hexdigest()


def run_chunk(package: bytes, chunk: Chunk) -> ChunkResult:
    """Make the runs of one file."""
    plan, fingerprints, required = _unpacked(package)
    _require_versions(required)
    candidate = plan.candidates[chunk.candidate]
    _require_unchanged(candidate, fingerprints[chunk.candidate])
    requests = (
        RowRequest(plan.run(number).scenario, plan.checks)
        for number in range(chunk.first, chunk.first + chunk.length)
    )
    endings = contained_runs(candidate, run_row, requests)
    rows = tuple(fault_row(ending) if isinstance(ending, Fault) else ending for ending in endings)
    _require_unchanged(candidate, fingerprints[chunk.candidate])
    return ChunkResult(chunk, rows)


@lru_cache(maxsize=2)
def _unpacked(package: bytes) -> tuple[CampaignPlan, tuple[str, ...], dict[str, Any]]:
    plan, fingerprints, required = pickle.loads(package)
    return plan, fingerprints, required


@lru_cache(maxsize=1)
def _versions() -> dict[str, Any]:
    return versions()


def _require_versions(required: dict[str, Any]) -> None:
    if required != _versions():
        raise InputError(
            f"a worker has other versions ({_in_words(_versions())}) than the campaign ({_in_words(required)}); "
            "install the same everywhere, since results of two versions are not mixed"
        )


def _in_words(told: dict[str, Any]) -> str:
    packages = ", ".join(f"{name} {number}" for name, number in told["packages"].items())
    head = f"drivegate {told['drivegate']} ({told['sources']}), Python {told['python']} on {told['machine']}"
    return one_line(f"{head}, {packages}")


def _require_unchanged(candidate: Candidate, known: str) -> None:
    if fingerprint(candidate) != known:
        raise InputError(
            f"the candidate '{one_line(candidate.name)}' has been changed since the campaign began; put it back, or "
            "begin again in a new folder"
        )
