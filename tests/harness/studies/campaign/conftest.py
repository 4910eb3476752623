"""Campaigns that are small and quick, and the command line that makes them, here or in a process of its own."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.harness.ended import Ended, ended

from drivegate_cases.scenario.scenario import load_scenario

CONTROLLERS = """
import os
import signal

from drivegate import Command


class Steady:
    def reset(self, nameplate):
        self.heavy = nameplate.inertia > 0.055

    def step(self, sense):
        current = 12.0 if sense.speed < sense.speed_reference else 0.0
        return Command(current_reference=current, advance_angle=0.9)


class Raising(Steady):
    def step(self, sense):
        if self.heavy and sense.time > 0.1:
            raise ValueError("too heavy")
        return super().step(sense)


class Dying(Steady):
    def step(self, sense):
        if self.heavy and sense.time > 0.1:
            os.kill(os.getpid(), signal.SIGSEGV)
        return super().step(sense)


class Counting(Steady):
    runs = 0

    def reset(self, nameplate):
        Counting.runs += 1

    def step(self, sense):
        return Command(current_reference=2.0 + Counting.runs, advance_angle=0.9)
"""


@pytest.fixture(scope="session")
def short_case() -> str:
    """A run of half a second, which ends before any check of the search begins."""
    return load_scenario("fig5-search").replaced(name="short", duration_s=0.5).to_json()


@pytest.fixture
def folder(tmp_path: Path, short_case: str) -> Path:
    """A folder with a case and controllers."""
    (tmp_path / "short.json").write_text(short_case, encoding="utf-8")
    (tmp_path / "controllers.py").write_text(CONTROLLERS, encoding="utf-8")
    return tmp_path


@pytest.fixture
def write(folder: Path) -> Callable[..., Path]:
    """Write a campaign's file: twelve drives of a built-in candidate, unless given otherwise."""

    def written(name: str = "campaign.json", **changes: object) -> Path:
        content = {
            "schema": 1,
            "name": "small",
            "seed": 7,
            "candidates": ["reference"],
            "cases": ["short.json"],
            "draws": 12,
            "runs_per_file": 2,
            "spread": {
                "resistance": {"kind": "normal", "mean": 1.0, "sigma": 0.05, "lowest": 0.8, "highest": 1.2},
                "friction_added_n_m": {"kind": "uniform", "lowest": 0.0, "highest": 0.3},
            },
        }
        content = {key: value for key, value in (content | changes).items() if value is not None}
        file = folder / name
        file.write_text(json.dumps(content), encoding="utf-8")
        return file

    return written


@pytest.fixture
def start(folder: Path) -> Callable[..., "subprocess.Popen[str]"]:
    """Start a command in a process of its own, in the folder."""

    def started(*words: object, **options: object) -> "subprocess.Popen[str]":
        return subprocess.Popen(
            [
                sys.executable,
                "-c",
                "from drivegate.commands.command_line import main; main()",
                *map(str, words),
            ],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            **options,
        )

    return started


@pytest.fixture
def run(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Callable[..., Ended]:
    """Run a command in this process, in the folder."""
    monkeypatch.chdir(folder)

    def ran(*words: object) -> Ended:
        return ended(capsys, *words)

    return ran


@pytest.fixture
def finish(run: Callable[..., Ended]) -> Callable[..., dict]:
    """Run a campaign to its end, in this process unless more workers are requested, and give its JSON."""

    def finished(file: Path, output: str, *words: object, workers: int = 1) -> dict:
        ended = run("campaign", file, "--output", output, "--workers", workers, *words, "--json")
        assert ended.code == 0, f"the campaign must be complete: {ended.err}"
        return json.loads(ended.out)

    return finished


@pytest.fixture
def finish_alone(start: Callable[..., "subprocess.Popen[str]"]) -> Callable[..., dict]:
    """Run a campaign to its end in a process that nothing else has used, and give its JSON."""

    def finished(file: Path, output: str, workers: int) -> dict:
        process = start("campaign", file, "--output", output, "--workers", workers, "--json")
        out, err = process.communicate(timeout=300)
        assert process.returncode == 0, f"the campaign must be complete: {err}"
        return json.loads(out)

    return finished


@pytest.fixture
def refused(run: Callable[..., Ended]) -> Callable[..., str]:
    """Run a campaign that must be refused in one sentence."""

    def sentence_of(*words: object) -> str:
        ended = run("campaign", *words)
        assert ended.code == 2, f"bad input must end with exit code 2: {ended.err}"
        assert ended.out == "", "a refusal belongs on standard error"
        assert "Traceback" not in ended.err
        (sentence,) = [line for line in ended.err.splitlines() if line.startswith("error: ")]
        return sentence

    return sentence_of


def contents(output: Path) -> dict[str, bytes]:
    """Give every file of a campaign's folder."""
    return {
        file.relative_to(output).as_posix(): file.read_bytes()
        for file in sorted(output.rglob("*"))
        if file.is_file()
    }


@pytest.fixture
def bytes_of() -> Callable[[Path], dict[str, bytes]]:
    """Read every file of a folder."""
    return contents
