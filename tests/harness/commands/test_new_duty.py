"""`drivegate new` for controllers of duty ratios: one algorithm in every language, on every packaged drive."""

from __future__ import annotations

import re
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from drivegate.candidates.fault import Fault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.contracts.catalogue import contract_of
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.duty.scenarios.building import speed_scenario, torque_of, torque_scenario
from drivegate.drives.kinds import drive_for
from drivegate.drives.running import recorded
from drivegate.results.waivers import read_waivers
from drivegate.studies.diff.diff import Rule, compared
from drivegate.studies.new import KINDS, write_candidate
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.errors import InputError

TODAY = datetime.now(UTC).date()
DUTY_KINDS = ("c", "embedded-coder")
"""Both algorithms; the other languages have the commands of C, bit for bit."""
NEEDED = {"rust": "cargo", "cortex-m": "arm-none-eabi-gcc"}
LANGUAGES = [
    pytest.param(kind, marks=[pytest.mark.needs(NEEDED[kind])] if kind in NEEDED else [])
    for kind in KINDS
    if kind not in DUTY_KINDS
]
DRIVES = ("pm-ac-surface", "pm-ac-interior", "pm-ac-2kw", "pm-ac-msl")


def run_once(loaded: JudgedCandidate, scenario: Scenario) -> CurrentRecord:
    return recorded(loaded, scenario, loaded.controller())


@pytest.fixture
def written(tmp_path: Path):
    """Write a candidate."""

    def write(kind: str, drive: str | None = None) -> Path:
        folder = tmp_path / f"{kind}-{drive}"
        write_candidate(kind, "mine", folder, TODAY, drive)
        return folder

    return write


def plain_runs(drive: str) -> tuple[Scenario, Scenario, Scenario]:
    """Give steps of torque below base speed, a step of speed into weakening, and the highest speed without torque."""
    document = load_drive(drive)
    assert isinstance(document, PmAcDocument)
    base, highest = document.rating.base_speed_rpm, document.rating.highest_speed_rpm
    levels = [torque_of(document, 0.5 * base, share) for share in (0.0, 0.5, 0.3)]
    above = 0.5 * (base + highest)
    loaded = speed_scenario(document, (0.8 * base, above), torque_nm=torque_of(document, above, 0.5))
    return torque_scenario(document, 0.5 * base, levels), loaded, torque_scenario(document, highest, (0.0,))


@pytest.mark.parametrize("kind", DUTY_KINDS)
@pytest.mark.one_in(4)
@pytest.mark.parametrize("drive", DRIVES)
def test_it_follows_steps_into_weakening_on_every_packaged_drive(written, kind: str, drive: str) -> None:
    candidate = resolve_candidate(str(written(kind) / "candidate.toml"))
    required = {"ACC-1", "DUT-1", "OVC-1"}
    with Judge(candidate) as judge:
        for scenario in plain_runs(drive):
            record = judge.run(Job(run_once, scenario))
            assert not isinstance(record, Fault), record
            margins = {m.check: m for m in judged(record, contract_of(scenario.drive).checks).margins}
            missed = {check: margins[check].measured for check in required if not margins[check].met}
            assert missed == {}, f"{kind} on {drive}: {missed}"


@pytest.mark.one_in(2)
@pytest.mark.parametrize("kind", DUTY_KINDS)
def test_it_begins_without_a_peak_on_a_machine_of_another_flux(written, kind: str) -> None:
    spinning = torque_scenario(load_drive("pm-ac-interior"), 1890.0, (0.0,)).replaced(
        duration_s=0.02, scales={"emf_constant": 0.9}
    )
    with Judge(resolve_candidate(str(written(kind) / "candidate.toml"))) as judge:
        record = judge.run(Job(run_once, spinning))
    peaks = record.run.column("peak_current")
    assert peaks[:30].max() < 1.15 * peaks[90:].max(), "the integrals begin at what is sensed"


@pytest.mark.one_in(2)
@pytest.mark.parametrize("kind", LANGUAGES)
def test_every_language_has_the_commands_of_c(written, kind: str) -> None:
    # The bridge is closed on a spinning machine, which accelerates into weakening and brakes.
    run = speed_scenario(load_drive("pm-ac-interior"), (1890.0,), torque_nm=0.5).replaced(
        duration_s=0.25,
        speed_rpm=((0.0, 1890.0), (0.05, 1890.0), (0.05, 4000.0), (0.2, 4000.0), (0.2, 1000.0)),
    )
    answers = [resolve_candidate(str(written(name) / "candidate.toml")) for name in ("c", kind)]
    # The image computes in single precision.
    rule = Rule(0.02) if kind == "cortex-m" else Rule()
    ended = compared(*answers, run, rule, before=0, after=0)
    assert (ended.fault, ended.difference, ended.steps) == (None, None, run.control_periods)


