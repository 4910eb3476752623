"""The table `[provenance]` of a drive: where its values come from."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated

from pydantic import Field

from drivegate_cases.documents.wording import shown

Sentence = Annotated[str, Field(max_length=1000)]
Provenance = dict[str, dict[str, Sentence]]
"""A sentence for each key of each table, written ``machine.phases = "stated: …"``."""


def check_provenance(provenance: Provenance, tables: Mapping[str, tuple[str, ...]]) -> Provenance:
    """Check that sentences are of keys that there are."""
    for table, sentences in provenance.items():
        if table not in tables:
            raise ValueError(f"{shown(table)} is no table of a drive, which are {', '.join(tables)}")
        for key in sentences:
            if key not in tables[table]:
                raise ValueError(f"{shown(key)} is no key of the table '{table}'")
    return provenance
