"""Candidates drawn from hostile actions, places and commands: each gets a verdict in time, and leaves nothing."""

import json
import math
import os
import resource
import runpy
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from textwrap import indent

import numpy as np
import psutil
import pytest
from hypothesis import HealthCheck, Phase, given, note, settings
from hypothesis import strategies as st
from tests.harness.beside_templates import connections, copies

from drivegate.candidates.fault import LONGEST_MESSAGE, LONGEST_TRACEBACK, Fault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.checks.check import JudgedRun, judged
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.containment.watches import WorkerLimits
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.contracts.current.scenarios.fixed import fixed_scenarios
from drivegate.contracts.current.timed_steps import given_steps
from drivegate.drives.running import recorded
from drivegate.gate.recording import RecordPlan, run_recorded
from drivegate.gate.shard import FixedRuns, run_fixed
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.contract.current.records import COMMAND
from drivegate_models.errors import InputError
from drivegate_models.loop.given_steps import senses_of
from drivegate_models.loop.step_recording import player_of, playing_step

HOSTILE = runpy.run_path(str(Path(__file__).with_name("hostile_actions.py")))
SCENARIOS = fixed_scenarios(load_drive("paper-5-phase"))
SHORT = SCENARIOS[0].model_copy(update={"duration_s": 0.5})
LIMITS = WorkerLimits(
    step_processor_seconds=0.5,
    start_processor_seconds=4.0,
    idle_seconds=6.0,
    order_seconds=20.0,
    memory_bytes=2**29,
)
LONGEST = 60.0
"""Most time of one candidate (s): the limits of a hang, and of what has to be ended by force, on a busy machine."""
LONGEST_CHECK = 240.0
"""Most time of one check that begins no more work after the first failure (s)."""
DRAWS = int(os.environ.get("DRIVEGATE_TEST_DRAWS", "16"))
"""Number of candidates; more of them for a hunt."""
DRAWN_ONCE = settings(
    database=None,
    derandomize=True,
    phases=[Phase.generate],
    suppress_health_check=list(HealthCheck),
)

FINITE = st.floats(allow_nan=False, allow_infinity=False)
FINITE_COMMANDS = st.tuples(FINITE, FINITE, st.one_of(FINITE, st.just(math.nan)))
PLAIN_COMMAND = (3.0, 0.5, math.nan)
COMMANDS = st.one_of(
    st.just(PLAIN_COMMAND), FINITE_COMMANDS, st.tuples(st.floats(), st.floats(), st.floats())
)


@dataclass(frozen=True)
class Drawn:
    """A candidate in words: what it does where, and its commands before and after some time."""

    action: str
    place: str
    early: tuple[float, float, float] = PLAIN_COMMAND
    late: tuple[float, float, float] = PLAIN_COMMAND

    def source(self, mark: str) -> str:
        return HOSTILE["CANDIDATE"].format(
            mark=mark,
            place=self.place,
            action=indent(HOSTILE["ACTIONS"][self.action], "    "),
            # Infinity and NaN have no literals.
            early=tuple(map(repr, self.early)),
            late=tuple(map(repr, self.late)),
        )


DRAWN = st.builds(
    Drawn,
    st.sampled_from(list(HOSTILE["ACTIONS"])),
    st.sampled_from(HOSTILE["PLACES"]),
    COMMANDS,
    COMMANDS,
)


@dataclass(frozen=True)
class Surroundings:
    """What no candidate may change: where its processes put things, and what this process is."""

    scratch: Path
    mark: str

    def own(self) -> tuple[object, ...]:
        names = [name for name in dir(resource) if name.startswith("RLIMIT_")]
        limits = [resource.getrlimit(getattr(resource, name)) for name in names]
        return Path.cwd(), dict(os.environ), limits, os.umask(os.umask(0)), connections()

    def left(self) -> list[str]:
        """Find what is left of candidates: processes, temporary files, shared memory."""
        found = [str(place) for place in self.scratch.iterdir()]
        found += [str(place) for place in Path("/dev/shm").glob(f"*{self.mark}*")]
        found += [f"copy {number}" for number in copies()]
        for process in Path("/proc").glob("[0-9]*"):
            try:
                environment = (process / "environ").read_bytes()
                if str(self.scratch).encode() in environment or self.mark.encode() in environment:
                    found.append(
                        psutil.Process(int(process.name)).status() + (process / "cmdline").read_text()
                    )
            except (OSError, psutil.Error):
                continue
        return found


@pytest.fixture
def surroundings(tmp_path, monkeypatch, no_process_left) -> Surroundings:
    """Give candidates a temporary folder of the test's own."""
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(scratch))
    return Surroundings(scratch, f"hostile-{os.getpid()}-{time.monotonic_ns()}")


def judged_in_every_way(loaded: JudgedCandidate, _: None) -> JudgedRun:
    """Do what a check does with a candidate: runs of one instance and of another, given Senses, margins."""
    controller = loaded.controller()
    record = recorded(loaded, SHORT, controller)
    nameplate = SHORT.nameplate()
    given_steps(controller, nameplate).answers(*senses_of(np.ones((20, 4)), nameplate.phases, 1.0))
    recorded(loaded, SHORT, loaded.controller())
    return judged(record, CHECKS)


