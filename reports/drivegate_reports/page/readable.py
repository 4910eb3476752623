"""Whether a document is what a page is made of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drivegate_models.errors import InputError


def require_document(document: Mapping[str, Any], kind: str, schema: int, name: str) -> None:
    """Refuse a document of another kind, or of a schema that is newer than this version.

    Parameters
    ----------
    document : mapping
        The document.
    kind : str
        Kind that it must be of.
    schema : int
        Newest schema that this version reads.
    name : str
        What such a document is called in a sentence, such as ``the comparison``.

    Raises
    ------
    InputError
        Naming what it is, and what it must be.
    """
    if document.get("kind") != kind:
        raise InputError(f"the document is of kind {document.get('kind')!r}, but must be of kind '{kind}'")
    found = document.get("schema")
    if not isinstance(found, int) or found > schema:
        raise InputError(f"{name} has the schema {found!r}, but this version reads up to {schema}")
