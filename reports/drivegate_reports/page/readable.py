"""Whether a document is what a page is made of."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from drivegate_models.errors import InputError


def require_document(document: Mapping[str, Any], kind: str, schema: int, name: str) -> None:
    """Refuse a document of another kind, or of a schema newer than the one that this version reads."""
    if document.get("kind") != kind:
        raise InputError(f"the document is of kind {document.get('kind')!r}, but must be of kind '{kind}'")
    found = document.get("schema")
    if not isinstance(found, int) or found > schema:
        raise InputError(f"{name} has the schema {found!r}, but this version reads up to {schema}")
