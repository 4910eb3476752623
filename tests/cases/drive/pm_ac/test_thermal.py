"""Thermal data of a drive: what follows from them, and what is refused in one sentence."""

from __future__ import annotations

import pytest

from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

THERMAL = {
    "heat_capacity_j_per_k": 3.4,
    "thermal_resistance_k_per_w": 4.3,
    "limit_c": 130.0,
    "sensor_lag_s": 0.5,
}


def drive(**changes: object) -> PmAcDocument:
    mapping = load_drive("pm-ac-interior").to_mapping() | {"thermal": THERMAL | changes}
    return parse_document(mapping, PmAcDocument, "my.toml")


def test_the_continuous_current_holds_the_windings_at_their_limit() -> None:
    document = drive()
    thermal = document.thermal
    assert thermal is not None
    current = thermal.continuous_current(document.machine.resistance_ohm)
    loss = 1.5 * document.machine.resistance_ohm * (1.0 + 0.00393 * 105.0) * current**2
    assert loss * 4.3 == pytest.approx(105.0)
    assert thermal.heating_rate(current, document.machine.resistance_ohm) == pytest.approx(0.0, abs=1e-9)
    plate = document.duty_nameplate(1e-4, torque_reference=True)
    assert (plate.heat_capacity, plate.temperature_limit, plate.temperature_lag) == (3.4, 130.0, 0.5)
    assert load_drive("pm-ac-interior").duty_nameplate(1e-4, torque_reference=True).heat_capacity == 0.0  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"heat_capacity_j_per_k": 3400.0}, ("heat_capacity_j_per_k", "3400", "joules per kelvin?")),
        ({"heat_capacity_j_per_k": 0.0034}, ("heat_capacity_j_per_k", "0.0034", "joules per kelvin?")),
        ({"thermal_resistance_k_per_w": 4300.0}, ("thermal_resistance_k_per_w", "4300", "7.07 A")),
        ({"thermal_resistance_k_per_w": 0.0043}, ("thermal_resistance_k_per_w", "0.0043", "7.07 A")),
        ({"sensor_lag_s": 30.0}, ("sensor_lag_s", "30", "in seconds?")),
        ({"sensor_lag_s": 5e-5}, ("sensor_lag_s", "5e-05", "control period")),
        ({"limit_c": 20.0}, ("limit_c", "20", "above ambient_c, 25")),
        ({"limit_c": 403.0}, ("limit_c", "260: in degrees Celsius, 403 K are 129.85")),
        ({"ambient_c": 298.0}, ("ambient_c", "298 K are 24.85")),
        ({"temperature_coefficient_per_k": 3.93}, ("temperature_coefficient_per_k", "0.01")),
        ({"heat_capacity_j_per_k": -1.0}, ("heat_capacity_j_per_k",)),
    ],
)
def test_what_only_a_wrong_unit_has_is_refused(changes: dict[str, float], words: tuple[str, ...]) -> None:
    with pytest.raises(InputError) as refused:
        drive(**changes)
    assert all(word in str(refused.value) for word in words), refused.value


def test_windings_without_resistance_are_refused() -> None:
    mapping = drive().to_mapping()
    mapping["machine"]["resistance_ohm"] = 0.0
    with pytest.raises(InputError, match="'resistance_ohm' is 0"):
        parse_document(mapping, PmAcDocument, "my.toml")


@pytest.mark.parametrize(
    ("document", "temperature", "words"),
    [
        (drive(), 140.0, ("winding_temperature_c", "140", "25", "130")),
        (drive(), 20.0, ("winding_temperature_c", "20", "ambient_c")),
        (load_drive("pm-ac-interior"), 90.0, ("winding_temperature_c", "[thermal]")),
        (load_drive("star-3-phase"), 90.0, ("winding_temperature_c", "pm-ac")),
    ],
    ids=("above", "below", "without", "star"),
)
def test_an_initial_temperature_that_windings_cannot_have_is_refused(
    document: PmAcDocument, temperature: float, words: tuple[str, ...]
) -> None:
    mapping = {
        "schema": 2,
        "name": "hot",
        "drive": document.to_mapping(),
        "duration_s": 0.01,
        "speed_rpm": 300.0,
        "load": {"kind": "locked"},
        "winding_temperature_c": temperature,
    }
    with pytest.raises(InputError) as refused:
        parse_document(mapping, Scenario, "case")
    assert all(word in str(refused.value) for word in words), refused.value
