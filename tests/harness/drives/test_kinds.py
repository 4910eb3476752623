"""Each kind of drive costs nothing until its loop is prepared, and has all that is required of a drive."""

import math
import subprocess
import sys

import pytest

from drivegate.candidates.declaration import Declaration
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.kinds import (
    DEFAULT_DRIVE,
    DEFAULT_KIND,
    DRIVE_KINDS,
    DriveKind,
    kind_of,
    require_angles,
)
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.errors import InputError

HEAVY = ("hypothesis", "numba", "numpy", "pandas", "pydantic", "scipy")


@pytest.fixture(params=DRIVE_KINDS.values(), ids=lambda kind: kind.name)
def kind(request: pytest.FixtureRequest) -> DriveKind:
    found: DriveKind = request.param
    return found


def test_kinds_and_the_list_of_contracts_load_nothing_heavy() -> None:
    modules = "drivegate.drives.kinds, drivegate.contracts.catalogue, drivegate.contracts.duty.columns"
    code = f"import sys, {modules}; print([name for name in {HEAVY} if name in sys.modules])"
    ended = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"


def test_a_kind_is_found_by_its_drive(kind: DriveKind) -> None:
    assert kind_of(load_drive(kind.default_drive)) is kind
    assert DEFAULT_KIND in DRIVE_KINDS.values()
    assert DEFAULT_KIND.default_drive == DEFAULT_DRIVE


def test_its_scenarios_are_fair_and_on_its_drive(kind: DriveKind) -> None:
    drive = load_drive(kind.default_drive)
    contract = contract_of(drive)
    assert contract.name == kind.contract
    fixed = contract.fixed_scenarios(drive, Declaration())
    assert fixed
    assert all(scenario.drive == drive and contract.is_fair(scenario) for scenario in fixed)
    assert not contract.drawn_scenarios(drive, Declaration(), 0).is_empty


def test_its_oracle_and_its_steady_states_are_of_the_same_drive(kind: DriveKind) -> None:
    import numpy as np

    from drivegate_models.steady import oracle
    from drivegate_models.steady.grid import POINT_COLUMNS, solve_points
    from drivegate_models.steady.plant import make_phases
    from drivegate_models.steady.steady_state import KEPT_TIME

    drive = load_drive(kind.default_drive)
    if not kind.has_angles:
        # There is no advance angle that its oracle could find.
        with pytest.raises(InputError, match="drivegate drive"):
            require_angles(drive)
        return
    assert require_angles(drive) is drive
    plant = drive.plant()
    speed, torque = 2.0 * drive.rating.base_speed_rpm * math.pi / 30.0, 5.0
    best = oracle.least_current_sum(plant, speed, torque)
    values, phases = np.empty((1, len(POINT_COLUMNS))), (make_phases(plant, KEPT_TIME), make_phases(plant))
    point = (np.array([speed]), np.array([best.advance]), np.array([best.reference]))
    solve_points(plant, *phases, plant.half_supply_voltage, *point, values)
    found = dict(zip(POINT_COLUMNS, values[0], strict=True))
    assert found["torque_mean_nm"] == pytest.approx(torque, rel=1e-3)
    assert oracle.feasible_edge(plant, speed, torque) <= best.advance + 1e-3


RUN_OF_A_KIND = """
import sys
from numba.core.dispatcher import Dispatcher
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.catalogue import contract_of
from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.gate.plan import NOTHING_DECLARED
from drivegate.gate.shard import FixedRuns, run_fixed
from drivegate_cases.drive.drive_document import load_drive

drive = load_drive(DRIVE_KINDS[sys.argv[1]].default_drive)
contract = contract_of(drive)
scenario = contract.fixed_scenarios(drive, NOTHING_DECLARED)[1]
loaded = own_candidate(resolve_candidate(contract.usual_candidate))
outcome = run_fixed(loaded, FixedRuns((scenario,), only_fair=True))
assert outcome.runs, "nothing was judged"

plants = {}
for name, module in [*sys.modules.items()]:
    for kernel in vars(module).values() if name.startswith("drivegate_models.") else ():
        for signature in kernel.nopython_signatures if isinstance(kernel, Dispatcher) else ():
            for given in signature.args:
                plants[getattr(given, "instance_class", str).__module__] = kernel.__name__
for plant, kernel in plants.items():
    print("compiled", plant, kernel)
for name in sys.modules:
    print("imported", name)
"""


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("kind", "others"), [("star", ("half_bridge", "pm_ac")), ("half-bridge", ("star", "pm_ac"))]
)
def test_a_judged_run_compiles_and_imports_nothing_of_another_kind(
    kind: str, others: tuple[str, ...]
) -> None:
    ended = subprocess.run(
        [sys.executable, "-c", RUN_OF_A_KIND, kind], capture_output=True, text=True, check=True
    )
    stated: dict[str, set[str]] = {"compiled": set(), "imported": set()}
    for line in ended.stdout.splitlines():
        what, name, *_ = line.split()
        stated[what].add(name)
    package = f"drivegate_models.{kind.replace('-', '_')}"
    assert any(name.startswith(package) for name in stated["compiled"]), "the kernels tell no plant"
    for other in others:
        foreign = f"drivegate_models.{other}"
        assert not [name for name in stated["compiled"] if name.startswith(foreign)], (
            "compiled for another kind"
        )
        # An index of numba's cache names the constants and states of both plants, and so imports them; their loops
        # and periodic states, which callers would be compiled with, it does not.
        known = {f"{foreign}.{module}" for module in ("closed_loop", "periodic", "oracle", "fundamental")}
        assert not known & stated["imported"], "imported for another kind"
    assert not [name for name in stated["imported"] if name.startswith("drivegate_models.pm_ac")]
