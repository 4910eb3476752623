"""What a contract declares of its records is what they have."""

import pytest

from drivegate.contracts.catalogue import all_contracts


@pytest.mark.parametrize("contract", all_contracts(), ids=lambda contract: contract.name)
def test_declared_fields_are_those_of_the_records(contract):
    layout = contract.layout
    assert tuple(contract.outputs) == layout.outputs
    assert set(contract.plotted) <= set(layout.outputs)
    assert {*contract.sensed, "time", "phase_currents"} <= set(layout.signals._fields)
    assert {*layout.signals._fields, "struct_size"} <= set(layout.sense.names)
