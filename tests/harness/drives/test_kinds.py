"""Each kind of drive: its bundle costs nothing until it is called, and holds all that is required of a drive."""

import math
import subprocess
import sys

import pytest

from drivegate.candidates.declaration import Declaration
from drivegate.checks.catalogue import CHECKS_OF
from drivegate.drives.drive_kind import DriveKind
from drivegate.drives.kinds import DEFAULT_DRIVE, DEFAULT_KIND, DRIVE_KINDS, kind_of
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError

HEAVY = ("hypothesis", "numba", "numpy", "pandas", "pydantic", "scipy")


@pytest.fixture(params=DRIVE_KINDS.values(), ids=lambda kind: kind.name)
def kind(request: pytest.FixtureRequest) -> DriveKind:
    found: DriveKind = request.param
    return found


def test_the_bundles_load_nothing_heavy() -> None:
    code = f"import sys, drivegate.drives.kinds; print([name for name in {HEAVY} if name in sys.modules])"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"


def test_a_kind_is_found_by_its_drive(kind: DriveKind) -> None:
    assert kind_of(load_drive(kind.default_drive)) is kind
    assert DEFAULT_KIND in DRIVE_KINDS.values()
    assert DEFAULT_KIND.default_drive == DEFAULT_DRIVE


def test_its_scenarios_are_fair_and_on_its_drive(kind: DriveKind) -> None:
    drive = load_drive(kind.default_drive)
    fixed = kind.fixed_scenarios(drive, Declaration())
    assert fixed
    assert all(scenario.drive == drive and kind.is_fair(scenario) for scenario in fixed)
    assert not kind.drawn_scenarios(drive, Declaration(), 0).is_empty
    assert kind.checks() == CHECKS_OF[drive.contract]


def test_its_oracle_and_its_steady_states_are_of_the_same_drive(kind: DriveKind) -> None:
    import numpy as np

    drive = load_drive(kind.default_drive)
    if drive.contract != "current":
        # There is no advance angle that its oracle could find.
        with pytest.raises(InputError, match="drivegate drive"):
            kind.oracle()
        return
    plant, oracle, states = drive.plant(), kind.oracle(), kind.steady_states()
    speed, torque = 2.0 * drive.rating.base_speed_rpm * math.pi / 30.0, 5.0
    best = oracle.least_current_sum(plant, speed, torque)
    values = np.empty((1, len(states.columns)))
    states.solve(plant, np.array([speed]), np.array([best.advance]), np.array([best.reference]), values)
    found = dict(zip(states.columns, values[0], strict=True))
    assert found["torque_mean_nm"] == pytest.approx(torque, rel=1e-3)
    assert oracle.feasible_edge(plant, speed, torque) <= best.advance + 1e-3
