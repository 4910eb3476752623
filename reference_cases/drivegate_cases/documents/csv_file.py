"""A user's CSV file with columns of numbers, each in a first line by its name; other columns are left alone."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from math import isfinite, nan
from pathlib import Path
from typing import Final

from drivegate_cases.documents.reading import file_bytes
from drivegate_cases.documents.wording import nearest, one_line, pointed, shown, shown_path
from drivegate_models.errors import InputError

_LARGEST_FILE_BYTES: Final = 4 * 1024 * 1024


def read_columns(
    path: Path, required: Sequence[str], optional: Sequence[str] = (), *, what: str
) -> list[list[float]]:
    """Read the rows of a CSV file as numbers, the required columns first; NaN for an empty cell of an optional one.

    `what` describes such a file in words. A missing file or column, and a cell that is no number, raise `InputError`.
    """
    where = shown_path(path)
    rows = csv.reader(io.StringIO(_text_of(path, required, where, what)))
    try:
        header = [name.strip().lower() for name in next(rows, [])]
        _check_separator(header, required, where)
        columns = [(name, _column(name, header, required, where), True) for name in required]
        columns += [(name, header.index(name), False) for name in optional if name in header]
        places = {name: place for place, name in enumerate((*required, *optional))}
        numbers = []
        for row in rows:
            if any(cell.strip() for cell in row):
                if any(cell.strip() for cell in row[len(header) :]):
                    raise InputError(
                        f"{where} has {len(row)} cells in line {rows.line_num}, but {len(header)} columns in its first "
                        "line; numbers must have a decimal point, since a comma ends a cell"
                    )
                values = [nan] * len(places)
                for name, column, needed in columns:
                    values[places[name]] = _number(row, column, name, rows.line_num, where, needed)
                numbers.append(values)
    except csv.Error as error:
        raise InputError(f"{where} is no CSV file at line {rows.line_num}: {one_line(str(error))}") from error
    return numbers


def _text_of(path: Path, required: Sequence[str], where: str, what: str) -> str:
    columns = f" with {' and '.join(required)}"
    data = file_bytes(
        path, "CSV file", most=_LARGEST_FILE_BYTES, limit=f"the most for {what}", having=columns
    )
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(
            f"{where} is not text in UTF-8 (byte {error.start}), but must be a CSV file"
        ) from error


def _check_separator(header: list[str], required: Sequence[str], where: str) -> None:
    """Refuse a file whose columns other characters separate, as spreadsheets of many countries write it."""
    for separator, name in ((";", "semicolons"), ("\t", "tabs")):
        cells = [cell.strip() for cell in ",".join(header).split(separator)]
        if any(column in cells for column in required) and len(cells) > len(header):
            raise InputError(
                f"{where} separates its columns by {name}, but must have commas, and decimal points in its numbers: "
                f"{','.join(required)}"
            )


def _column(name: str, header: list[str], required: Sequence[str], where: str) -> int:
    if name in header:
        return header.index(name)
    known = [column for column in header if column]
    hint = f", the nearest there is '{one_line(str(nearest(name, known)))[:60]}'" if known else ""
    raise InputError(
        f"{where} has no column '{name}' in its first line{hint}; it must have {' and '.join(required)}"
    )


def _number(row: list[str], column: int, name: str, line: int, where: str, needed: bool) -> float:
    cell = row[column].strip() if column < len(row) else ""
    if not cell and not needed:
        return nan
    try:
        value = float(cell)
    except ValueError:
        value = nan
    if not isfinite(value):
        raise InputError(
            f"{where}: '{name}' is {shown(cell)} in line {line}, but must be a number{pointed(cell)}"
        )
    return value
