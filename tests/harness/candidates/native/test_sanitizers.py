"""Sanitizers in a candidate's process: each fault of memory or arithmetic is reported with its line."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.kinds import KINDS
from drivegate.candidates.native.compiler import C
from drivegate.candidates.native.sanitizer_runtime import preloaded
from drivegate.candidates.resolution import resolve_candidate
from drivegate.candidates.sanitizers import SANITIZERS, read_report
from drivegate.containment.judge import Judge, own_candidate
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.running import recorded
from drivegate.gate.fault_shrinking import FaultPlan, run_fault_shrink
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

SOURCE = Path(__file__).with_name("seeded_faults.c")
IN_CPP_SOURCE = SOURCE.with_suffix(".cpp")
FAULTS = {
    1: "one past the end",
    2: "use after reset",
    3: "overflow of a product",
    4: "shift by 32",
    5: "float out of range",
    7: "misaligned access",
    8: "division by zero",
    9: "float divided by zero",
    10: "past the currents",
    11: "past an array in the state",
    12: "past the heap",
    13: "null pointer",
    14: "past the state",
}
ON_HEAP = "memory that reset allocated"
"""No compiler sees across functions what was written."""
UNWRITTEN = {6: "uninitialised read", 15: ON_HEAP, 16: "array written in part"}
UNWRITTEN_IN_CPP = {5: "member that no constructor wrote", 6: ON_HEAP}
IN_CPP = {1: "past a vector", 2: "use after it is deleted", 3: "object of another type", 4: "no truth value"}


def scenario_with(number: int) -> Scenario:
    scenario = torque_scenario(load_drive("pm-ac-interior"), 600.0, (0.1 * number,))
    return scenario.replaced(duration_s=0.005)


def line_of(comment: str, source: Path = SOURCE) -> int:
    text = source.read_text(encoding="utf-8").splitlines()
    comments = (f"/* {comment} */", f"// {comment}")
    return next(number for number, line in enumerate(text, 1) if line.endswith(comments))


def run_once(loaded: JudgedCandidate, scenario: Scenario) -> DutyRecord:
    return recorded(loaded, scenario, loaded.controller())


@pytest.fixture(scope="module")
def sanitized(tmp_path_factory: pytest.TempPathFactory) -> Candidate:
    loaded = own_candidate(resolve_candidate("foc"))
    recorded(loaded, scenario_with(0), loaded.controller())
    folder = tmp_path_factory.mktemp("sanitized")
    return KINDS["c"].sanitized_candidate(resolve_candidate(str(SOURCE)), SANITIZERS, folder)


@pytest.fixture(scope="module")
def judge(sanitized: Candidate) -> Iterator[Judge]:
    with Judge(sanitized) as judge:
        yield judge


def test_a_run_without_a_fault_is_that_of_the_plain_build(judge: Judge) -> None:
    record = judge.once(Job(run_once, scenario_with(0)))
    assert isinstance(record, DutyRecord), record
    with Judge(resolve_candidate(str(SOURCE))) as plain:
        assert plain.once(Job(run_once, scenario_with(0))).run.digest == record.run.digest


def _fault(number: int, comment: str) -> object:
    """Leave all but one of each kind to the nightly tests, since each report ends a process."""
    marks = () if number in (3, 5, 8, 14) else pytest.mark.nightly
    return pytest.param(number, comment, id=comment, marks=marks)


@pytest.mark.parametrize(("number", "comment"), [_fault(*fault) for fault in FAULTS.items()])
def test_each_fault_is_reported_with_its_line(judge: Judge, number: int, comment: str) -> None:
    fault = judge.once(Job(run_once, scenario_with(number)))
    assert isinstance(fault, Fault), "nothing was reported"
    place = f"seeded_faults.c, line {line_of(comment)}"
    assert (fault.kind, fault.error, fault.phase) == (FaultKind.SANITIZER, place, "step"), fault
    assert fault.message.startswith(f"{place}: ")
    assert fault.step == 10
    assert fault.scenario is not None
    assert fault.scenario["duration_s"] == 0.005


@pytest.mark.parametrize(("number", "comment"), UNWRITTEN.items(), ids=UNWRITTEN.values())
def test_what_is_read_before_it_is_written_shows_in_the_answer(
    judge: Judge, number: int, comment: str
) -> None:
    fault = judge.once(Job(run_once, scenario_with(number)))
    assert isinstance(fault, Fault)
    assert fault.kind is FaultKind.BUILDS
    if comment != ON_HEAP:
        assert f"seeded_faults.c, line {line_of(comment)}: use of uninitialized value" in fault.message


@pytest.mark.nightly
@pytest.mark.needs("c++")
@pytest.mark.parametrize(("number", "comment"), IN_CPP.items(), ids=IN_CPP.values())
def test_faults_that_are_of_cpp_alone_are_reported_too(tmp_path: Path, number: int, comment: str) -> None:
    fault = _fault_in_cpp(tmp_path, number)
    assert (fault.kind, fault.error) == (
        FaultKind.SANITIZER,
        f"seeded_faults.cpp, line {line_of(comment, IN_CPP_SOURCE)}",
    )


def _fault_in_cpp(folder: Path, number: int) -> Fault:
    candidate = resolve_candidate(str(IN_CPP_SOURCE))
    candidate = KINDS["c"].sanitized_candidate(candidate, ("address", "undefined"), folder)
    with Judge(candidate) as judge:
        fault = judge.once(Job(run_once, scenario_with(number)))
    assert isinstance(fault, Fault), "nothing was reported"
    return fault


@pytest.mark.nightly
@pytest.mark.needs("c++")
@pytest.mark.parametrize(("number", "comment"), UNWRITTEN_IN_CPP.items(), ids=UNWRITTEN_IN_CPP.values())
def test_what_objects_of_cpp_leave_unwritten_shows_in_the_answer(
    tmp_path: Path, number: int, comment: str
) -> None:
    fault = _fault_in_cpp(tmp_path, number)
    assert fault.kind is FaultKind.BUILDS
    if comment != ON_HEAP:
        assert f"seeded_faults.cpp, line {line_of(comment, IN_CPP_SOURCE)}: use of uni" in fault.message


@pytest.mark.nightly
def test_the_scenario_of_a_report_is_shrunk(judge: Judge) -> None:
    scenario = scenario_with(8).replaced(
        initial_angle_deg=70.0, dropouts=[{"signal": "currents", "start_s": 0.0001, "duration_s": 0.0001}]
    )
    fault = judge.once(Job(run_once, scenario))
    assert isinstance(fault, Fault)
    shrunk = judge.once(Job(run_fault_shrink, FaultPlan(fault, 15)))
    assert isinstance(shrunk, Fault)
    assert (shrunk.kind, shrunk.error) == (fault.kind, fault.error)
    assert shrunk.scenario is not None
    assert not shrunk.scenario["dropouts"]


def test_what_is_not_compiled_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--sanitize serves candidates in C, C\\+\\+ and Rust, but"):
        KINDS["builtin"].sanitized_candidate(resolve_candidate("foc"), ("address",), tmp_path)


def test_the_library_of_clang_is_loaded_before_all_others(tmp_path: Path) -> None:
    library, compiler = tmp_path / "asan.so", tmp_path / "clang-19"
    library.touch()
    compiler.write_text(
        '#!/bin/sh\ncase "$*" in\n--version) echo "clang version 19" ;;\n'
        f"*libclang_rt.asan.so) echo {library} ;;\n*) echo none ;;\nesac\n",
        encoding="utf-8",
    )
    compiler.chmod(0o755)
    loaded = preloaded((str(compiler),), C, ("address", "undefined"))
    assert loaded["LD_PRELOAD"] == str(library)
    with pytest.raises(
        InputError, match=r"needs the library libclang_rt\.ubsan.* apt install libclang-rt-19-dev"
    ):
        preloaded((str(compiler),), C, ("undefined",))


def test_the_first_report_counts_and_addresses_are_left_out() -> None:
    printed = (
        "hello\n==7==ERROR: AddressSanitizer: SEGV on unknown address 0x000000000000 (pc 0x7f bp 0x7f)\n"
        "==7==The signal is caused by a WRITE memory access.\n"
        "    #0 0x7f1 in memcpy /build/libsanitizer/asan.cpp:12\n"
        "    #1 0x7f2 in drivegate_step /home/me/src/mine.c:40\n"
        "/home/me/src/mine.c:50:3: runtime error: division by zero\n"
    )
    report = read_report(printed, Path("/home/me"), [Path("/home/me/src/mine.c")])
    assert report is not None
    assert report.message == "src/mine.c, line 40: SEGV"
    assert read_report("runtime error", Path("/home/me"), []) is None
    rest = "    #99 0x7f1 in deep /home/me/mine.c:7\nSUMMARY: AddressSanitizer: stack-overflow /home/me/mine.c:7 in f\n"
    report = read_report(rest, Path("/home/me"), [])
    assert report is not None, "the beginning of a long report is not kept"
    assert report.message == "mine.c, line 7: stack-overflow"
