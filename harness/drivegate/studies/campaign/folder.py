"""The folder of a campaign's results: whose it is, which files are complete, and their rows as Parquet."""

from __future__ import annotations

import hashlib
import io
import json
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final
from urllib.parse import quote

from drivegate.contracts.catalogue import contract_of
from drivegate.output.resumed_folder import ResumedFolder
from drivegate.results.provenance import versions
from drivegate.studies.campaign.plan import CampaignPlan, CampaignRun, Chunk
from drivegate.studies.campaign.row import CampaignRow
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.reading import read_mapping
from drivegate_cases.documents.wording import one_line, short_line, shown, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    import pyarrow

MARGIN: Final = "margin_"
"""Beginning of the name of a check's column."""

_FIXED: Final = ("run", "case", "draw", "seed")
_JUDGED: Final = ("verdict", "message", "check", "margin", "measured", "advisory")
_INTEGERS: Final = ("run", "draw", "seed")
_TEXTS: Final = ("case", "verdict", "message", "check", "measured", "advisory")
MANIFEST: Final = "campaign.json"
SCHEMA: Final = 1
LOCK: Final = "campaign.lock"
ROWS: Final = "runs"


def require_parquet(what: str) -> None:
    """Refuse what needs Parquet where it cannot be written."""
    if find_spec("pyarrow") is None:
        raise InputError(f"{what} needs the package pyarrow, which is not installed; pip install pyarrow")


def table_bytes(
    runs: Sequence[CampaignRun], rows: Sequence[CampaignRow], parameters: Sequence[str], checks: Sequence[str]
) -> bytes:
    import pyarrow
    from pyarrow import parquet

    # All cases of a campaign are of one contract.
    observations = contract_of(runs[0].scenario.drive).observations
    records = [
        _record(run, row, parameters, checks)
        | {name: (row.observed or {}).get(name) for name in observations}
        for run, row in zip(runs, rows, strict=True)
    ]
    table = pyarrow.Table.from_pylist(records, schema=schema(parameters, checks, observations))
    buffer = io.BytesIO()
    parquet.write_table(table, buffer, compression="zstd", compression_level=3, version="2.6")
    return buffer.getvalue()


def schema(parameters: Sequence[str], checks: Sequence[str], observations: Sequence[str]) -> pyarrow.Schema:
    import pyarrow

    columns = (*_FIXED, *parameters, *_JUDGED, *(MARGIN + check for check in checks), *observations)
    types = dict.fromkeys(columns, pyarrow.float64())
    types |= dict.fromkeys(_INTEGERS, pyarrow.int64()) | dict.fromkeys(_TEXTS, pyarrow.string())
    return pyarrow.schema(list(types.items()))


def _record(
    run: CampaignRun, row: CampaignRow, parameters: Sequence[str], checks: Sequence[str]
) -> dict[str, Any]:
    margins = row.margins or {}
    binding = {check: value for check, value in margins.items() if check not in row.advisory}
    worst = min(binding, key=lambda check: binding[check], default="")
    return {
        "run": run.number,
        "case": run.case,
        "draw": run.draw,
        "seed": run.seed,
        **{key: run.parameters[key] for key in parameters},
        "verdict": row.verdict,
        "message": row.message,
        "check": worst,
        "margin": binding.get(worst),
        "measured": (row.measured or {}).get(worst, ""),
        "advisory": " ".join(row.advisory),
        **{MARGIN + check: margins.get(check) for check in checks},
    }


def rows_in(path: Path) -> int:
    """Count the rows of a file by its end alone."""
    from pyarrow import ArrowException, parquet

    try:
        return int(parquet.read_metadata(path).num_rows)
    except (ArrowException, OSError) as error:
        raise _damaged(path, error) from error


def columns_of(paths: Sequence[Path], columns: Sequence[str]) -> Iterator[pyarrow.Table]:
    """Read some columns, one file after the other."""
    from pyarrow import ArrowException, parquet

    for path in paths:
        try:
            # The folder's name is the candidate, which is no column here.
            yield parquet.ParquetFile(path).read(columns=list(columns), use_threads=False)
        except (ArrowException, OSError) as error:
            raise _damaged(path, error) from error


def _damaged(path: Path, error: Exception) -> InputError:
    reason = getattr(error, "strerror", None) or str(error)
    return InputError(
        f"{shown_path(path)} is damaged: {one_line(str(reason))}; delete it and run the campaign again, "
        "which makes only these runs again"
    )


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
        return self.place / ROWS / self._names[chunk.candidate] / f"part-{chunk.part:06d}.parquet"

    def is_complete(self, chunk: Chunk) -> bool:
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
        theirs_too = known if isinstance(known, list) else []
        changed = next((entry["name"] for entry in ours["candidates"] if entry not in theirs_too), "?")
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