def assert_a_verdict(ending: object) -> None:
    if isinstance(ending, Fault):
        assert ending.message.isprintable(), ending.message
        assert len(ending.message) <= LONGEST_MESSAGE
        assert len(ending.traceback) <= LONGEST_TRACEBACK
        assert ending.traceback.replace("\n", "").isprintable(), ending.traceback
    else:
        assert isinstance(ending, JudgedRun), ending
        for margin in ending.margins:
            assert math.isfinite(margin.value), margin
            assert margin.met or margin.check not in ("PWR-1", "CUR-1"), f"the plant is accused: {margin}"


@settings(DRAWN_ONCE, max_examples=DRAWS)
@given(drawn=DRAWN)
def test_a_hostile_candidate_gets_a_verdict_in_time_and_leaves_nothing(drawn, surroundings, tmp_path):
    file = tmp_path / "mine.py"
    file.write_text(drawn.source(surroundings.mark), encoding="utf-8")
    before = surroundings.own()
    began = time.monotonic()
    ending: object
    with Judge(resolve_candidate(f"{file}:Mine"), limits=LIMITS) as judge:
        try:
            ending = judge.once(Job(judged_in_every_way, None))
        except InputError as refused:
            ending = Fault("refused", str(refused), "loading")
    taken = time.monotonic() - began
    note(f"{taken:.1f} s: {ending}")
    assert_a_verdict(ending)
    assert taken < LONGEST, f"{drawn} took {taken:.0f} s"
    assert surroundings.left() == [], f"{drawn} leaves something"
    assert surroundings.own() == before, f"{drawn} has changed the process that judges it"


class GivenCommands:
    """A controller of this process that answers with what was drawn, one command for each part of the run."""

    fault = None

    def __init__(self, commands: list[tuple[float, float, float]], steps: int) -> None:
        rows = np.array([(0, *command) for command in commands], COMMAND)
        self._commands = np.repeat(rows, -(-steps // len(commands)))
        self._step = playing_step()
        self._state = player_of(self._commands)
        self.step_address: int = self._step.address
        self.state_address: int = self._state.ctypes.data

    def reset(self, _nameplate: object) -> None:
        self._state["given"] = 0


@settings(DRAWN_ONCE, max_examples=DRAWS)
@given(scenario=st.sampled_from(SCENARIOS[:12]), commands=st.lists(FINITE_COMMANDS, min_size=1, max_size=3))
@pytest.mark.filterwarnings("error")
def test_any_finite_commands_are_judged_and_can_be_reported(scenario, commands):
    loaded = JudgedCandidate(
        resolve_candidate("initial"), lambda: GivenCommands(commands, scenario.control_periods)
    )
    (run,) = run_fixed(loaded, FixedRuns((scenario,))).runs
    assert_a_verdict(run)
    checks = tuple(margin.check for margin in run.margins)
    shown = run_recorded(loaded, RecordPlan(scenario.to_mapping(), checks))
    json.dumps([shown.columns, shown.windows], allow_nan=False)


WITHOUT_PAGES = """
from functools import partial
from drivegate.commands.command_line import main
from drivegate.containment.watches import WorkerLimits
from drivegate.gate import engine
from drivegate.output import report_writers
engine.WorkerPool = partial(engine.WorkerPool, limits=WorkerLimits(step_processor_seconds=0.5))
report_writers.entry_points = lambda group: []
main()
"""
"""The command line without pages, which test_hostile_zoo.py writes of hostile candidates, and with little patience."""
NEXT_TO_NOTHING = (5e-324, 5e-324, 5e-324)
CHECKED = [
    pytest.param(Drawn("nothing", "step", NEXT_TO_NOTHING, NEXT_TO_NOTHING), "fail", id="nothing at step"),
    pytest.param(Drawn("loop", "deletion"), "hang", id="loop at deletion", marks=pytest.mark.nightly),
    pytest.param(
        Drawn("a forged breakdown", "construction"),
        "crash",
        id="a forged breakdown at construction",
        marks=pytest.mark.nightly,
    ),
    pytest.param(Drawn("no files", "import"), "fail", id="no files at import", marks=pytest.mark.nightly),
]


@pytest.mark.nightly
@pytest.mark.parametrize(("drawn", "verdict"), CHECKED)
def test_a_check_of_a_hostile_candidate_ends_as_documented(drawn, verdict, surroundings, tmp_path):
    (tmp_path / "mine.py").write_text(drawn.source(surroundings.mark), encoding="utf-8")
    before = surroundings.own()
    report = tmp_path / "report"
    command = [
        *(sys.executable, "-c", WITHOUT_PAGES),
        "check",
        "mine.py:Mine",
        "--output",
        str(report),
    ]
    # One check shows a failure like all of them.
    focus = ["--only", "CNV-1"] if verdict == "fail" else []
    ended = subprocess.run(
        # What comes after the first failure is the same again, and is left out.
        [*command, "--effort", "quick", "--workers", "1", "--stop-at-first", *focus],
        cwd=tmp_path,
        env={**os.environ, "TMPDIR": str(surroundings.scratch)},
        check=False,
        capture_output=True,
        text=True,
        timeout=LONGEST_CHECK,
    )
    assert ended.returncode == 1, ended.stderr
    assert "Traceback" not in ended.stdout + ended.stderr, ended.stderr
    assert "Warning" not in ended.stderr, ended.stderr

    def refused(name: str) -> None:
        pytest.fail(f"{name} is not JSON")

    result = json.loads((report / "result.json").read_text(encoding="utf-8"), parse_constant=refused)
    assert result["verdict"] == verdict, result["faults"]
    assert surroundings.left() == [], f"{drawn} leaves something"
    assert surroundings.own() == before
