"""What a scenario makes of clock, rotor and single current sensors, and a controller that is reset in mid-run."""

import gc
import weakref
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from drivegate import Command, Nameplate, Sense
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import CandidateFault
from drivegate.candidates.python.bridge import PythonController
from drivegate.contracts.current.checks.power import estimated_power
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.run import observed_windows, run_in_closed_loop
from drivegate.contracts.current.scenarios.building import steady_scenario
from drivegate.drives.running import run_scenario
from drivegate.scenarios.changes import (
    with_beginning,
    with_current_error,
    with_dropout,
    with_real_sensors,
    with_restarts,
)
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.half_bridge.closed_loop import prepared_loop
from drivegate_models.loop.closed_loop import ClosedLoopRun, PreparedLoop
from drivegate_models.loop.loop_inputs import CurrentLoopInputs

PLAIN = steady_scenario(load_drive("paper-5-phase"), 700.0, power_share=0.5, constant_power=False)


class Noting:
    """Answers the same throughout, and notes what it senses and when it is reset."""

    def __init__(self, raises: bool = False) -> None:
        self.senses: list[Sense] = []
        self.resets: list[int] = []
        self._raises = raises

    def reset(self, nameplate: Nameplate) -> None:
        if self._raises and self.senses:
            raise ValueError("not again")
        self.resets.append(len(self.senses))
        self.products: list[float] = []

    def step(self, sense: Sense) -> Command:
        self.senses.append(sense)
        self.products = [*self.products[-39:], sense.half_supply_voltage * sense.current_magnitude_sum]
        return Command(12.0, 0.6, sum(self.products) / len(self.products))


def noted(change: Callable[[Scenario], Scenario] = lambda scenario: scenario) -> Noting:
    instance = Noting()
    run_scenario(change(PLAIN).replaced(duration_s=0.5), PythonController(instance))
    return instance


def test_the_clock_begins_where_the_scenario_says() -> None:
    times = [sense.time for sense in noted(lambda plain: plain.replaced(clock_start_s=4294.9)).senses]
    assert times[0] == 4294.9
    assert np.diff(times) == pytest.approx(0.0005, abs=1e-9)
    assert times[-1] == pytest.approx(4295.3995)


@pytest.mark.parametrize(("pole_pairs", "lasts"), [(11, 0.1), (2, 0.5)])
def test_means_are_taken_over_the_drives_own_time(pole_pairs: int, lasts: float) -> None:
    given: list[CurrentLoopInputs] = []

    def prepare(inputs: CurrentLoopInputs, *controller: Any) -> PreparedLoop[ClosedLoopRun]:
        given.append(inputs)
        return prepared_loop(inputs, *controller)

    slow = PLAIN.replaced(drive=PLAIN.drive.replaced(pole_pairs=pole_pairs), duration_s=0.5)
    run_in_closed_loop(prepare, slow, PythonController(Noting()))
    assert given[0].mean_time == pytest.approx(lasts)


def test_the_rotor_begins_where_the_scenario_says() -> None:
    """Half a cycle on, every current is the other way round."""
    here, opposite = (
        np.array(noted(lambda plain, at=at: plain.replaced(initial_angle_deg=at)).senses[50].phase_currents)  # type: ignore[misc]
        for at in (0.0, 180.0)
    )
    assert np.abs(here).max() > 1.0
    assert opposite == pytest.approx(-here, abs=1e-6)


@pytest.mark.parametrize("sensors", [lambda plain: plain, lambda plain: with_real_sensors(plain, 3)])
def test_one_wrong_current_sensor_shows_in_its_phase_and_in_the_sum(sensors: Any) -> None:
    right = noted(sensors).senses[600]
    wrong = noted(lambda plain: with_current_error(sensors(plain), 2, gain=0.5, offset_a=0.25)).senses[600]
    step = 0.0 if sensors(PLAIN).sensors.kind == "ideal" else 80.0 / 1024.0
    expected = 0.5 * right.phase_currents[1] + 0.25
    assert wrong.phase_currents[1] == pytest.approx(expected, abs=1e-9 + 1.1 * step)
    assert wrong.phase_currents[0] == right.phase_currents[0]
    assert wrong.current_magnitude_sum < right.current_magnitude_sum


