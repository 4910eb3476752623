"""The folder of a campaign's results: whose it is, and which files are complete."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import Any, Final
from urllib.parse import quote

from drivegate.output.resumed_folder import ResumedFolder
from drivegate.results.provenance import versions
from drivegate.studies.campaign.plan import CampaignPlan, Chunk
from drivegate.studies.campaign.table import rows_in
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.reading import read_mapping
from drivegate_cases.documents.wording import one_line, short_line, shown, shown_path
from drivegate_models.errors import InputError

MANIFEST: Final = "campaign.json"
SCHEMA: Final = 1
LOCK: Final = "campaign.lock"
ROWS: Final = "runs"


class CampaignFolder(ResumedFolder):
    """The folder, held for one campaign alone as long as the context lasts."""

    def __init__(self, place: Path, plan: CampaignPlan) -> None:
        super().__init__(place, kind="campaign", manifest=MANIFEST, lock=LOCK)
        self._plan = plan
        self._names = [f"candidate={quote(candidate.name, safe='')}" for candidate in plan.candidates]

    def claim(self) -> None:
        """Write the manifest and the folders of rows, or refuse the results of another campaign."""
        ours = _manifest_of(self._plan)
        path = self.place / MANIFEST
        if path.exists():
            _refuse_other(self.place, _read_manifest(path), ours)
        else:
            write_atomically(path, self.as_json(ours))
        for name in self._names:
            (self.place / ROWS / name).mkdir(parents=True, exist_ok=True)

    def path_of(self, chunk: Chunk) -> Path:
        """Return the file of some runs."""
        return self.place / ROWS / self._names[chunk.candidate] / f"part-{chunk.part:06d}.parquet"

    def is_complete(self, chunk: Chunk) -> bool:
        """Return True if some runs have been made."""
        path = self.path_of(chunk)
        if not path.exists():
            return False
        found = rows_in(path)
        if found != chunk.length:
            raise InputError(
                f"{shown_path(path)} has {found} rows, but must have {chunk.length}; delete it and run the campaign "
                "again, which makes only these runs again"
            )
        return True


def _manifest_of(plan: CampaignPlan) -> dict[str, Any]:
    """Return everything that a campaign's results follow from."""
    import pyarrow

    used = versions()
    used["packages"] = used["packages"] | {"pyarrow": pyarrow.__version__}
    content = {
        "campaign": plan.campaign.to_mapping(),
        "cases": [case.to_mapping() for case in plan.cases],
        "checks": list(plan.checks),
        "runs": plan.runs,
        "runs_per_file": plan.campaign.file_length,
    }
    candidates = [
        {"name": candidate.name, "kind": candidate.kind, "hash": candidate.content_hash}
        for candidate in plan.candidates
    ]
    digest = hashlib.sha256(json.dumps(content).encode()).hexdigest()
    head = {"schema": SCHEMA, "kind": "campaign", "content_hash": digest}
    return head | content | {"candidates": candidates, "versions": used}


def _read_manifest(path: Path) -> dict[str, Any]:
    """Read the manifest of a folder."""
    try:
        manifest = read_mapping(path)
    except InputError as error:
        raise InputError(f"{error}; name a new or an empty folder") from error
    if manifest.get("kind") != "campaign":
        raise InputError(f"{shown_path(path)} is no manifest of a campaign; name a new or an empty folder")
    if manifest.get("schema") != SCHEMA:
        raise InputError(
            f"{shown_path(path)} is of schema {shown(manifest.get('schema'))}, but this drivegate goes on with "
            f"schema {SCHEMA} only; name a new or an empty folder"
        )
    return manifest


def _refuse_other(place: Path, theirs: dict[str, Any], ours: dict[str, Any]) -> None:
    """Refuse to mix results: another campaign, another version of a candidate, or other software."""
    where = f"--output {shown_path(place)}"
    if theirs.get("content_hash") != ours["content_hash"]:
        campaign = theirs.get("campaign")
        name = campaign.get("name") if isinstance(campaign, dict) else None
        raise InputError(
            f"{where} holds another campaign, '{short_line(str(name))}', or an earlier state of this one "
            f"({_difference(theirs, ours)} differs); name a new folder, or give the file that it was begun with"
        )
    if theirs.get("candidates") != ours["candidates"]:
        known = theirs.get("candidates")
        changed = next(
            (
                entry["name"]
                for entry in ours["candidates"]
                if not isinstance(known, list) or entry not in known
            ),
            "?",
        )
        raise InputError(
            f"{where} was begun with another version of the candidate '{one_line(changed)}'; name a new folder, "
            "since results of two versions are not mixed"
        )
    if theirs.get("versions") != ours["versions"]:
        raise InputError(
            f"{where} was begun with other versions of drivegate or of what it computes with; name a new folder, or "
            f"go on with the versions that {MANIFEST} there states"
        )


def _difference(theirs: dict[str, Any], ours: dict[str, Any]) -> str:
    """Name the first key that differs, for a person to look at."""
    own, other = ours["campaign"], theirs.get("campaign")
    if isinstance(other, dict):
        for key in (*own, *other):
            if own.get(key) != other.get(key):
                return f"the key '{short_line(str(key))}'"
            if isinstance(own.get(key), dict) and list(own[key]) != list(other[key]):
                return f"the order in '{short_line(str(key))}'"
    return next(
        (f"'{key}'" for key in ("cases", "checks", "runs_per_file") if ours[key] != theirs.get(key)), "it"
    )
