"""Every contract declares all that a contract has, and takes its code from its own folder."""

from __future__ import annotations

import inspect

import pytest

from drivegate.contracts.catalogue import all_contracts, contract_named
from drivegate.contracts.contract import Contract

DECLARED = [name for name in inspect.get_annotations(Contract) if not hasattr(Contract, name)]
METHODS = [name for name, _ in inspect.getmembers(Contract, inspect.isfunction)]


@pytest.mark.parametrize("contract", all_contracts(), ids=lambda contract: contract.name)
def test_a_contract_declares_all_that_has_no_default(contract: Contract) -> None:
    assert [name for name in DECLARED if not getattr(contract, name)] == []
    assert contract_named(contract.name) is contract


@pytest.mark.parametrize("contract", all_contracts(), ids=lambda contract: contract.name)
@pytest.mark.parametrize("method", METHODS)
def test_a_method_comes_from_its_folder_and_takes_what_a_contract_says(
    contract: Contract, method: str
) -> None:
    found, stated = getattr(contract, method), getattr(Contract, method)
    if inspect.unwrap(found).__module__ == Contract.__module__:
        assert not getattr(stated, "__isabstractmethod__", False)
        return
    assert found.__module__.startswith(f"drivegate.contracts.{contract.name}.")
    positional = [
        name
        for name, parameter in inspect.signature(stated).parameters.items()
        if parameter.kind in (parameter.POSITIONAL_ONLY, parameter.POSITIONAL_OR_KEYWORD) and name != "self"
    ]
    inspect.signature(found).bind_partial(*positional)