def test_a_lost_sample_of_one_phase_is_lost_alone_and_once() -> None:
    right = noted().senses
    lost = noted(lambda plain: with_dropout(plain, "currents", 0.3, 0.0005, phase=4)).senses
    zero = [
        step for step, sense in enumerate(lost) if sense.phase_currents[3] != right[step].phase_currents[3]
    ]
    assert zero == [600]
    assert lost[600].phase_currents[3] == 0.0
    assert lost[600].phase_currents[:3] == right[600].phase_currents[:3]
    assert lost[600].current_magnitude_sum < 0.9 * right[600].current_magnitude_sum
    assert lost[601].current_magnitude_sum == pytest.approx(right[601].current_magnitude_sum, rel=1e-12)


def test_a_restart_resets_the_same_instance_while_the_drive_runs_on() -> None:
    plain, restarted = noted(), noted(lambda plain: with_restarts(plain.replaced(duration_s=0.5), 0.1, 0.3))
    assert plain.resets == [0]
    assert restarted.resets == [0, 200, 600]
    assert [sense.speed for sense in restarted.senses] == [sense.speed for sense in plain.senses]
    assert restarted.senses[600].time == 600 * 0.0005


def test_a_reset_that_fails_in_mid_run_is_the_candidates_fault() -> None:
    instance = Noting(raises=True)
    with pytest.raises(CandidateFault) as caught:
        run_scenario(with_restarts(PLAIN, 0.1), PythonController(instance))
    assert caught.value.fault.phase == "reset"
    assert "not again" in caught.value.fault.message
    assert len(instance.senses) == 200, "the candidate is stepped after a reset that failed"


@pytest.fixture
def no_collector() -> Iterator[None]:
    """Let nothing go but what nobody holds any more."""
    gc.collect()
    gc.disable()
    yield
    gc.enable()


@pytest.mark.usefixtures("no_collector")
@pytest.mark.parametrize("raises", [False, True], ids=["made to its end", "ended by a reset that fails"])
def test_an_instance_goes_with_its_run_and_not_when_python_collects(raises: bool) -> None:
    instance = Noting(raises)
    gone = weakref.ref(instance)
    controller = PythonController(instance)
    del instance
    try:
        run_scenario(with_restarts(PLAIN, 0.1).replaced(duration_s=0.5), controller)
    except CandidateFault:
        assert raises
    del controller
    assert gone() is None, "the deletion of a candidate's instance comes at a moment that nobody has chosen"


def test_an_estimate_over_time_begins_again_with_the_candidate() -> None:
    declaration = Declaration(estimates_power=True, power_window_s=0.02)
    scenario = with_restarts(PLAIN, 0.1, 0.105).replaced(duration_s=0.5)
    run = run_scenario(scenario, PythonController(Noting()), power_window=0.02)
    margin = estimated_power(CurrentRecord(scenario, run, declaration))
    assert margin is not None
    assert margin.met, margin.measured


def test_a_restart_ends_a_steady_stretch() -> None:
    assert observed_windows(with_restarts(PLAIN, 10.0)) == [(6.2, 10.0), (16.0, 20.0)]


def test_every_new_key_is_named_and_none_of_a_plain_run_is() -> None:
    changed = with_beginning(PLAIN, control_period_s=1e-4, clock_start_s=60.0, initial_angle_deg=90.0)
    changed = with_dropout(with_current_error(changed, 2, gain=0.9), "currents", 3.0, 0.0005, phase=4)
    changed = with_restarts(changed, 2.0, 8.0)
    for words in (
        "a step every 100 µs",
        "clock at 60 s",
        "rotor at 90° at first",
        "current of phase 2 shown as ×0.9",
        "phase 4 lost for 0.5 ms at 3 s",
        "restarted at 2, 8 s",
    ):
        assert words in changed.description
        assert words not in PLAIN.description
