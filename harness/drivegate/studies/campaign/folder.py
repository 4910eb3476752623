"""The folder of a campaign's results: whose it is, and which files are complete."""

from __future__ import annotations

from pathlib import Path
from typing import Final
from urllib.parse import quote

from drivegate.output.resumed_folder import ResumedFolder
from drivegate.studies.campaign.manifest import MANIFEST, manifest_of, read_manifest, refuse_other
from drivegate.studies.campaign.plan import CampaignPlan, Chunk
from drivegate.studies.campaign.table import rows_in
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.wording import shown_path
from drivegate_models.errors import InputError

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
        ours = manifest_of(self._plan)
        path = self.place / MANIFEST
        if path.exists():
            refuse_other(self.place, read_manifest(path), ours)
        else:
            write_atomically(path, self.as_json(ours))
        for name in self._names:
            (self.place / ROWS / name).mkdir(parents=True, exist_ok=True)

    def path_of(self, chunk: Chunk) -> Path:
        """Give the file of some runs."""
        return self.place / ROWS / self._names[chunk.candidate] / f"part-{chunk.part:06d}.parquet"

    def is_complete(self, chunk: Chunk) -> bool:
        """Tell whether some runs have been made."""
        path = self.path_of(chunk)
        if not path.exists():
            return False
        found = rows_in(path)
        if found != chunk.length:
            raise InputError(
                f"{shown_path(path)} has {found} rows, but must have {chunk.length}; delete it and run the campaign "
                "again, which makes only these runs anew"
            )
        return True
