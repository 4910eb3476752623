"""Rows of a campaign as a Parquet file, the same bytes for the same rows; and reading them back, file by file."""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from drivegate.contracts.catalogue import contract_of
from drivegate.studies.campaign.plan import CampaignRun
from drivegate.studies.campaign.row import CampaignRow
from drivegate_cases.documents.wording import one_line, shown_path
from drivegate_models.errors import InputError

if TYPE_CHECKING:
    import pyarrow

MARGIN: Final = "margin_"
"""Beginning of the name of a check's column."""

_FIXED: Final = ("run", "case", "draw", "seed")
_JUDGED: Final = ("verdict", "message", "check", "margin", "measured", "advisory")
_INTEGERS: Final = ("run", "draw", "seed")
_TEXTS: Final = ("case", "verdict", "message", "check", "measured", "advisory")


def require_parquet(what: str) -> None:
    """Refuse what needs Parquet where it cannot be written."""
    if find_spec("pyarrow") is None:
        raise InputError(f"{what} needs the package pyarrow, which is not installed; pip install pyarrow")


def table_bytes(
    runs: Sequence[CampaignRun], rows: Sequence[CampaignRow], parameters: Sequence[str], checks: Sequence[str]
) -> bytes:
    """Write rows as a Parquet file."""
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
    """Return the columns of a campaign's files."""
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
