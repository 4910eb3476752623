"""What a bundle imports later exists, belongs to its contract, and takes what the bundle says."""

from __future__ import annotations

import ast
import inspect
from dataclasses import fields

import pytest

from drivegate.contracts.catalogue import CONTRACTS
from drivegate.contracts.contract import Contract, Later

FIELDS = {field.name: str(field.type) for field in fields(Contract)}


@pytest.mark.parametrize("contract", ["current", "duty"])
@pytest.mark.parametrize("field", FIELDS)
def test_what_is_imported_later_takes_what_the_bundle_says(contract: str, field: str) -> None:
    stated = getattr(CONTRACTS[contract], field)
    later = getattr(stated, "__self__", stated)
    if not isinstance(later, Later):
        return
    assert later.module.startswith((f"drivegate.contracts.{contract}.", "drivegate_models."))
    found = later.value()
    assert callable(found) == (stated is later), "a value is imported by `value`, a function by the call"
    parameters = next(
        node for node in ast.walk(ast.parse(FIELDS[field])) if isinstance(node, ast.Subscript)
    ).slice
    assert isinstance(parameters, ast.Tuple)
    if callable(found) and isinstance(parameters.elts[0], ast.List):
        inspect.signature(found).bind(*parameters.elts[0].elts)
