"""A candidate is run, judged and compared at the control period and the delay that its manifest states."""

from __future__ import annotations

from pathlib import Path

import pytest

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.duty.numbers import numbers
from drivegate.contracts.duty.run import duty_nameplate
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.contracts.duty.torque import torque_course
from drivegate.drives.kinds import common_drive, drive_for, scenario_at_declared_timing
from drivegate.drives.running import recorded
from drivegate.output.wording import drive_in_words
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError

INTERIOR = load_drive("pm-ac-interior")
RUN = torque_scenario(INTERIOR.replaced(settling_s=0.02), 1000.0, (0.0, 1.0))


def candidate(folder: Path, every: int | None, delay: int | None = None) -> Candidate:
    """Return foc with a manifest that states its control period and its delay."""
    name = f"every-{every}"
    keys = {"control_every": every, "update_delay": delay}
    line = "".join(f"{key} = {value}\n" for key, value in keys.items() if value is not None)
    (folder / f"{name}.toml").write_text(
        f'schema = 1\nname = "{name}"\nkind = "builtin"\nentry = "foc"\n{line}', encoding="utf-8"
    )
    return resolve_candidate(str(folder / f"{name}.toml"))


def test_its_drive_has_its_control_period_and_the_limits_that_follow(tmp_path: Path) -> None:
    twice = candidate(tmp_path, 2)
    drive = drive_for(twice, INTERIOR)
    assert drive.control_period_s == 2.0 * 1e-4
    assert numbers(INTERIOR, twice.declaration)["rise"].startswith("90 % within 1.2 ms")
    assert numbers(drive, twice.declaration)["rise"].startswith("90 % within 2.4 ms")
    named = {"name": drive.name, "document": drive.to_mapping()}
    assert drive_in_words(named) == "pm-ac-interior, a step every 2 carrier periods (200 µs)"
    # One is what a drive has that states none, down to its hash.
    once = drive_for(candidate(tmp_path, 1, 1), drive)
    assert (once, once.values_hash) == (INTERIOR, INTERIOR.values_hash)
    assert drive_in_words({"name": once.name, "document": once.to_mapping()}) == "pm-ac-interior"
    assert drive_for(candidate(tmp_path, None), drive) == drive


def test_a_run_has_a_step_in_every_second_carrier_period(tmp_path: Path) -> None:
    twice = candidate(tmp_path, 2)
    scenario = scenario_at_declared_timing(RUN, [twice])
    assert duty_nameplate(scenario).control_every == 2
    loaded = own_candidate(twice)
    record = recorded(loaded, scenario, loaded.controller())
    assert len(record.run.commands) == RUN.control_periods // 2
    assert record.run.column("torque")[-1] == pytest.approx(1.0, rel=0.02)
    # The plant given the commands once more goes through the same currents, carrier period by carrier period.
    first = len(record.run.commands) - 10
    course = torque_course(record, first, 10)
    assert course.direct == pytest.approx(record.run.column("direct")[first:], abs=1e-9)
    assert course.torque.lengths.sum() == pytest.approx(10 * 2e-4)


def test_candidates_are_compared_at_one_rate_which_a_further_one_follows(tmp_path: Path) -> None:
    twice, foc = candidate(tmp_path, 2), resolve_candidate("foc")
    assert common_drive([foc, twice], INTERIOR).control_period_s == 2e-4
    with pytest.raises(
        InputError, match=r"'every-2' has control_every = 2 and that of 'every-4' 4, but candidates"
    ):
        common_drive([twice, candidate(tmp_path, 4)], INTERIOR)


def test_a_drive_that_does_not_bear_it_is_refused_by_the_name_of_the_candidate(tmp_path: Path) -> None:
    with pytest.raises(
        InputError,
        match=r"drive 'pm-ac-2kw' cannot have what the manifest states: in the key 'inverter', .*carrier = \"double\"",
    ) as refused:
        drive_for(candidate(tmp_path, 2), load_drive("pm-ac-2kw"))
    assert "\n" not in str(refused.value)


def test_an_answer_that_acts_at_once_does_so_in_the_run_and_on_the_nameplate(tmp_path: Path) -> None:
    at_once = candidate(tmp_path, None, 0)
    scenario = scenario_at_declared_timing(RUN, [at_once])
    assert duty_nameplate(scenario).update_delay == 0
    named = {"name": "mine", "document": scenario.drive.to_mapping()}
    assert drive_in_words(named) == "mine, answers act in the period of their sample"
    loaded = own_candidate(at_once)
    peaks = {
        run.drive.inverter.update_delay: recorded(loaded, run, loaded.controller()).run.column("peak_current")
        for run in (RUN, scenario)
    }
    assert (peaks[1][0], peaks[0][0] > 0.0) == (0.0, True), (
        "with a delay, the first answer acts in the second period"
    )
    with pytest.raises(InputError, match="has update_delay = 0 and that of 'every-2' 1"):
        common_drive([at_once, candidate(tmp_path, 2, 1)], INTERIOR)
