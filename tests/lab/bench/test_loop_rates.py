"""A rate is reported with a check of the run that was timed."""

import os

import numpy as np
import pytest

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.running import run_scenario
from drivegate_lab.bench import measurements, plan
from drivegate_lab.bench.plan import planned
from drivegate_lab.bench.workbench import NotMeasured, operating_scenario


@pytest.fixture(scope="module")
def run():
    return run_scenario(
        operating_scenario(1500, "ideal", 1.0), load_controller(resolve_candidate("reference"))
    )


@pytest.mark.parametrize(
    ("entry", "factor", "valid"),
    [
        ("speed_final", 1.0, True),
        ("speed_final", 1.01, False),
        ("exchange_error", 1e9, False),
    ],
)
def test_speed_and_energy_decide_whether_a_run_is_right(run, monkeypatch, entry, factor, valid):
    changed = run.observed._replace(**{entry: getattr(run.observed, entry) * factor})
    monkeypatch.setitem(run.__dict__, "observed", changed)
    assert measurements.run_correctness(operating_scenario(1500, "ideal", 1.0), run).valid is valid


@pytest.mark.one_in(3)
@pytest.mark.parametrize("candidate", measurements.CANDIDATES)
def test_every_kind_of_candidate_is_measured(workbench, monkeypatch, candidate):
    monkeypatch.setitem(measurements.SIMULATED, candidate, 1.0)
    value = measurements.loop_rate(workbench, candidate, 1500, "mcs96")
    assert value.correctness.valid, value.correctness.measured
    assert value.value >= value.median > 0.0


def test_a_star_is_measured_on_its_own_plant(workbench, monkeypatch):
    monkeypatch.setitem(measurements.SIMULATED, "reference", 1.0)
    seen = []

    def watched(scenario, controller):
        seen.append(scenario.drive.name)
        return run_scenario(scenario, controller)

    monkeypatch.setattr(measurements, "run_scenario", watched)
    for name in ("star.loop.1000", "star.steady"):
        (one,) = (row for row in planned(quick=True, cold=False) if row.name == name)
        value = one.measure(workbench)
        assert value.correctness.valid, value.correctness.measured
    assert set(seen) == {"star-3-phase"}


def test_loops_are_measured_on_one_processor_which_they_give_back(workbench, monkeypatch):
    allowed, seen = os.sched_getaffinity(0), []
    monkeypatch.setitem(measurements.SIMULATED, "initial", 1.0)

    def watched(*words):
        seen.append(os.sched_getaffinity(0))
        return run_scenario(*words)

    monkeypatch.setattr(measurements, "run_scenario", watched)
    measurements.loop_rate(workbench, "initial", 1500, "ideal")
    assert {len(processors) for processors in seen} == {1}
    assert os.sched_getaffinity(0) == allowed


def test_the_overhead_of_python_is_reported_beside_the_candidates_own_time(workbench, monkeypatch):
    monkeypatch.setattr(measurements, "SIMULATED", 1.0)
    value = measurements.python_overhead(workbench)
    assert value.correctness.valid, value.correctness.measured
    assert 0.0 < value.value < 100.0
    assert value.correctness.measured.endswith("commands those of its twin in numba")


def test_an_overhead_against_a_loop_of_another_course_is_no_measure(workbench, monkeypatch):
    monkeypatch.setattr(measurements, "SIMULATED", 3.0)
    monkeypatch.setattr(measurements, "TWIN", "reference")
    assert not measurements.python_overhead(workbench).correctness.valid


def test_a_kind_whose_compiler_is_missing_says_so(workbench, monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(NotMeasured, match="no-such-compiler"):
        measurements.loop_rate(workbench, "c", 1500, "ideal")


@pytest.mark.parametrize("band", [0.25, 0.0])
def test_steady_states_are_checked_by_their_power(workbench, monkeypatch, band):
    assert measurements.steady_rate(workbench, band).correctness.valid
    monkeypatch.setattr(measurements, "CLOSING", -1.0)
    assert not measurements.steady_rate(workbench, band).correctness.valid


def test_the_oracle_is_checked_at_the_angle_that_it_found(workbench, monkeypatch):
    assert measurements.oracle_time(workbench, 1500.0, 9.8).correctness.valid
    found = measurements.oracle_time(workbench, 1500.0, 9.8).correctness.measured
    assert "9.8000 N·m" in found
    from drivegate_models.steady import oracle

    shifted = oracle.least_current_sum

    def wrong(*words):
        best = shifted(*words)
        return best._replace(current_sum=best.current_sum * 1.001)

    monkeypatch.setattr(oracle, "least_current_sum", wrong)
    assert not measurements.oracle_time(workbench, 1500.0, 9.8).correctness.valid


def test_memory_that_grows_is_wrong(workbench, monkeypatch):
    assert plan.run_memory(workbench).correctness.valid
    real, kept = plan.run_scenario, []

    def keeping(scenario, controller):
        kept.append(np.zeros(int(1000 * scenario.duration_s)))
        return real(scenario, controller)

    monkeypatch.setattr(plan, "run_scenario", keeping)
    assert not plan.run_memory(workbench).correctness.valid
