"""What runs reach of a candidate in Python."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from drivegate.candidates.kinds import KINDS
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import Judge, own_candidate
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.protocol import UnreadableReply, remarks_of
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario

SOURCE = """
from drivegate import DutyCommand


class Controller:
    def reset(self, nameplate):
        self.steps = 0
        if nameplate.pole_pairs < 1:  # pragma: no cover
            raise ValueError

    def step(self, sense):
        self.steps += 1
        if sense.supply_voltage < 1.0:
            self.steps = 0
        return DutyCommand((0.5, 0.5, 0.5))
"""


def run_once(loaded: JudgedCandidate, scenario: Scenario) -> DutyRecord:
    return recorded(loaded, scenario, loaded.controller())


def test_lines_and_branches_of_all_processes_are_read(tmp_path: Path) -> None:
    scenario = torque_scenario(load_drive("pm-ac-interior"), 600.0, (0.0,)).replaced(duration_s=0.005)
    loaded = own_candidate(resolve_candidate("foc"))
    recorded(loaded, scenario, loaded.controller())
    file, counted, output = tmp_path / "mine.py", tmp_path / "counted", tmp_path / "output"
    file.write_text(SOURCE, encoding="utf-8")
    counted.mkdir()
    output.mkdir()
    plain = resolve_candidate(f"{file}:Controller")
    candidate = KINDS["python"].counted_candidate(plain, counted)
    digests = []
    for which in (candidate, plain):
        with Judge(which) as judge:
            records = [judge.once(Job(run_once, scenario)) for _ in range(2)]
        assert all(isinstance(record, DutyRecord) for record in records), records
        digests.append([record.run.digest for record in records])
    assert digests[0] == digests[1]
    (measured,) = KINDS["python"].measured_files(candidate, output)
    assert measured.name == "mine.py"
    lines = {measured.text[line.number - 1].strip(): line for line in measured.lines}
    # The last line with this text, that in the step.
    assert [text for text, line in lines.items() if not line.count] == ["self.steps = 0"]
    assert sorted(lines["if sense.supply_voltage < 1.0:"].branches) == [0, 1]
    assert "raise ValueError" not in lines
    assert lines["class Controller:"].count == 1
    assert ",0" in (output / "coverage.info").read_text()
    assert "<coverage" in (output / "coverage.xml").read_text()


@pytest.mark.parametrize("kind", ["exec", "fmu", "inner"])
def test_what_cannot_be_counted_is_marked_so(kind: str) -> None:
    assert not KINDS[kind].is_counted


WARNING = """
import numpy as np

from drivegate import DutyCommand


class Controller:
    def reset(self, nameplate):
        self.integral = np.float64(1e300)

    def step(self, sense):
        self.integral = min(self.integral * self.integral, np.float64(1e300))
        return DutyCommand((0.5, 0.5, 0.5))
"""


def test_warnings_of_numpy_are_remarks_with_their_line(tmp_path: Path) -> None:
    scenario = torque_scenario(load_drive("pm-ac-interior"), 600.0, (0.0,)).replaced(duration_s=0.005)
    file = tmp_path / "mine.py"
    file.write_text(WARNING, encoding="utf-8")
    with Judge(resolve_candidate(f"{file}:Controller")) as judge:
        record = judge.once(Job(run_once, scenario))
    line = 1 + next(place for place, text in enumerate(WARNING.splitlines()) if "min(" in text)
    expected = (f"mine.py, line {line}: overflow encountered in scalar multiply",)
    assert isinstance(record, DutyRecord), record
    assert record.remarks == expected
    assert judged(record, []).remarks == expected


@pytest.mark.parametrize("text", ["{", "3", "[3]"])
def test_what_are_no_remarks_is_refused(text: str) -> None:
    with pytest.raises(UnreadableReply):
        remarks_of(text)


def test_counters_name_no_file_but_the_candidates(tmp_path: Path) -> None:
    from coverage import CoverageData

    file, counted, output = tmp_path / "mine.py", tmp_path / "counted", tmp_path / "output"
    file.write_text(SOURCE, encoding="utf-8")
    counted.mkdir()
    output.mkdir()
    candidate = KINDS["python"].counted_candidate(resolve_candidate(f"{file}:Controller"), counted)
    data = CoverageData(str(counted / ".coverage.1"))
    data.add_arcs({str(file): [(-1, 2), (2, -1)], json.__file__: [(-1, 1), (1, -1)]})
    data.write()
    (measured,) = KINDS["python"].measured_files(candidate, output)
    assert measured.name == "mine.py"


def test_sources_that_no_process_has_imported_are_not_reached(tmp_path: Path) -> None:
    """Nothing is left of a process that the candidate ends at once."""
    file, counted, output = tmp_path / "mine.py", tmp_path / "counted", tmp_path / "output"
    file.write_text(SOURCE, encoding="utf-8")
    counted.mkdir()
    output.mkdir()
    candidate = KINDS["python"].counted_candidate(resolve_candidate(f"{file}:Controller"), counted)
    (measured,) = KINDS["python"].measured_files(candidate, output)
    assert measured.name == "mine.py"
    assert {line.count for line in measured.lines} == {0}
    assert "SF:mine.py" in (output / "coverage.info").read_text(encoding="utf-8")
