"""The margins of a result as a table for spreadsheets: one line for each check."""

import csv
from pathlib import Path
from typing import Any

COLUMNS = ("id", "level", "verdict", "margin", "runs", "measured", "limit")


def write(document: dict[str, Any], folder: Path) -> Path:
    """Write the table.

    Parameters
    ----------
    document : dict
        The result document, as in docs/schemas/result.schema.json.
    folder : Path
        An existing folder.

    Returns
    -------
    Path
        What was written.
    """
    path = folder / "margins.csv"
    with path.open("w", encoding="utf-8", newline="") as file:
        table = csv.writer(file)
        table.writerow(("candidate", *COLUMNS))
        for check in document["checks"]:
            table.writerow((document["candidate"]["name"], *(check[column] for column in COLUMNS)))
    return path