def test_the_source_of_an_image_is_also_checked_as_compiled_for_this_machine(written) -> None:
    run = torque_scenario(load_drive("pm-ac-surface"), 400.0, (0.5,)).replaced(duration_s=0.05)
    folder = written("cortex-m", "pm-ac-surface")
    host = resolve_candidate(str(folder / "host.toml"))
    assert (host.name, drive_for(host).name) == ("mine-host", "pm-ac-surface")
    ended = compared(
        resolve_candidate(str(written("c") / "candidate.toml")), host, run, Rule(0.001), before=0, after=0
    )
    assert (ended.fault, ended.difference, ended.steps) == (None, None, run.control_periods)


def test_both_templates_ask_for_nearly_the_same_duty_ratios(written) -> None:
    torques, _, _ = plain_runs("pm-ac-interior")
    answers = []
    for kind in DUTY_KINDS:
        with Judge(resolve_candidate(str(written(kind) / "candidate.toml"))) as judge:
            record = judge.run(Job(run_once, torques))
        answers.append(
            np.mean([record.run.column("quadrature")[-500:], record.run.column("direct")[-500:]], axis=1)
        )
    assert np.allclose(*answers, atol=0.02), (
        f"steady currents of the two differ by more than counts: {answers}"
    )


@pytest.mark.one_in(2)
@pytest.mark.parametrize("kind", DUTY_KINDS)
def test_it_is_judged_on_the_drive_that_is_named(written, kind: str) -> None:
    plain = resolve_candidate(str(written(kind) / "candidate.toml"))
    assert (plain.contract, drive_for(plain).name) == ("duty", "pm-ac-interior")
    named = written(kind, "pm-ac-surface")
    assert drive_for(resolve_candidate(str(named / "candidate.toml"))).name == "pm-ac-surface"
    assert read_waivers(named / "waivers.toml", ["mine"]) == (), "none of its failures is known beforehand"


def test_a_template_of_one_contract_is_not_written_for_a_drive_of_the_other(written) -> None:
    with pytest.raises(
        InputError,
        match=r"'paper-5-phase' .* takes a current reference .* take one of python, numba, c, c\+\+, rust",
    ):
        written("embedded-coder", "paper-5-phase")


@pytest.mark.parametrize(
    ("file", "line", "sentence"),
    [
        (
            "model/controller.h",
            r".*ElectricalSpeed;.*\n",
            r"adapter\.c, line \d+: .*has no member named 'ElectricalSpeed'",
        ),
        ("model/controller.h", r".* Torque;\n", "has no member named 'Torque'"),
        ("model/controller.h", r".* PeriodCounts;\n", "has no member named 'PeriodCounts'"),
    ],
)
def test_what_the_models_structures_do_not_have_is_reported_by_its_name(
    written,
    file: str,
    line: str,
    sentence: str,
) -> None:
    folder = written("embedded-coder")
    header = folder / file
    text, count = re.subn(line, "", header.read_text(encoding="utf-8"))
    assert count == 1
    header.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=sentence) as caught:
        resolve_candidate(str(folder / "candidate.toml"))
    assert str(caught.value).isprintable()


CONVERSIONS = """
#include "adapter.c"
#include <stdio.h>
int main(void) {
    double values[] = {0.0, 0.26, -0.26, 1e9, -1e9, NAN, INFINITY};
    for (int k = 0; k < 7; ++k)
        printf("%d %u %g\\n", CONVERTED(int16_T, 0.5, values[k]), CONVERTED(uint16_T, 0.5, values[k]),
               (double)CONVERTED(real32_T, 0.5, values[k]));
    printf("%.6f %.6f\\n", within_a_turn(-1.0), within_a_turn(7.0));
    return 0;
}
"""


def test_conversions_round_to_the_nearest_and_saturate(written) -> None:
    from drivegate.candidates.native.compiler import include_folder

    folder = written("embedded-coder")
    # Generated headers define no ends of ranges for some types.
    types = folder / "model" / "rtwtypes.h"
    lines = types.read_text(encoding="utf-8").splitlines()
    types.write_text("\n".join(line for line in lines if not line.startswith("#define M")), encoding="utf-8")
    (folder / "try.c").write_text(CONVERSIONS, encoding="utf-8")
    command = [
        "cc",
        "-std=c11",
        "-Imodel",
        f"-I{include_folder()}",
        "try.c",
        "model/controller.c",
        "-o",
        "try",
        "-lm",
    ]
    subprocess.run(command, cwd=folder, check=True)
    printed = subprocess.run(
        [str(folder / "try")], check=True, capture_output=True, text=True
    ).stdout.splitlines()
    assert printed[:-1] == [
        "0 0 0",
        "1 1 0.52",
        "-1 0 -0.52",
        "32767 65535 2e+09",
        "-32768 0 -2e+09",
        "-32768 0 nan",
        "32767 65535 inf",
    ]
    assert printed[-1] == "5.283185 0.716815"


@pytest.mark.nightly
def test_its_own_test_runs_and_passes(written) -> None:
    ended = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "ignore"],
        cwd=written("embedded-coder"),
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout[-3000:]
    assert "failed" not in ended.stdout
    assert "passed" in ended.stdout
