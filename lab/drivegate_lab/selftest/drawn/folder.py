"""The folder of a self-test on drawn drives: the drives, and what is complete of the results."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

from drivegate.output.resumed_folder import ResumedFolder
from drivegate.results.provenance import versions
from drivegate.results.result import finite
from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_cases.documents.reading import read_mapping
from drivegate_cases.documents.wording import short_line, shown_path
from drivegate_cases.drive.drive_file import drive_toml
from drivegate_lab.drawn.drawing import DrawnDrive
from drivegate_lab.selftest.run import SelftestEffort
from drivegate_models.errors import InputError

MANIFEST: Final = "selftest.json"
SUMMARY: Final = "summary.json"
SCHEMA: Final = 1
KIND: Final = "selftest-drives"
_LOCK: Final = "selftest.lock"


class DrivesFolder(ResumedFolder):
    """The folder, held for one self-test alone as long as the context lasts."""

    def __init__(self, place: Path, drive_kind: str, drawing_seed: int, effort: SelftestEffort) -> None:
        super().__init__(place, kind="self-test on drawn drives", manifest=MANIFEST, lock=_LOCK)
        self._ours = {
            "schema": SCHEMA,
            "kind": KIND,
            "drive_kind": drive_kind,
            "drawing_seed": drawing_seed,
            "effort": effort.name,
            "seeds": effort.seeds,
            "search": effort.search,
            "versions": versions(),
        }

    def claim(self) -> None:
        """Write the manifest, or refuse results that follow from something else."""
        path = self.place / MANIFEST
        if not path.exists():
            write_atomically(path, self.as_json(self._ours))
            return
        theirs = _read(path, "name a new or an empty folder")
        for key, value in self._ours.items():
            if theirs.get(key) == value:
                continue
            where = f"--output {shown_path(self.place)}"
            if key == "versions":
                raise InputError(
                    f"{where} was begun with other versions of drivegate or of what it computes with; name a new folder"
                )
            stored = short_line(str(theirs.get(key)))
            raise InputError(
                f"{where} was begun with {key.replace('_', ' ')} {stored}, not {value}; "
                "name a new folder, or give the same"
            )

    def drive_path(self, number: int) -> Path:
        """Return the file of a drive."""
        return self.place / "drives" / f"{number:03d}.toml"

    def keep_drive(self, number: int, drawn: DrawnDrive) -> None:
        """Write the file of a drive, or see that it is still the one that was drawn."""
        path, text = self.drive_path(number), drive_toml(drawn.document)
        if not path.exists():
            self.write(path, text)
        elif path.read_text(encoding="utf-8", errors="replace") != text:
            raise InputError(
                f"{shown_path(path)} is not the drive that was drawn; give a changed one another name, and delete this"
            )

    def keep(self, number: int, document: Mapping[str, Any], fault: str | None = None) -> None:
        """Write what has become of the reference, or of a faulty controller, on a drive."""
        self.write(self._result_path(number, fault), self.as_json(finite(document)))

    def kept(self, number: int, fault: str | None = None) -> dict[str, Any] | None:
        """Read what has become of a controller on a drive; None where that is still to be found out."""
        path = self._result_path(number, fault)
        return _read(path, "delete it and run the same command again") if path.exists() else None

    def _result_path(self, number: int, fault: str | None) -> Path:
        name = f"{number:03d}" if fault is None else f"{number:03d}-{fault}"
        return self.place / "results" / f"{name}.json"


def _read(path: Path, way_out: str) -> dict[str, Any]:
    try:
        return read_mapping(path)
    except InputError as error:
        raise InputError(f"{error}; {way_out}") from error
