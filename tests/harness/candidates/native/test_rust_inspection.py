"""Candidates in Rust, counted and with checks of what is undefined, by the commands that build them."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest

from drivegate.candidates.candidate import Candidate, NativeBuild
from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.kinds import KINDS
from drivegate.candidates.native.rust_build import RustCompiler, rust_build, rust_compiler
from drivegate.candidates.native.rust_coverage import tools_of
from drivegate.candidates.resolution import resolve_candidate
from drivegate.candidates.sanitizers import read_report
from drivegate.containment.judge import Judge, own_candidate
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

pytestmark = pytest.mark.needs("rustc")

SOURCE = Path(__file__).with_name("seeded_faults.rs")
COMPILED = "rustc --edition 2021 --crate-type cdylib -C panic=abort -C opt-level=2 -A warnings -o faults.so faults.rs"
MANIFEST = f"""schema = 1
name = "faults"
kind = "so"
entry = "faults.so"
contract = "duty"
sources = ["faults.rs"]
build = ["{COMPILED}"]
"""
UNDEFINED = {
    1: ("past the end", "index out of bounds: the len is 3 but the index is 3"),
    2: ("overflow of a product", "attempt to multiply with overflow"),
    3: ("shift by 32", "attempt to shift left with overflow"),
    4: ("division by zero", "attempt to divide by zero"),
    5: ("misaligned access", "misaligned pointer dereference"),
    6: ("unchecked index", "unsafe precondition"),
}


def scenario_with(number: int) -> Scenario:
    scenario = torque_scenario(load_drive("pm-ac-interior"), 600.0, (0.1 * number,))
    return scenario.replaced(duration_s=0.005)


def run_once(loaded: JudgedCandidate, scenario: Scenario) -> DutyRecord:
    return recorded(loaded, scenario, loaded.controller())


def line_of(comment: str) -> int:
    text = SOURCE.read_text(encoding="utf-8").splitlines()
    return next(number for number, line in enumerate(text, 1) if line.endswith(f"// {comment}"))


@pytest.fixture(scope="module")
def faults(tmp_path_factory: pytest.TempPathFactory) -> Candidate:
    loaded = own_candidate(resolve_candidate("foc"))
    recorded(loaded, scenario_with(0), loaded.controller())
    # A name that a shell would split.
    return candidate_in(tmp_path_factory.mktemp("faults") / "größer als 1")


def candidate_in(folder: Path) -> Candidate:
    folder.mkdir()
    shutil.copy(SOURCE, folder / "faults.rs")
    (folder / "candidate.toml").write_text(MANIFEST, encoding="utf-8")
    return resolve_candidate(str(folder / "candidate.toml"))


@pytest.fixture(scope="module")
def undefined(faults: Candidate, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Judge]:
    candidate = KINDS["so"].sanitized_candidate(faults, ("undefined",), tmp_path_factory.mktemp("undefined"))
    with Judge(candidate) as judge:
        yield judge


def _fault(number: int, comment: str, message: str) -> object:
    marks = () if number in (3, 6) else pytest.mark.nightly
    return pytest.param(number, comment, message, id=comment, marks=marks)


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("number", "comment", "message"), [_fault(number, *fault) for number, fault in UNDEFINED.items()]
)
def test_each_fault_is_reported_with_its_line(
    undefined: Judge, number: int, comment: str, message: str
) -> None:
    fault = undefined.once(Job(run_once, scenario_with(number)))
    assert isinstance(fault, Fault), "nothing was reported"
    place = f"faults.rs, line {line_of(comment)}"
    assert (fault.kind, fault.error, fault.step) == (FaultKind.SANITIZER, place, 10), fault
    assert fault.message.startswith(f"{place}: {message}")


# NEEDS
def test_lines_are_counted_in_a_build_of_its_own(faults: Candidate, tmp_path: Path) -> None:
    folder = tmp_path / "counted"
    folder.mkdir()
    candidate = KINDS["so"].counted_candidate(faults, folder)
    with Judge(candidate) as judge, Judge(faults) as plain:
        record, own = (each.once(Job(run_once, scenario_with(0))) for each in (judge, plain))
    assert isinstance(record, DutyRecord), record
    assert isinstance(own, DutyRecord), own
    assert record.run.digest == own.run.digest
    (file,) = KINDS["so"].measured_files(candidate, tmp_path)
    counts = {line.number: line.count for line in file.lines}
    assert file.name == "faults.rs"
    first = next(number for number, line in enumerate(file.text, 1) if "let number" in line)
    assert counts[first] == scenario_with(0).control_periods
    assert counts[line_of("shift by 32")] == 0
    assert f"DA:{line_of('shift by 32')},0" in (tmp_path / "coverage.info").read_text()
    assert 'filename="faults.rs"' in (tmp_path / "coverage.xml").read_text()


def test_a_build_that_names_its_files_is_not_that_of_a_copy(faults: Candidate, tmp_path: Path) -> None:
    libraries = []
    for candidate in (faults, candidate_in(tmp_path / "copy")):
        built = KINDS["so"].sanitized_candidate(candidate, ("undefined",), tmp_path).instrumented
        assert built is not None
        libraries.append(built.library)
    assert libraries[0] != libraries[1]


def test_what_the_toolchain_cannot_is_refused(faults: Candidate, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--sanitize float serves candidates in C and C"):
        KINDS["so"].sanitized_candidate(faults, ("float",), tmp_path)
    if not rust_compiler(rust_build(faults, "--sanitize"), "--sanitize").is_nightly:
        with pytest.raises(InputError, match="needs a nightly toolchain of Rust, but rustc is 1"):
            KINDS["so"].sanitized_candidate(faults, ("address",), tmp_path)
    with pytest.raises(InputError, match=r"of LLVM 999, which rustc 1\.0 .*apt install llvm-999"):
        tools_of(RustCompiler("1.0", 999, tmp_path, "x86_64-unknown-linux-gnu"))


def test_a_library_without_sources_in_rust_is_refused(faults: Candidate, tmp_path: Path) -> None:
    library = tmp_path / "mine.so"
    assert isinstance(faults.details, NativeBuild)
    shutil.copy(faults.details.library, library)
    given = resolve_candidate(str(library))
    for method, words in (
        (KINDS["so"].counted_candidate, ()),
        (KINDS["so"].sanitized_candidate, (("address",),)),
    ):
        with pytest.raises(
            InputError, match=r"needs the sources of 'mine\.so', which is a library: name them"
        ):
            method(given, *words, tmp_path)


def test_panics_are_read_as_each_version_of_rust_prints_them() -> None:
    sources = [Path("/home/me/src/lib.rs")]
    for printed in (
        "thread '<unnamed>' (17) panicked at src/lib.rs:9:5:\nattempt to divide by zero\n",
        "thread 'main' panicked at 'attempt to divide by zero', src/lib.rs:9:5\nnote: run\n",
        "thread 'main' panicked at /rustc/1/library/core/src/num.rs:1:2:\nattempt to divide by zero\nstack backtrace:\n"
        "   0: core::panicking\n             at /rustc/1/library/core/src/panicking.rs:7:5\n"
        "   1: mine::step\n             at /home/me/src/lib.rs:9:5\n",
        # Shortened, from the candidate's folder and from the one above.
        "thread 'main' panicked at /rustc/1/library/core/src/num.rs:1:2:\nattempt to divide by zero\nstack backtrace:\n"
        "   0: <i16>::abs\n             at /rustc/1/library/core/src/num.rs:7:5\n"
        "   1: mine::step\n             at ./src/lib.rs:9:5\n",
        "thread 'main' panicked at /rustc/1/library/core/src/num.rs:1:2:\nattempt to divide by zero\nstack backtrace:\n"
        "   1: mine::step\n             at ./me/src/lib.rs:9:5\n",
    ):
        report = read_report(printed, Path("/home/me"), sources)
        assert report is not None
        assert re.fullmatch(r"src/lib\.rs, line 9: attempt to divide by zero", report.message)
