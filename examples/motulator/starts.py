"""Starts of motulator's sensorless controllers from standstill: ``python examples/motulator/starts.py``.

Each row is a run without a load on pm-ac-2kw-sensorless: the electrical angle of the rotor at the start, the reference,
and after 0.6 s the speed and how far the rotor has turned back at most.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.load import ConstantTorqueLoad
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.units import RADIANS_PER_RPM

HERE = Path(__file__).parent
DURATION_S = 0.6
STARTS = (
    ("sensorless_flux_vector.toml", 260.0, (0.0, 90.0, 180.0, 270.0)),
    ("signal_injection.toml", 130.0, (0.0, 180.0)),
)
"""Candidate, speed reference (rpm) and electrical angles (degrees)."""


class Start(NamedTuple):
    """One start."""

    candidate: str
    angle_deg: float
    reference_rpm: float
    speed_rpm: float
    """Mean over the last tenth of the run."""
    back_deg: float
    """Greatest electrical angle that the rotor turns back."""


def start(candidate: str, reference_rpm: float, angle_deg: float) -> Start:
    """Run a start."""
    drive = load_drive("pm-ac-2kw-sensorless")
    run = Scenario(
        name="start",
        drive=drive,
        duration_s=DURATION_S,
        initial_speed_rpm=0.0,
        initial_angle_deg=angle_deg,
        speed_rpm=((0.0, reference_rpm),),
        load=ConstantTorqueLoad(kind="constant_torque", torque_nm=0.0),
    )
    loaded = own_candidate(resolve_candidate(str(HERE / candidate)))
    speed = recorded(loaded, run, loaded.controller()).run.column("speed")
    turned = np.degrees(np.cumsum(speed) * run.control_period_s * drive.machine.pole_pairs)
    last = speed[-len(speed) // 10 :].mean() / RADIANS_PER_RPM
    return Start(candidate, angle_deg, reference_rpm, float(last), float(max(0.0, -turned.min())))


def starts() -> Iterator[Start]:
    """Run all of them."""
    for candidate, reference, angles in STARTS:
        for angle in angles:
            yield start(candidate, reference, angle)


def main() -> None:
    """Print a row for each start."""
    for each in starts():
        sys.stdout.write(
            f"{each.candidate:28} from {each.angle_deg:3.0f} deg, reference {each.reference_rpm:3.0f} rpm: "
            f"{each.speed_rpm:7.1f} rpm after {DURATION_S} s, {each.back_deg:6.0f} deg back at most\n"
        )


if __name__ == "__main__":
    main()
