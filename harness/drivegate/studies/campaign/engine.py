"""A campaign from its plan to complete files, going on from those that are there."""

from __future__ import annotations

import hashlib
import pickle
from collections import deque
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeAlias

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault
from drivegate.candidates.kinds import KINDS
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.backend import Backend, done_by
from drivegate.containment.judge import Judge, contained_runs
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.pool import WorkerPool
from drivegate.contracts.catalogue import contract_named
from drivegate.gate.warm_up import compile_missing
from drivegate.output.report_writers import CAMPAIGN_GROUP, report_points, write_reports
from drivegate.output.resumed_folder import failures_refused
from drivegate.results.provenance import versions
from drivegate.studies.campaign.folder import CampaignFolder, table_bytes
from drivegate.studies.campaign.plan import CampaignPlan, Chunk
from drivegate.studies.campaign.row import CampaignRow, RowRequest, fault_row, run_row
from drivegate_cases.documents.regular_file import regular_content
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

ReportProgress: TypeAlias = Callable[[int, int], None]
"""Takes the number of runs that are kept so far, and how many of them were there before."""


def make_runs(
    plan: CampaignPlan, folder: CampaignFolder, backend: Backend, report_progress: ReportProgress
) -> int:
    """Make every run of a campaign that is not kept yet.

    Nothing of a run stays in memory once its file is complete, so a campaign may be as long as the disk allows.
    """
    left = [chunk for chunk in plan.chunks() if not folder.is_complete(chunk)]
    missing = sum(chunk.length for chunk in left)
    before = kept = plan.runs - missing
    report_progress(kept, before)
    if not left:
        return 0
    require_loadable(plan)
    compile_missing(case.drive for case in plan.cases)
    rehearse(plan)
    parameters, checks = plan.campaign.parameters, plan.checks
    report_progress(kept, before)
    for chunk, rows in done_by(backend, run_chunk, packed(plan), left):
        runs = [plan.run(number) for number in range(chunk.first, chunk.first + chunk.length)]
        folder.write(folder.path_of(chunk), table_bytes(runs, rows, parameters, checks))
        kept += chunk.length
        report_progress(kept, before)
    return missing


def require_loadable(plan: CampaignPlan) -> None:
    """Refuse candidates that cannot be used as they are before anything is run."""
    for candidate in plan.candidates:
        if not KINDS[candidate.kind].is_included:
            with Judge(candidate) as judge:
                judge.run(Job(_load, None))


def rehearse(plan: CampaignPlan) -> None:
    """Make the first run of every case in a process that then ends, so that all others only load compiled code.

    A process that compiles a kernel itself may round it otherwise, in the last digit, than one that loads it.
    """
    step = plan.campaign.runs_per_candidate // len(plan.cases)
    requests = [RowRequest(plan.run(place * step).scenario, plan.checks) for place in range(len(plan.cases))]
    with WorkerPool(resolve_candidate(contract_named(plan.contract).rehearsed), workers=1) as pool:
        deque(pool.map([Job(_rehearsed, requests)]), maxlen=0)


def _rehearsed(loaded: JudgedCandidate, requests: list[RowRequest]) -> None:
    for request in requests:
        run_row(loaded, request)


def _load(loaded: JudgedCandidate, _payload: None) -> None:
    loaded.controller()


def write_pages(document: dict[str, Any], folder: CampaignFolder) -> tuple[Path, ...]:
    """Write every page, from the summary and the specifications of its candidates."""
    writers = {name: point.load for name, point in report_points(CAMPAIGN_GROUP).items()}
    written = write_reports(document, folder.place, writers)
    for error in written.errors.values():
        if isinstance(error, OSError):
            # A page is lost to a full disk as the results are, and made again in the same way.
            with failures_refused(folder.place, "write"):
                raise error
    written.require_all()
    return tuple(folder.place / page for page in written.pages.values())


def packed(plan: CampaignPlan) -> bytes:
    """Make a plan ready to be sent to workers."""
    sources = tuple(_fingerprint(candidate) for candidate in plan.candidates)
    return pickle.dumps((plan, sources, _versions()), pickle.HIGHEST_PROTOCOL)


def _fingerprint(candidate: Candidate) -> str:
    """Hash what a candidate's files hold at this moment."""
    digest = hashlib.sha256()
    for source in candidate.sources:
        try:
            content = regular_content(source)
        except OSError as error:
            raise InputError(
                f"{shown_path(source)}, a file of the candidate '{one_line(candidate.name)}', cannot be read by a "
                f"worker: {error.strerror}; every worker must see it at the same path"
            ) from error
        digest.update(hashlib.sha256(content).digest())
    return digest.hexdigest()


def run_chunk(package: bytes, chunk: Chunk) -> tuple[CampaignRow, ...]:
    plan, fingerprints, required = _unpacked(package)
    if required != _versions():
        raise InputError(
            f"a worker has other versions ({_in_words(_versions())}) than the campaign ({_in_words(required)}); "
            "install the same everywhere, since results of two versions are not mixed"
        )
    candidate = plan.candidates[chunk.candidate]
    _require_unchanged(candidate, fingerprints[chunk.candidate])
    requests = (
        RowRequest(plan.run(number).scenario, plan.checks)
        for number in range(chunk.first, chunk.first + chunk.length)
    )
    endings = contained_runs(candidate, run_row, requests)
    rows = tuple(fault_row(ending) if isinstance(ending, Fault) else ending for ending in endings)
    _require_unchanged(candidate, fingerprints[chunk.candidate])
    return rows


@lru_cache(maxsize=2)
def _unpacked(package: bytes) -> tuple[CampaignPlan, tuple[str, ...], dict[str, Any]]:
    plan, fingerprints, required = pickle.loads(package)
    return plan, fingerprints, required


@lru_cache(maxsize=1)
def _versions() -> dict[str, Any]:
    return versions()


def _in_words(used: dict[str, Any]) -> str:
    packages = ", ".join(f"{name} {number}" for name, number in used["packages"].items())
    head = f"drivegate {used['drivegate']} ({used['sources']}), Python {used['python']} on {used['machine']}"
    return one_line(f"{head}, {packages}")


def _require_unchanged(candidate: Candidate, known: str) -> None:
    if _fingerprint(candidate) != known:
        raise InputError(
            f"the candidate '{one_line(candidate.name)}' has been changed since the campaign began; put it back, or "
            "begin again in a new folder"
        )
