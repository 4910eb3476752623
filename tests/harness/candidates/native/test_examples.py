"""The same controller in Python, numba, C and Rust gives the same commands, bit for bit, in every case."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import judged
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.record import CurrentRecord
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.drives.running import run_scenario
from drivegate_cases.drive.drive_document import load_drive

EXAMPLES = Path(__file__).parents[4] / "examples"
SCENARIOS = {scenario.name: scenario for scenario in fixed_scenarios(load_drive("paper-5-phase"))}
REQUIRED = (
    "ADV-1",
    "ADV-2",
    "CMD-1",
    "CNV-1",
    "CNV-2",
    "CNV-3",
    "CPW-1",
    "PWR-2",
    "RIP-1",
    "ROB-1",
    "ROB-2",
    "ROB-3",
)


@pytest.fixture(scope="module")
def controllers(tmp_path_factory):
    """The four examples, by language."""
    library = tmp_path_factory.mktemp("rust") / "controller.so"
    subprocess.run([EXAMPLES / "rust" / "build.sh", library], check=True)
    named = {
        "Python": f"{EXAMPLES / 'python' / 'controller.py'}:Controller",
        "numba": f"{EXAMPLES / 'numba' / 'controller.py'}:controller",
        "C": str(EXAMPLES / "c" / "controller.c"),
        "Rust": str(library),
    }
    return {language: load_controller(resolve_candidate(name)) for language, name in named.items()}


@pytest.mark.needs("rustc")
@pytest.mark.one_in(30)
@pytest.mark.parametrize("name", SCENARIOS)
def test_every_language_gives_the_same_trace(controllers, name):
    runs = {
        language: run_scenario(SCENARIOS[name], controller, trace_every=1)
        for language, controller in controllers.items()
    }
    expected = runs.pop("Python")
    for language, run in runs.items():
        bits = [trace.view(np.int64).reshape(len(trace), -1) for trace in (run.trace, expected.trace)]
        different = np.flatnonzero((bits[0] != bits[1]).any(axis=1))
        assert different.size == 0, f"{language} differs from Python from step {different[0]} on"
        assert run.digest == expected.digest, f"{language} gives other commands than Python"


@pytest.mark.needs("rustc")
@pytest.mark.one_in(30)
@pytest.mark.parametrize("name", SCENARIOS)
def test_the_example_meets_every_required_check_on_the_fixed_scenarios(controllers, name):
    scenario = SCENARIOS[name]
    declaration = resolve_candidate(str(EXAMPLES / "c" / "candidate.toml")).declaration
    run = run_scenario(scenario, controllers["C"])
    failed = [
        f"{margin.check} {margin.value:+.3g}: {margin.measured}"
        for margin in judged(CurrentRecord(scenario, run, declaration), CHECKS).margins
        if margin.check in REQUIRED and margin.value < 0.0 and not margin.advisory
    ]
    assert failed == []


def test_without_a_rust_compiler_the_script_says_what_to_install(tmp_path):
    (tmp_path / "dirname").symlink_to("/usr/bin/dirname")
    ended = subprocess.run(
        ["/bin/sh", EXAMPLES / "rust" / "build.sh"],
        check=False,
        env={"PATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert ended.returncode == 1
    assert ended.stderr == (
        "controller.rs needs the Rust compiler, but there is no rustc; install it from https://rustup.rs\n"
    )
