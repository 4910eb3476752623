"""No key of a scenario or of a drive is accepted without effect, whatever the kind of drive."""

from __future__ import annotations

from typing import Any

import pytest
from tests.harness.contracts.key_effects import (
    DRIVES,
    Nameplate,
    Plans,
    Refused,
    Requires,
    Writes,
    effect_of,
    every_key,
    known_keys,
    mappings,
    plain,
    planned,
    required,
    seen,
)

from drivegate_cases.documents.document import parse_document
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

CASES = [(kind, key) for kind in DRIVES for key in every_key()]


def test_every_key_of_the_documents_is_in_the_table() -> None:
    assert sorted(known_keys()) == sorted(every_key())


@pytest.mark.parametrize(("kind", "key"), CASES, ids=[f"{kind}-{key}" for kind, key in CASES])
def test_a_key_acts_or_is_refused(kind: str, key: str) -> None:
    effect = effect_of(kind, key)
    before, after = mappings(kind, key)
    if isinstance(effect, Refused):
        with pytest.raises(InputError) as refused:
            parse_document(after, Scenario, "case")
        assert [word for word in effect.words if word not in str(refused.value)] == [], str(refused.value)
        return
    assert _shown(effect, before) != _shown(effect, after), (
        f"{key} has no effect on a drive of the kind {kind}"
    )


def _shown(effect: Any, mapping: dict[str, Any]) -> Any:
    """Return what the key is to change."""
    scenario = parse_document(mapping, Scenario, "case")
    if isinstance(effect, Nameplate):
        return scenario.drive.nameplate(scenario.control_period_s)
    if isinstance(effect, Requires):
        return required(scenario.drive)
    if isinstance(effect, Plans):
        return planned(scenario.drive)
    return scenario.to_mapping() if isinstance(effect, Writes) else seen(scenario)


@pytest.mark.parametrize("position", ["encoder", "hall", "exact"])
def test_the_clock_of_a_controller_of_duty_ratios_begins_where_the_scenario_says(position: str) -> None:
    """The sensors' own timers do not follow the clock: all else is the same."""
    mapping = plain("pm-ac") | {"sensors": {"kind": "shunts", "position": position}}
    usual, late = (
        seen(parse_document(mapping | {"clock_start_s": start}, Scenario, "case")) for start in (0.0, 4294.9)
    )
    assert [sense.time for sense in late.senses] == [4294.9 + sense.time for sense in usual.senses]
    assert [sense._replace(time=0.0, winding_temperature=0.0) for sense in late.senses] == [
        sense._replace(time=0.0, winding_temperature=0.0) for sense in usual.senses
    ]
    assert late.plant == usual.plant
