"""Controllers of duty ratios in C: the contract follows from what they export, and what they do wrong is a verdict."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.harness.candidates.native.duty_sources import duty_source

from drivegate.candidates.candidate import NativeBuild
from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.native.compiler import include_folder
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import Judge, own_candidate
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.watches import WorkerLimits
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.duty.record import DutyRecord
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.kinds import drive_for
from drivegate.drives.running import recorded
from drivegate.gate.plan import time_steps
from drivegate.gate.shard import FixedRuns, run_fixed
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

INTERIOR = load_drive("pm-ac-interior")
LIMITS = WorkerLimits(step_processor_seconds=0.5)
SPIN = "for (volatile int spin = 1; spin;) {}"


@pytest.fixture(scope="module", autouse=True)
def short() -> Scenario:
    """A short run, whose kernels are compiled before any worker's time is watched."""
    scenario = torque_scenario(INTERIOR, 600.0, (0.0,)).replaced(duration_s=0.02)
    loaded = own_candidate(resolve_candidate("foc"))
    recorded(loaded, scenario, loaded.controller())
    return scenario


def run_once(loaded: JudgedCandidate, scenario: Scenario) -> CurrentRecord:
    return recorded(loaded, scenario, loaded.controller())


@pytest.fixture
def ended(
    tmp_path: Path, written: Callable[..., Path], short: Scenario
) -> Callable[..., CurrentRecord | Fault]:
    """Run a controller in a process of its own, as every check does."""

    def run(**parts: str) -> CurrentRecord | Fault:
        candidate = resolve_candidate(str(written(tmp_path, duty_source(**parts))))
        with Judge(candidate, limits=LIMITS) as judge:
            return judge.once(Job(run_once, short))

    return run


def test_its_commands_are_played_back_to_the_end(ended, tmp_path: Path, short: Scenario) -> None:
    record = ended()
    assert isinstance(record, DutyRecord), record
    assert len(record.run.commands) == short.control_periods
    # In this process, without playback, the same commands follow.
    candidate = resolve_candidate(str(tmp_path / "mine.c"))
    own = recorded(own_candidate(candidate), short, load_controller(candidate))
    assert own.run.digest == record.run.digest


def test_it_is_stepped_through_the_turns_before_a_run(
    written: Callable[..., Path], tmp_path: Path, short: Scenario
) -> None:
    source = duty_source(fifth_step="command->duty_ratios[1] = 0.875;").replace("steps == 5", "steps == 3001")
    after = short.replaced(turns_before=3)
    with Judge(resolve_candidate(str(written(tmp_path, source))), limits=LIMITS) as judge:
        record = judge.once(Job(run_once, after))
    assert isinstance(record, DutyRecord), record
    assert len(record.run.commands) == short.control_periods
    marked = [place for place, ratio in enumerate(record.run.commands["second_duty"]) if ratio == 0.875]
    assert marked == [0], "three turns at 600 rpm take 3000 control periods"


def test_it_is_repeated_judged_and_timed(written, tmp_path: Path, short: Scenario) -> None:
    with Judge(resolve_candidate(str(written(tmp_path, duty_source())))) as judge:
        outcome = judge.run(Job(run_fixed, FixedRuns((short,), repeat=True)))
        timed = judge.run(Job(time_steps, torque_scenario(INTERIOR, 600.0, (0.0,))))
    margins = {margin.check: margin for run in outcome.runs for margin in run.margins}
    assert margins["DET-1"].measured == "2 repetitions are the same"
    assert margins["DUT-1"].met
    (timing,) = timed.runs[0].margins
    assert "(native)" in timing.measured


def test_a_duty_ratio_beyond_its_range_fails_its_check(ended) -> None:
    record = ended(fifth_step="command->duty_ratios[1] = 1.2;")
    margins = {margin.check: margin for margin in judged(record, contract_of(INTERIOR).checks).margins}
    assert not margins["DUT-1"].met
    assert "to 1.2" in margins["DUT-1"].measured


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("statement", "message"),
    [
        ("command->duty_ratios[2] = NAN;", "the duty ratios are not all finite: "),
        ("command->duty_ratios[0] = -INFINITY;", "-inf"),
        ("command->legs[1] = 7;", "the legs are 1, 7, 1, but each must be from 0 to 3"),
        ("command->struct_size = -1;", "the command's struct_size was overwritten with a negative number"),
    ],
)
def test_an_answer_that_is_none_is_reported_with_its_inputs(ended, statement: str, message: str) -> None:
    fault = ended(fifth_step=statement)
    assert (fault.kind, fault.phase, fault.step) == (FaultKind.INVALID_OUTPUT, "step", 4), fault
    assert message in fault.message
    assert fault.time == pytest.approx(4 * INTERIOR.inverter.control_period_s)
    assert fault.sense["supply_voltage"] == INTERIOR.inverter.link_voltage_v
    assert len(fault.sense["phase_currents"]) == 3


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("parts", "kind", "message"),
    [
        ({"fifth_step": "*(volatile int *)8 = 1;"}, FaultKind.CRASH, "SIGSEGV"),
        ({"fifth_step": "exit(3);"}, FaultKind.CRASH, "ended itself with exit status 3"),
        ({"fifth_step": SPIN}, FaultKind.HANG, "processor time after 4 completed steps"),
        (
            {"reset": "return 7;"},
            FaultKind.EXCEPTION,
            "drivegate_duty_reset returned 7, which refuses the run",
        ),
    ],
)
def test_what_ends_its_process_or_its_reset_is_reported(ended, parts, kind: FaultKind, message: str) -> None:
    fault = ended(**parts)
    assert fault.kind is kind, fault
    assert message in fault.message


