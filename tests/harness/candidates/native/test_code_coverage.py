"""What runs reach of a candidate in C: counted next to the plain build, which goes on answering."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from tests.harness.candidates.native.duty_sources import duty_source

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.kinds import KINDS
from drivegate.candidates.reached_code import SourceFile, reached_branches, reached_lines
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge, own_candidate
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

BRANCHING = """
    if (sense->supply_voltage < 1.0)
        command->duty_ratios[0] = 0.5;
    if (sense->supply_voltage < 2.0) command->fault = 1; /* GCOVR_EXCL_LINE */
"""
GLOBAL = """#include "drivegate_duty.h"
static int64_t steps;
int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }
int64_t drivegate_state_size(void) { return 0; }
int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *plate) {
    return state != 0 || plate->pole_pairs < 1;
}
void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    (void)state, (void)sense;
    steps += 1;
    for (int leg = 0; leg < 3; ++leg) command->duty_ratios[leg] = 0.5;
}
"""


@pytest.fixture(scope="module")
def short() -> Scenario:
    scenario = torque_scenario(load_drive("pm-ac-interior"), 600.0, (0.0,)).replaced(duration_s=0.02)
    loaded = own_candidate(resolve_candidate("foc"))
    recorded(loaded, scenario, loaded.controller())
    return scenario


def run_once(loaded: JudgedCandidate, scenario: Scenario) -> DutyRecord:
    return recorded(loaded, scenario, loaded.controller())


def counted_runs(candidate: Candidate, scenario: Scenario, times: int = 1) -> list[DutyRecord | Fault]:
    """Run a candidate once in each of several processes."""
    endings = []
    for _ in range(times):
        with Judge(candidate) as judge:
            endings.append(judge.once(Job(run_once, scenario)))
    return endings


@pytest.fixture
def counted(tmp_path: Path, written: Callable[..., Path]) -> Callable[[str], Candidate]:
    def make(source: str) -> Candidate:
        # A name that a shell would split, and settings that leave out everything.
        project = tmp_path / "größer als 1"
        project.mkdir()
        (project / "pyproject.toml").write_text('[tool.gcovr]\nexclude = [".*"]\n', encoding="utf-8")
        candidate = resolve_candidate(str(written(project, source)))
        folder = tmp_path / "counted"
        folder.mkdir()
        return KINDS["c"].counted_candidate(candidate, folder)

    return make


def measured(candidate: Candidate, folder: Path) -> SourceFile:
    (file,) = KINDS["c"].measured_files(candidate, folder)
    return file


def line_with(file: SourceFile, text: str) -> int:
    return next(number for number, line in enumerate(file.text, 1) if text in line)


def test_all_processes_count_together_and_the_plain_build_answers(
    counted: Callable[[str], Candidate], short: Scenario, tmp_path: Path
) -> None:
    candidate = counted(duty_source(fifth_step=BRANCHING))
    records = counted_runs(candidate, short, times=2)
    plain = counted_runs(resolve_candidate(candidate.specification), short)
    assert [record.run.digest for record in records] == 2 * [record.run.digest for record in plain]
    file = measured(candidate, tmp_path)
    lines = {line.number: line for line in file.lines}
    assert lines[line_with(file, "self->steps += 1")].count == 2 * short.control_periods
    assert lines[line_with(file, "duty_ratios[0] = 0.5")].count == 0
    assert sorted(lines[line_with(file, "supply_voltage < 1.0")].branches) == [0, 2]
    assert line_with(file, "EXCL_LINE") not in lines
    reached, branches = reached_lines([file]), reached_branches([file])
    assert (reached.total - reached.reached, branches.total - branches.reached) == (1, 1)
    assert f"DA:{line_with(file, 'duty_ratios[0] = 0.5')},0" in (tmp_path / "coverage.info").read_text()
    assert 'line-rate="0.9' in (tmp_path / "coverage.xml").read_text()


def test_a_controller_with_globals_is_counted_although_they_are_put_back(
    counted: Callable[[str], Candidate], short: Scenario, tmp_path: Path
) -> None:
    candidate = counted(GLOBAL)
    (record,) = counted_runs(candidate, short)
    assert isinstance(record, DutyRecord), record
    file = measured(candidate, tmp_path)
    counts = {line.number: line.count for line in file.lines}
    assert counts[line_with(file, "steps += 1")] == short.control_periods


def test_a_build_that_answers_otherwise_is_a_fault(
    counted: Callable[[str], Candidate], short: Scenario
) -> None:
    other = "\n#ifdef DRIVEGATE_COUNTS\ncommand->duty_ratios[1] += 1e-9;\n#endif\n"
    (fault,) = counted_runs(counted(duty_source(fifth_step=other)), short)
    assert isinstance(fault, Fault)
    assert (fault.kind, fault.step) == (FaultKind.BUILDS, 4)
    assert "second_duty is 0.5" in fault.message


def test_a_library_without_sources_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="'foc' is of the kind 'builtin'; leave the option out"):
        KINDS["builtin"].counted_candidate(resolve_candidate("foc"), tmp_path)


def test_a_missing_tool_is_named(
    counted: Callable[[str], Candidate], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"--coverage needs the tool gcovr.*drivegate\[coverage\]"):
        counted(GLOBAL)
