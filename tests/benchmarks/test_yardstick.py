"""The loop by hand in C does what the compiled loop does, so that their times may be compared."""

import pytest

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.running import run_scenario
from drivegate_lab.bench.workbench import operating_scenario
from drivegate_models.errors import HarnessFault, InputError
from yardstick import RECORD, Yardstick, build_yardstick
from yardstick_ratio import compiled_yardstick, difference

TOLERANCE = 1e-9
LOSSY = {
    "switch_drop_v": 1.1,
    "diode_drop_v": 0.8,
    "turn_on_energy_j": 2e-4,
    "turn_off_energy_j": 3e-4,
    "friction_n_m": 0.1,
    "viscous_friction_n_m_s_per_rad": 1e-3,
}
DRIVES = {
    "as it is": {},
    "no band": {"hysteresis_band_a": 0.0},
    "no band, sine": {"hysteresis_band_a": 0.0, "emf_shape": "sine"},
    "all losses": LOSSY,
    "no resistance": {"resistance_ohm": 0.0},
    "high resistance": {"resistance_ohm": 3.0},
}


@pytest.fixture(scope="module")
def yardstick(tmp_path_factory) -> Yardstick:
    return compiled_yardstick(tmp_path_factory.mktemp("yardstick"))


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


@pytest.mark.parametrize("signal", ["speed", "current_reference", "current_sum", "totals"])
def test_a_difference_in_any_signal_is_reported(yardstick, signal):
    scenario = operating_scenario(1500, "ideal", 0.5)
    ours = run_scenario(scenario, load_controller(resolve_candidate("initial")), trace_every=1)
    theirs = yardstick.prepared(scenario)(recorded=True)
    if signal == "totals":
        theirs.totals[3] *= 1.01
    else:
        theirs.rows[500, RECORD.index(signal)] *= 1.01
    assert difference(ours, theirs) > 1e-3


@pytest.mark.parametrize("drive", DRIVES)
def test_every_branch_of_the_plant_is_in_it(yardstick, drive):
    scenario = operating_scenario(1200, "ideal", 0.5)
    scenario = scenario.replaced(drive=scenario.drive.replaced(**DRIVES[drive]))
    ours = run_scenario(scenario, load_controller(resolve_candidate("initial")), trace_every=1)
    theirs = yardstick.prepared(scenario)(recorded=True)
    apart = difference(ours, theirs)
    assert apart <= TOLERANCE, f"{drive}: they are {apart:.1e} apart"
    assert theirs.mismatch <= TOLERANCE, f"{drive}: its energy closes to {theirs.mismatch:.1e} only"


def test_a_run_that_it_does_not_know_is_refused(yardstick):
    falling = operating_scenario(1500, "ideal", 1.0).replaced(speed_rpm=((0.0, 1500.0), (1.0, 1400.0)))
    with pytest.raises(HarnessFault, match="steady speed"):
        yardstick.prepared(falling)


def test_sources_that_do_not_compile_are_reported_in_one_sentence(tmp_path):
    (tmp_path / "yardstick.c").write_text("int yardstick_run(void) { return nothing; }\n")
    with pytest.raises(InputError, match=r"does not compile with -std=c11 -O3.*nothing"):
        build_yardstick(tmp_path, tmp_path)
