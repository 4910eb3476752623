"""Controllers that derate wrongly are caught by the checks that are named for them, and those that derate are not."""

from __future__ import annotations

from functools import cache

import pytest
from tests.lab.failed_checks import failed_checks

from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.hot import LONGEST_S, hot_scenarios
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_lab.candidates.duty_faults import DUTY_FAULTS

THERMAL = {
    "heat_capacity_j_per_k": 3.4,
    "thermal_resistance_k_per_w": 4.3,
    "limit_c": 130.0,
    "sensor_lag_s": 0.5,
}
HEATED = load_drive("pm-ac-interior").replaced(settling_s=0.3, thermal=THERMAL)
# It heats slowly, and its sensor shows that far too late.
SLOW = load_drive("pm-ac-hub").replaced(sensor_lag_s=120.0)
FAULTS = [name for name, fault in DUTY_FAULTS.items() if fault.check.startswith("THM-")]


@cache
def failed(candidate: str) -> frozenset[str]:
    """Return the checks that a candidate fails in the runs with hot windings."""
    assert isinstance(HEATED, PmAcDocument)
    return failed_checks(candidate, *hot_scenarios(HEATED))


def test_there_are_six() -> None:
    assert len(FAULTS) == 6
    idle = [DUTY_FAULTS[name].on(load_drive("pm-ac-interior")).idle_because for name in FAULTS]
    assert all(idle), "they idle on drives without a sensor in their windings"


@pytest.mark.parametrize("name", FAULTS)
def test_each_is_caught_by_the_check_that_is_named_for_it(name: str) -> None:
    assert DUTY_FAULTS[name].check in failed(f"faulty:{name}")


@pytest.mark.parametrize(
    "name",
    ["foc", "load-observer", "predictive-flux", "direct-torque", "foc-mtpa", "foc-loss-model"],
)
def test_no_controller_that_derates_is_accused(name: str) -> None:
    assert failed(name) == frozenset()


@cache
def failed_slowly(candidate: str) -> frozenset[str]:
    """Return the checks that a candidate fails while windings that get hot slowly come to their limit."""
    assert isinstance(SLOW, PmAcDocument)
    run = hot_scenarios(SLOW)[-1]
    assert 0.9 * LONGEST_S < run.duration_s <= LONGEST_S
    assert unfair_because(run) is None
    return failed_checks(candidate, run)


@pytest.mark.parametrize("name", ["temperature-read-low", "derated-at-once"])
def test_a_fault_that_only_heating_shows_is_caught_where_it_takes_long(name: str) -> None:
    assert DUTY_FAULTS[name].check in failed_slowly(f"faulty:{name}")


@pytest.mark.parametrize("name", ["foc", "load-observer"])
def test_a_model_of_the_windings_needs_no_fast_sensor(name: str) -> None:
    assert failed_slowly(name) == frozenset()
