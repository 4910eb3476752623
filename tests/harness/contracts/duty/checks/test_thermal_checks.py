"""THM-1 to THM-3: windings that get hot, on both sides of each limit, and runs in which nothing is judged."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from tests.harness.contracts.duty.checks.conftest import CHECKS, Run, judged, with_column
from tests.harness.contracts.reading import is_read, read_off

from drivegate import DutyCommand
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.python.bridge import PythonController
from drivegate.contracts.duty.scenarios.building import share_scenario, speed_scenario, torque_scenario
from drivegate.contracts.duty.scenarios.feasibility import unfair_because
from drivegate.contracts.duty.scenarios.fixed import fixed_scenarios
from drivegate.contracts.duty.scenarios.hot import hot_run, hot_scenarios, hot_windings, peak_torque
from drivegate.drives.running import run_scenario
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario

THERMAL = {
    "heat_capacity_j_per_k": 3.4,
    "thermal_resistance_k_per_w": 4.3,
    "limit_c": 130.0,
    "sensor_lag_s": 0.5,
}


@pytest.fixture(scope="module")
def heated(interior: PmAcDocument) -> PmAcDocument:
    drive = interior.replaced(thermal=THERMAL, settling_s=0.3)
    assert isinstance(drive, PmAcDocument)
    return drive


@pytest.fixture(scope="module")
def hot(heated: PmAcDocument) -> Scenario:
    return hot_run(torque_scenario(heated, 1000.0, (peak_torque(heated),)), 1.0)


def test_foc_passes_in_every_fixed_run_and_each_check_judges_one(heated: PmAcDocument, run: Run) -> None:
    records = [run(scenario) for scenario in hot_scenarios(heated)]
    assert len(records) == 4
    for check in ("THM-1", "THM-2", "THM-3"):
        margins = [judged(check, record) for record in records]
        assert any(margin is not None for margin in margins), check
        assert all(margin is None or margin.met for margin in margins), (check, margins)
    assert all(unfair_because(record.scenario) is None for record in records)


def test_other_checks_accuse_nobody_of_derated_torque(hot: Scenario, run: Run) -> None:
    record = run(hot)
    missing = record.steady[-1].torque / peak_torque(record.document)
    assert missing < 0.9, "the windings bear less"
    margins = {name: check.evaluate(record) for name, check in CHECKS.items()}
    assert all(margin is None or margin.met for margin in margins.values()), margins
    assert margins["ACC-1"] is None is margins["FWK-1"]


def test_the_resistance_follows_the_temperature(heated: PmAcDocument, run: Run) -> None:
    cool, warm = (
        run(torque_scenario(heated, 500.0, (1.0,)).replaced(winding_temperature_c=temperature))
        for temperature in (25.0, 125.0)
    )
    powers = [float(record.run.column("input_power")[-500:].mean()) for record in (cool, warm)]
    direct, quadrature = (warm.run.column(name)[-500:] for name in ("direct", "quadrature"))
    added = 1.5 * 0.57 * 0.00393 * 100.0 * float(np.mean(direct**2 + quadrature**2))
    assert powers[1] - powers[0] == pytest.approx(added, rel=0.05)


def test_the_temperature_is_that_of_the_currents_of_the_trace(hot: Scenario, run: Run) -> None:
    record, windings = run(hot), hot_windings(run(hot).document)
    assert windings is not None
    direct, quadrature = (record.run.column(name) for name in ("direct", "quadrature"))
    temperature, period = float(hot.winding_temperature_c or 0.0), hot.control_period_s
    squares = np.concatenate(([0.0], direct**2 + quadrature**2))
    for begin, end in pairwise(squares):
        loss = 0.75 * 0.57 * (1.0 + 0.00393 * (temperature - 25.0)) * (begin + end)
        temperature += period * (loss - (temperature - 25.0) / 4.3) / 3.4
    assert record.run.column("winding_temperature")[-1] == pytest.approx(temperature, abs=0.05)


def test_without_a_coefficient_a_run_has_the_bits_of_a_drive_without_thermal_data(
    interior: PmAcDocument, run: Run
) -> None:
    flat = interior.replaced(thermal=THERMAL | {"temperature_coefficient_per_k": 0.0})
    runs = [run(share_scenario(drive, 1000.0, 0.5)) for drive in (interior, flat)]
    first, second = (record.run.trace[:, :-1] for record in runs)
    assert np.array_equal(first, second)
    assert np.isnan(runs[0].run.column("winding_temperature")).all()
    assert runs[1].run.column("winding_temperature")[-1] > 25.1


def test_only_a_sensor_shows_the_temperature(heated: PmAcDocument) -> None:
    seen: list[float] = []

    class Watching:
        def reset(self, nameplate: Any) -> None:
            seen.append(nameplate.temperature_limit)

        def step(self, sense: Any) -> Any:
            seen.append(sense.winding_temperature)
            return DutyCommand((0.5, 0.5, 0.5))

    for thermal in (THERMAL, {**THERMAL, "sensor_lag_s": None}, None):
        drive = heated.replaced(thermal=thermal)
        scenario = share_scenario(drive, 0.0, 0.1).replaced(duration_s=0.001)
        controller = PythonController(Watching())
        run_scenario(scenario, controller)
    assert seen[:2] == [130.0, 25.0]
    assert len(seen) == 33
    assert np.isnan(seen[12:22]).all()
    assert seen[22] == 0.0
    assert np.isnan(seen[23:]).all()


@pytest.mark.parametrize(
    ("check", "column", "change", "is_met"),
    [
        ("THM-1", "winding_temperature", lambda values: values + 2.0, True),
        ("THM-1", "winding_temperature", lambda values: values + 2.3, False),
        ("THM-2", "direct", lambda values: values - 0.1, True),
        ("THM-2", "direct", lambda values: values - 2.0, False),
        ("THM-3", "torque", lambda values: values + 1e-5 * np.arange(len(values)), True),
        ("THM-3", "torque", lambda values: values + 0.4 * (np.arange(len(values)) > 2000), False),
    ],
)
def test_each_limit_has_two_sides(
    check: str, column: str, change: Any, is_met: bool, hot: Scenario, run: Run
) -> None:
    margin = judged(check, with_column(run(hot), column, change))
    assert margin is not None
    assert margin.met is is_met, margin.measured


@pytest.mark.parametrize(
    ("check", "column", "change"),
    [
        ("THM-1", "winding_temperature", lambda values: values + 5.0),
        ("THM-3", "torque", lambda values: values + 0.4 * (np.arange(len(values)) > 2000)),
    ],
)
def test_the_stated_value_can_be_read_off_the_figure(
    check: str, column: str, change: Any, hot: Scenario, run: Run
) -> None:
    measured, numbers = read_off(CHECKS[check], with_column(run(hot), column, change))
    assert is_read(measured, numbers), f"{measured!r} is not among {numbers}"


@pytest.mark.parametrize(("lost", "is_met"), [(0.02, True), (0.2, False)])
def test_cool_windings_give_the_whole_torque(
    lost: float, is_met: bool, heated: PmAcDocument, run: Run
) -> None:
    record = run(hot_run(share_scenario(heated, 1000.0, 0.0, 0.5), 0.5))
    margin = judged("THM-3", with_column(record, "torque", lambda values: (1.0 - lost) * values))
    assert margin is not None
    assert margin.met is is_met, margin.measured


def test_heated_windings_give_half_of_what_they_bear(heated: PmAcDocument, run: Run) -> None:
    record = run(hot_scenarios(heated)[-1])

    def faded(values: Any) -> Any:
        return values * np.linspace(1.0, 0.4, len(values))

    margin = judged("THM-3", with_column(record, "torque", faded))
    assert margin is not None
    assert not margin.met
    assert "where hot windings bear" in margin.measured


def test_nothing_is_judged_without_a_sensor(interior: PmAcDocument, heated: PmAcDocument, run: Run) -> None:
    blind = heated.replaced(thermal={**THERMAL, "sensor_lag_s": None})
    for drive in (interior, blind):
        record = run(share_scenario(drive, 1000.0, 0.5))
        assert all(judged(check, record) is None for check in ("THM-1", "THM-2", "THM-3"))
        assert "sensor_lag_s" in str(CHECKS["THM-1"].reason_not_applicable(Declaration(), drive))
        assert hot_scenarios(drive) == []
        assert not any(scenario.winding_temperature_c for scenario in fixed_scenarios(drive))
    assert CHECKS["THM-1"].reason_not_applicable(Declaration(), heated) is None


def test_what_no_controller_could_do_is_unfair(heated: PmAcDocument) -> None:
    windings = hot_windings(heated)
    assert windings is not None
    lasting = share_scenario(heated, 1000.0, 0.5).replaced(duration_s=8.0)
    assert "lasts so long" in str(unfair_because(lasting))
    top = hot_run(torque_scenario(heated, 6000.0, (1.0,)), 1.0)
    assert "weakening alone" in str(unfair_because(top))
    loaded = hot_run(speed_scenario(heated, (1000.0,), torque_nm=1.0), 1.0)
    assert "speed regulator" in str(unfair_because(loaded))
