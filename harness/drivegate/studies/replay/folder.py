"""Running every counterexample of a folder again: how many still fail."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault
from drivegate.output.progress import Display
from drivegate.output.result_file import COUNTEREXAMPLES, RESULT_FILE
from drivegate.results.counterexample import Counterexample, read_counterexample
from drivegate.studies.replay.replay import (
    VERDICTS,
    Replay,
    candidate_for,
    document_of,
    replayed,
)
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

SCHEMA: Final = 1


@dataclass(frozen=True)
class Kept:
    """A counterexample of a folder, and who is to run it."""

    file: Path
    stored: Counterexample
    candidate: Candidate


def kept_in(folder: Path, given: str | None) -> tuple[Kept, ...]:
    """Read every counterexample of a folder, and find who is to run it, before anything runs."""
    try:
        files = _files(folder)
    except OSError as error:
        reason = one_line(error.strerror or str(error))
        raise InputError(f"{shown_path(folder)} cannot be read: {reason}; name a readable folder") from error
    if not files:
        raise InputError(
            f"{shown_path(folder)} holds no counterexample; name the report of a check that failed, such as "
            f"drivegate-report, its folder {COUNTEREXAMPLES}, or a folder of such files (*.json)"
        )
    all_stored = [read_counterexample(file) for file in files]
    candidates: dict[str, Candidate] = {}
    all_kept = []
    for file, stored in zip(files, all_stored, strict=True):
        name = stored.candidate.name if given is None else given
        if name not in candidates:
            candidates[name] = candidate_for(stored, given)
        all_kept.append(Kept(file, stored, candidates[name]))
    return tuple(all_kept)


def _files(folder: Path) -> list[Path]:
    """Find the files: of a report, also of several candidates or of a campaign, or of a plain folder."""
    reported = [
        file
        for pattern in (COUNTEREXAMPLES, f"*/{COUNTEREXAMPLES}")
        for place in sorted(folder.glob(pattern))
        for file in sorted(place.glob("**/*.json"))
    ]
    if reported or (folder / RESULT_FILE).exists():
        return reported
    plain = sorted(folder.glob("**/*.json" if folder.resolve().name == COUNTEREXAMPLES else "*.json"))
    return [file for file in plain if not file.name.startswith(".")]


def replayed_all(all_kept: tuple[Kept, ...], display: Display) -> list[dict[str, Any]]:
    """Run counterexamples again one after the other, each as if it were the only one."""
    documents: list[dict[str, Any]] = []
    unloadable: dict[str, Fault] = {}
    display.begin("replay", len(all_kept), "starting")
    for kept in all_kept:
        # A candidate that cannot be loaded will not be next time.
        ended: Replay | Fault = unloadable.get(kept.candidate.name) or replayed(kept.stored, kept.candidate)
        if isinstance(ended, Fault) and ended.phase == "loading":
            unloadable[kept.candidate.name] = ended
        document = document_of(kept.stored, kept.candidate, ended)
        documents.append({"file": str(kept.file)} | document)
        words = f"{document['check']} {document['verdict']}"
        display.advance(len(documents), len(all_kept), words, unit="counterexamples")
    return documents


def document_of_all(folder: Path, documents: list[dict[str, Any]]) -> dict[str, Any]:
    verdicts = [document["verdict"] for document in documents]
    required = [document for document in documents if document["level"] == "required"]
    return {
        "schema": SCHEMA,
        "kind": "replays",
        "folder": str(folder),
        # As of a check, failures that only advise do not count.
        "exit_code": max((document["exit_code"] for document in required), default=0),
        "counts": {verdict: verdicts.count(verdict) for verdict in VERDICTS},
        "replays": documents,
    }
