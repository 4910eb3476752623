"""The loop by hand in C does what the compiled loop does, so that their times may be compared."""

from pathlib import Path

import numpy as np
import pytest

from drivegate.candidates.loading import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.running import run_scenario
from drivegate.runs.scenario import RADIANS_PER_RPM
from drivegate.studies.bench.workbench import operating_scenario
from drivegate.studies.bench.yardstick import RECORD, Yardstick, build_yardstick, yardstick_folder
from drivegate_models.errors import HarnessFault, InputError
from drivegate_models.loop import observation

YARDSTICK = Path(__file__).parents[4] / "benchmarks" / "c_yardstick"
TOLERANCE = 1e-9
COLUMNS = {"speed": "speed_rpm", "current_reference": "current_reference_a", "current_sum": "current_sum_a"}
LOSSY = {
    "switch_drop_v": 1.1,
    "diode_drop_v": 0.8,
    "turn_on_energy_j": 2e-4,
    "turn_off_energy_j": 3e-4,
    "friction_n_m": 0.1,
    "viscous_friction_n_m_s_per_rad": 1e-3,
}
MOTORS = {
    "as it is": {},
    "no band": {"hysteresis_band_a": 0.0},
    "no band, sine": {"hysteresis_band_a": 0.0, "emf_shape": "sine"},
    "all losses": LOSSY,
    "no resistance": {"resistance_ohm": 0.0},
    "high resistance": {"resistance_ohm": 3.0},
}


@pytest.fixture(scope="module")
def yardstick(tmp_path_factory):
    return Yardstick(build_yardstick(YARDSTICK, tmp_path_factory.mktemp("yardstick")))


def difference(ours, theirs):
    """Tell the greatest difference of two runs, relative to the greatest value of each signal."""
    names = list(observation.TRACE_COLUMNS)
    worst = 0.0
    for signal, column in COLUMNS.items():
        own = ours.trace[:, names.index(column)]
        other = theirs.rows[:, RECORD.index(signal)] / (RADIANS_PER_RPM if signal == "speed" else 1.0)
        worst = max(worst, np.abs(own - other).max() / np.abs(own).max())
    totals = np.abs(ours.totals - theirs.totals) / np.maximum(np.abs(ours.totals), 1e-9)
    return max(worst, totals.max())


@pytest.mark.parametrize("speed", [500, 1000, 1500, 2000])
@pytest.mark.parametrize("candidate", ["initial", "reference"])
def test_it_is_in_lock_step_with_the_compiled_loop(yardstick, candidate, speed):
    scenario = operating_scenario(speed, "ideal", 1.0)
    controller = load_controller(resolve_candidate(candidate))
    ours = run_scenario(scenario, controller, trace_every=1)
    theirs = yardstick.prepared(scenario, None if candidate == "initial" else controller)(recorded=True)
    assert len(theirs.rows) == scenario.control_periods == 2000
    apart = difference(ours, theirs)
    assert apart <= TOLERANCE, f"{candidate} at {speed} rpm: they are {apart:.1e} apart"


@pytest.mark.parametrize("motor", MOTORS)
def test_every_branch_of_the_plant_is_in_it(yardstick, motor):
    scenario = operating_scenario(1200, "ideal", 0.5)
    values = scenario.motor.to_mapping() | MOTORS[motor]
    if values["emf_shape"] == "sine":
        del values["emf_flat_deg"]
    scenario = scenario.replaced(motor=values)
    ours = run_scenario(scenario, load_controller(resolve_candidate("initial")), trace_every=1)
    theirs = yardstick.prepared(scenario)(recorded=True)
    apart = difference(ours, theirs)
    assert apart <= TOLERANCE, f"{motor}: they are {apart:.1e} apart"
    assert theirs.mismatch <= TOLERANCE, f"{motor}: its energy closes to {theirs.mismatch:.1e} only"


def test_a_run_that_it_does_not_know_is_refused(yardstick):
    falling = operating_scenario(1500, "ideal", 1.0).replaced(speed_rpm=((0.0, 1500.0), (1.0, 1400.0)))
    with pytest.raises(HarnessFault, match="steady speed"):
        yardstick.prepared(falling)


def test_sources_that_do_not_compile_are_told_in_one_sentence(tmp_path):
    (tmp_path / "yardstick.c").write_text("int yardstick_run(void) { return nothing; }\n")
    with pytest.raises(InputError, match=r"does not compile with -std=c11 -O3.*nothing"):
        build_yardstick(tmp_path, tmp_path)


def test_it_is_found_where_the_command_runs_in_the_sources_of_drivegate(monkeypatch, tmp_path):
    monkeypatch.chdir(YARDSTICK.parents[1])
    found = yardstick_folder(None)
    assert found is not None
    assert found.resolve() == YARDSTICK
    monkeypatch.chdir(tmp_path)
    assert yardstick_folder(None) is None