BOTH = (
    "int drivegate_reset(void *s, const drivegate_nameplate *n) { (void)s, (void)n; return 0; }\n"
    "void drivegate_step(void *s, const drivegate_sense *x, drivegate_command *c) { (void)s, (void)x, (void)c; }\n"
)


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        (
            {"version": "int64_t drivegate_abi_version(void) { return 2000; }"},
            r"for version 2\.0 of the contract",
        ),
        ({"version": ""}, r"mine\.c does not export drivegate_abi_version; .* drivegate_duty\.h declares"),
        (
            {"top": BOTH},
            r"exports both drivegate_step and drivegate_duty_step; export the pair of one contract",
        ),
    ],
)
def test_a_library_that_cannot_be_used_is_refused(ended, parts, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence) as caught:
        ended(**parts)
    assert str(caught.value).isprintable()


def test_the_contract_follows_from_what_a_source_or_a_library_exports(
    tmp_path: Path, written: Callable[..., Path], controller_source: Callable[..., str]
) -> None:
    source = written(tmp_path, duty_source())
    candidate = resolve_candidate(str(source))
    assert candidate.contract == "duty"
    assert drive_for(candidate).kind == "pm-ac"
    library = tmp_path / "mine.so"
    subprocess.run(
        ["cc", "-shared", "-fPIC", f"-I{include_folder()}", str(source), "-o", str(library), "-lm"],
        check=True,
    )
    candidate = resolve_candidate(str(library))
    assert (candidate.kind, candidate.contract) == ("so", "duty")
    assert isinstance(candidate.details, NativeBuild)
    currents = resolve_candidate(str(written(tmp_path, controller_source(), "other.c")))
    assert currents.contract == "current"


def test_a_candidate_of_one_contract_is_refused_on_a_drive_of_the_other(
    tmp_path: Path, written: Callable[..., Path], controller_source: Callable[..., str]
) -> None:
    ratios = resolve_candidate(str(written(tmp_path, duty_source())))
    with pytest.raises(
        InputError, match=r"'mine\.c' answers with duty ratios, but the drive 'paper-5-phase'"
    ):
        drive_for(ratios, load_drive("paper-5-phase"))
    currents = resolve_candidate(str(written(tmp_path, controller_source(), "other.c")))
    with pytest.raises(InputError, match=r"'other\.c' answers with a current reference .* takes duty ratios"):
        drive_for(currents, INTERIOR)


def manifest(folder: Path, *lines: str) -> str:
    file = folder / "candidate.toml"
    text = "\n".join(['schema = 1\nname = "mine"\nkind = "c"\nentry = "mine.c"', *lines, ""])
    file.write_text(text, encoding="utf-8")
    return str(file)


def test_a_manifest_may_state_the_contract_and_must_state_the_right_one(
    tmp_path: Path, written: Callable[..., Path]
) -> None:
    written(tmp_path, duty_source())
    candidate = resolve_candidate(manifest(tmp_path, 'contract = "duty"', 'drive = "pm-ac-surface"'))
    assert drive_for(candidate).name == "pm-ac-surface"
    with pytest.raises(
        InputError, match="the key 'contract' is 'current', but the candidate answers with duty"
    ):
        resolve_candidate(manifest(tmp_path, 'contract = "current"'))
    with pytest.raises(InputError, match="contract"):
        resolve_candidate(manifest(tmp_path, 'contract = "voltage"'))
    other = resolve_candidate(manifest(tmp_path, 'drive = "paper-5-phase"'))
    with pytest.raises(InputError, match="answers with duty ratios, but the drive 'paper-5-phase'"):
        drive_for(other)


def test_a_candidate_of_an_earlier_header_runs_unchanged(
    written: Callable[..., Path], tmp_path: Path, short: Scenario
) -> None:
    # Its records end before the fields that were appended since.
    for header in ("drivegate.h", "drivegate_duty.h"):
        text = (include_folder() / header).read_text(encoding="utf-8")
        text = re.sub(r"(?s)    double (mean_voltages\[3\]|voltage_filter); +/\*.*?\*/\n", "", text)
        text = text.replace("nameplate) == 328", "nameplate) == 320").replace(
            "sense) == 160", "sense) == 136"
        )
        (tmp_path / header).write_text(text, encoding="utf-8")
    assert "mean_voltages" not in (tmp_path / "drivegate_duty.h").read_text(encoding="utf-8")
    records = []
    for folder in (tmp_path, tmp_path / "new"):
        folder.mkdir(exist_ok=True)
        candidate = resolve_candidate(str(written(folder, duty_source())))
        records.append(recorded(own_candidate(candidate), short, load_controller(candidate)))
    assert records[0].run.digest == records[1].run.digest
