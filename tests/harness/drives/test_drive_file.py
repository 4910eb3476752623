"""A drive written as TOML is read back as the same drive."""

from pathlib import Path

import pytest

from drivegate.drives.drawn_drives import draws
from drivegate.drives.drive_file import drive_toml
from drivegate_cases.drive.drive_document import DriveDocument, load_drive

_TABLE = [[0.0, 0.0], [40.0, 1.0], [140.0, 1.0], [180.0, 0.0]]


@pytest.mark.parametrize(
    "drive",
    [
        load_drive("paper-5-phase"),
        next(draws(0, 1)),
        load_drive("paper-5-phase").replaced(
            name='"quoted" \\ of 1 µH, Ω', emf_shape="table", emf_table=_TABLE
        ),
    ],
    ids=["packaged", "drawn", "table and signs"],
)
def test_a_drive_comes_back_from_its_file(drive: DriveDocument, tmp_path: Path) -> None:
    file = tmp_path / "drive.toml"
    file.write_text(drive_toml(drive), encoding="utf-8")
    again = load_drive(file)
    assert again == drive
    assert again.provenance == drive.provenance
