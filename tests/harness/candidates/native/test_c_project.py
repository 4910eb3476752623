"""Candidates in C that the commands of their own project build, counted and with sanitizers."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from tests.harness.candidates.native.test_sanitizers import run_once, scenario_with

from drivegate.candidates.candidate import Candidate
from drivegate.candidates.fault import Fault, FaultKind
from drivegate.candidates.kinds import KINDS
from drivegate.candidates.native.compiler import include_folder
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate_models.errors import InputError

HEADER = """static inline double limited(double value, double top) {
    if (value > top) return top;
    return value;
}
"""
SOURCE = """#include "drivegate_duty.h"
#include "limits.h"
int64_t drivegate_abi_version(void) { return DRIVEGATE_ABI_VERSION; }
int64_t drivegate_state_size(void) { return 8; }
int drivegate_duty_reset(void *state, const drivegate_duty_nameplate *plate) { return !state || !plate; }
void drivegate_duty_step(void *state, const drivegate_duty_sense *sense, drivegate_duty_command *command) {
    volatile int value = (int)(1e6 * sense->reference);
    (void)state;
    if (sense->speed > 1e6) value = 0;
    for (int leg = 0; leg < 3; ++leg) command->duty_ratios[leg] = limited(0.5, 1.0);
    command->torque = value * value > 0; /* overflow of a product */
}
"""


def project(folder: Path, compiler: str = "cc") -> Candidate:
    """Write a project of two commands, of which one compiles by a whole path, as cmake does."""
    (folder / "src").mkdir()
    (folder / "src" / "limits.h").write_text(HEADER, encoding="utf-8")
    (folder / "src" / "mine.c").write_text(SOURCE, encoding="utf-8")
    commands = (
        f"sh -c '{compiler} -O2 -fPIC -Wall -Werror -I{include_folder()} -c $PWD/src/mine.c -o mine.o'",
        f"{compiler} -shared -o mine.so mine.o",
    )
    listed = ", ".join(f'"{command}"' for command in commands)
    (folder / "candidate.toml").write_text(
        'schema = 1\nname = "mine"\nkind = "so"\nentry = "mine.so"\ncontract = "duty"\n'
        f'sources = ["src/mine.c", "src/limits.h"]\nbuild = [{listed}]\n',
        encoding="utf-8",
    )
    return resolve_candidate(str(folder / "candidate.toml"))


def test_what_its_own_commands_build_is_counted_and_checked(tmp_path: Path) -> None:
    mine, output = project(tmp_path), tmp_path / "output"
    for folder in ("counted", "checked", "output"):
        (tmp_path / folder).mkdir()
    counted = KINDS["so"].counted_candidate(mine, tmp_path / "counted")
    with Judge(counted) as judge:
        assert not isinstance(judge.once(Job(run_once, scenario_with(0))), Fault)
    files = KINDS["so"].measured_files(counted, output)
    assert [file.name for file in files] == ["src/limits.h", "src/mine.c"]
    assert 2 in {line.number for line in files[0].lines if line.count}
    assert 9 in {line.number for line in files[1].lines if not all(line.branches)}
    listed = (output / "coverage.info").read_text(encoding="utf-8")
    assert f"SF:{tmp_path / 'src' / 'mine.c'}\n" in listed
    assert {line.count(",") for line in listed.splitlines() if line.startswith("DA:")} == {1}
    checked = KINDS["so"].sanitized_candidate(mine, ("undefined",), tmp_path / "checked")
    with Judge(checked) as judge:
        fault = judge.once(Job(run_once, scenario_with(1)))
    assert isinstance(fault, Fault)
    assert (fault.kind, fault.error) == (FaultKind.SANITIZER, "src/mine.c, line 11"), fault


def test_a_build_by_another_compiler_is_refused(tmp_path: Path) -> None:
    mine = project(tmp_path, shutil.which("cc") or "")
    with pytest.raises(InputError, match=r"the 'build' of 'mine' does not link the library by cc, gcc"):
        KINDS["so"].counted_candidate(mine, tmp_path)
