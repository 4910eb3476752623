"""`drivegate diff` of candidates that answer with duty ratios."""

from __future__ import annotations

import pytest

from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.contracts.duty.scenarios.compared import with_other_dead_time
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.sensors import SHUNTS

CONTROLLERS = """
from math import nan
from drivegate import DutyCommand

class One:
    def reset(self, nameplate): self.steps = 0
    def step(self, sense):
        self.steps += 1
        return DutyCommand((0.5 + 0.001 * sense.phase_currents[0], 0.5, self.third()))
    def third(self): return 0.5

class Other(One):
    def third(self): return 0.5000000000000001 if self.steps > 120 else 0.5

class Lost(One):
    def third(self): return nan if self.steps > 70 else 0.5

class Keeps(One):
    kept = 0.0
    def third(self):
        if self.steps == 500: self.kept = 0.001
        return 0.5 + self.kept
"""


@pytest.fixture
def files(tmp_path) -> None:
    (tmp_path / "mine.py").write_text(CONTROLLERS, encoding="utf-8")
    drive = load_drive("pm-ac-surface").replaced(settling_s=0.05)
    assert isinstance(drive, PmAcDocument)
    case = torque_scenario(drive, 300.0, (0.0, 5.0))
    (tmp_path / "case.json").write_text(case.to_json(), encoding="utf-8")
    seen = SHUNTS.model_copy(update={"encoder_lines": 1024})
    (tmp_path / "seen.json").write_text(case.replaced(sensors=seen).to_json(), encoding="utf-8")


def diff(command, one: str, other: str, *words: object):
    return command("diff", one, other, "--case", "case.json", *words)


@pytest.mark.parametrize("case", ["case.json", "seen.json"])
def test_the_second_is_given_to_the_last_bit_what_the_first_sensed(case, command, files) -> None:
    ended = command("diff", "foc", "foc", "--case", case)
    assert ended.code == 0, ended.out
    assert "EQUAL in all 1260 steps" in ended.out


def test_a_slow_run_that_is_also_made_with_another_dead_time_is_compared_as_it_is(
    command, files, tmp_path
) -> None:
    drive = load_drive("pm-ac-surface").replaced(settling_s=0.05)
    assert isinstance(drive, PmAcDocument)
    slow = torque_scenario(drive, 0.06 * drive.rating.base_speed_rpm, (5.0,))
    assert with_other_dead_time(slow) is not None, "this run is made twice for its checks"
    (tmp_path / "case.json").write_text(slow.to_json(), encoding="utf-8")
    found = diff(command, "mine.py:One", "mine.py:Other", "--json").document["difference"]
    assert found["plant"]["phase_currents"] == pytest.approx(found["sense"]["phase_currents"], abs=1e-9)


def test_the_first_difference_is_shown_in_full(command, files, tmp_path) -> None:
    ended = diff(command, "mine.py:One", "mine.py:Other", "--before", 1, "--set", "friction_n_m=0.001")
    assert ended.code == 1
    assert "DIFFERENT first in step 120, at 0.012 s" in ended.out
    assert "+1.11e-16 (1 ULP)" in ended.out
    assert "phase_currents[3]" in ended.out
    assert "--case case.json --set friction_n_m=0.001 --plot difference.svg" in " ".join(ended.out.split())
    document = diff(command, "mine.py:One", "mine.py:Other", "--plot", "x.svg", "--json").document
    found = document["difference"]
    assert [field["field"] for field in found["commands"] if field["differs"]] == ["third_duty"]
    assert [step["step"] for step in found["before"]] == [117, 118, 119]
    assert found["plant"]["speed_rpm"] == pytest.approx(300.0)
    assert found["plant"]["phase_currents"] == pytest.approx(found["sense"]["phase_currents"], abs=1e-9)
    assert "third duty ratio" in (tmp_path / "x.svg").read_text(encoding="utf-8")


def test_fields_and_small_differences_may_be_left_out(command, files) -> None:
    names = ("mine.py:One", "mine.py:Other")
    assert diff(command, *names, "--ignore", "third_duty").code == 0
    assert diff(command, *names, "--tolerance", "1e-12").code == 0


@pytest.mark.parametrize(("first", "second", "place"), [("One", "Lost", "second"), ("Lost", "One", "first")])
def test_a_fault_is_reported_where_it_happens(first, second, place, command, files) -> None:
    document = diff(command, f"mine.py:{first}", f"mine.py:{second}", "--json").document
    assert (document["exit_code"], document["verdict"]) == (1, "invalid output")
    assert (document["fault"]["place"], document["fault"]["step"], document["steps_equal"]) == (place, 70, 70)


def test_what_reset_keeps_shows_in_an_instance_that_has_run_before(command, files) -> None:
    assert diff(command, "mine.py:Keeps", "mine.py:Keeps").code == 0
    document = diff(command, "mine.py:Keeps", "mine.py:Keeps", "--again", "--json").document
    assert document["difference"]["step"] == 0


def test_what_does_not_fit_the_contract_is_refused(files, refused) -> None:
    words = ("--case", "case.json")
    assert "takes duty ratios" in refused("diff", "foc", "reference", *words)
    assert "names no field" in refused("diff", "foc", "foc", *words, "--ignore", "advance_angle")
