"""Compiled code of drivegate in a candidate's process, which cannot store any: it is compiled before that starts."""

import os
import subprocess
import sys
from datetime import date
from pathlib import Path

import pytest
from tests.harness import worker_jobs

from drivegate.candidates.kinds import KINDS, Kind
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.kept_process import worker_environment
from drivegate.containment.messages import Job
from drivegate.studies.new import write_candidate
from drivegate_models.compilation.kernels import required_cache_folder

EXAMPLES = Path(__file__).parents[3] / "examples"
CANDIDATE = str(EXAMPLES / "python" / "candidate.toml")
# Load a candidate and reset it, in a process that refuses to compile.
RUN = """
import sys
from drivegate.candidates.kinds import KINDS, load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.compilation import kernels
from numba.core import compiler

def refused(typing_context, target_context, function, *rest, **options):
    raise AssertionError(f"{function.__qualname__} is compiled")

compiler.compile_extra = refused
candidate = resolve_candidate(sys.argv[1])
controller = load_controller(candidate)
controller.reset(load_drive(sys.argv[2]).nameplate(5e-4 if candidate.contract == "current" else 1e-4))
print("has a step at", controller.step_address)
"""


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("text", "drive"),
    [
        pytest.param("cortex-m", "paper-5-phase", marks=pytest.mark.needs("arm-none-eabi-gcc")),
        (f"inner:pi:{CANDIDATE}", "pm-ac-surface"),
    ],
    ids=["elf", "inner"],
)
def test_it_is_compiled_before_a_process_that_only_reads(tmp_path: Path, text: str, drive: str) -> None:
    if text == "cortex-m":
        write_candidate(text, "mine", tmp_path / "mine", date(2026, 1, 1), drive)
        text = str(tmp_path / "mine" / "candidate.toml")
    candidate = resolve_candidate(text)
    KINDS[candidate.kind].compile_own_code(candidate)
    ended = subprocess.run(
        [sys.executable, "-c", RUN, text, drive],
        env=worker_environment(os.environ, tmp_path, required_cache_folder()),
        capture_output=True,
        text=True,
        check=False,
    )
    assert "has a step at" in ended.stdout, ended.stderr


def test_a_judge_has_it_compiled_before_it_starts_the_process(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, str]] = []
    monkeypatch.setattr(
        Kind, "compile_own_code", lambda kind, candidate: asked.append((kind.name, candidate.name))
    )
    candidate = resolve_candidate(CANDIDATE)
    with Judge(candidate) as judge:
        assert judge.once(Job(worker_jobs.drive, 2)) == judge.once(Job(worker_jobs.drive, 2))
    assert asked == [("python", candidate.name)], "once for all processes of a judge"
