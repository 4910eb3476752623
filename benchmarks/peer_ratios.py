"""The closed loop of duty ratios beside motulator and motulator-export, on the same drive, in turns."""

from __future__ import annotations

import importlib
import sys
import time
from collections.abc import Callable
from math import pi
from pathlib import Path
from statistics import median
from typing import Any, Final

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_lab.bench.workbench import Correctness, NotMeasured, Value, Workbench, ratio
from duty_rates import DEAD_TIMES, foc_run

SIMULATED: Final = 8.0
"""Simulated time of each run of `foc` (s)."""
PERIOD: Final = 125e-6
"""Control period, which is motulator's (s)."""

_HERE = Path(__file__).resolve().parent
_THEIR_CONTROLLER = _HERE.parent / "examples" / "motulator" / "flux_vector.toml"


def export_ratio(bench: Workbench, bridge: str) -> Value:
    """Measure how many times the rate of motulator-export's bare loop that of `foc` is."""
    peer = _peer("motulator_export_drive", "motulator-export")
    dead_time = DEAD_TIMES[bridge]
    # It compiles its loop.
    peer.simulated(dead_time)
    return _in_turns(_foc(dead_time, peer, bench.simulated(SIMULATED)), peer, bench.rounds, dead_time)


def motulator_ratio(bench: Workbench) -> Value:
    """Measure how many times the rate of motulator that of `foc` is."""
    peer = _peer("motulator_drive", "motulator")
    return _in_turns(_foc(0.0, peer, bench.simulated(SIMULATED)), peer, slow_turns(bench.quick))


def same_controller_ratio(bench: Workbench) -> Value:
    """Measure how many times motulator's rate that of its own controller on drivegate's plant is."""
    peer = _peer("motulator_drive", "motulator")
    factor = ((0.0, 0.0), (peer.LOAD_STEP_S, 0.0), (peer.LOAD_STEP_S, 1.0))
    scenario = Scenario(
        name="motulator",
        drive=_drive(0.0),
        duration_s=peer.SIMULATED_S,
        initial_speed_rpm=0.0,
        speed_rpm=((0.0, peer.SPEED * 30.0 / pi),),
        load=ConstantTorqueLoad(kind="constant_torque", torque_nm=peer.LOAD_NM, factor=factor),
    )
    loaded = own_candidate(resolve_candidate(str(_THEIR_CONTROLLER)))
    controller = loaded.controller()

    def ours() -> float:
        began = time.process_time()
        recorded(loaded, scenario, controller)
        return (time.process_time() - began) / scenario.duration_s

    return _in_turns(ours, peer, slow_turns(bench.quick))


def slow_turns(quick: bool) -> int:
    """Return how often motulator is measured, which takes ten seconds each time."""
    return 1 if quick else 3


def _peer(program: str, package: str) -> Any:
    """Import the program of a peer, if what it measures is installed here."""
    folder = str(_HERE / "peers")
    if folder not in sys.path:
        sys.path.append(folder)
    try:
        importlib.import_module(package.replace("-", "_"))
    except ImportError as error:
        raise NotMeasured(f"{package} is not installed in this Python") from error
    return importlib.import_module(program)


def _drive(dead_time: float) -> PmAcDocument:
    """Return motulator's drive; its machine has no core loss."""
    changes = [f"dead_time_s={dead_time}", "core_loss_conductance_s=0"]
    document = load_drive("pm-ac-2kw").with_overrides(changes)
    assert isinstance(document, PmAcDocument), "the packaged drive is a PM AC one"
    return document


def _foc(dead_time: float, peer: Any, simulated: float) -> Callable[[], float]:
    """Return what runs `foc` at a peer's speed and load, and gives the processor time of a simulated second (s)."""
    drive = _drive(dead_time)
    nameplate = drive.duty_nameplate(PERIOD, torque_reference=False)

    def seconds() -> float:
        began = time.process_time()
        foc_run(drive.plant(), nameplate, peer.SPEED, peer.LOAD_NM, simulated)
        return (time.process_time() - began) / simulated

    return seconds


def _in_turns(ours: Callable[[], float], peer: Any, turns: int, dead_time: float = 0.0) -> Value:
    """Measure both in turns, the peer on a drive of a dead time (s); it is right where it comes to its speed."""
    # The first run compiles.
    ours()
    own, others, speed = [], [], 0.0
    for _ in range(turns):
        # motulator-export shows the time of the whole call, too.
        seconds, *_, speed = peer.simulated(dead_time)
        others.append(seconds / peer.SIMULATED_S)
        own.append(ours())
    rates = f"{1.0 / median(own):.3g} against {1.0 / median(others):.3g} × real time"
    measured = f"{rates}, which ends at {speed:.2f} of {peer.SPEED:g} rad/s"
    return ratio(others, own, Correctness(abs(speed - peer.SPEED) < 1.0, measured))
