"""The ledger of the shaft closes for every load, and no plant that creates energy passes it."""

from __future__ import annotations

from math import hypot, inf, nan

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivegate_models.compilation.kernels import kernel
from drivegate_models.loop.shaft import Motion, forward_motion, motion_of
from drivegate_models.machine import shaft_ledger
from drivegate_models.machine.load import (
    CONSTANT_POWER,
    CONSTANT_TORQUE,
    FAN,
    HOIST,
    VEHICLE,
    Load,
    drag_torque,
    opposing_torque,
    weight_torque,
)
from drivegate_models.machine.shaft_ledger import account_shaft, shaft_error

pytestmark = pytest.mark.kernel

PERIOD = 1e-3
INERTIA = 0.01
LOADS = {
    "brake": Load(CONSTANT_TORQUE, 0.4),
    "power": Load(CONSTANT_POWER, 3.0),
    "fan": Load(FAN, 0.3, 20.0),
    "vehicle": Load(VEHICLE, 5.0, rolling=0.02, drag=1e-4),
    "hoist": Load(HOIST, 0.5),
}


@kernel
def _move(driving, opposing, damping, inertia, speed, length):
    return motion_of(driving, opposing, damping, inertia, speed, length)


@kernel
def _move_forward(driving, resisting, inertia, speed, length):
    return forward_motion(driving, resisting, inertia, speed, length)


@kernel
def _account(account, load, factor, inertia, motion, length, torques, friction, damping):
    machine, opposing, drag = torques
    account_shaft(account, load, factor, inertia, motion, length, machine, opposing, drag, friction, damping)


@kernel
def _opposing(load, factor, speed):
    return opposing_torque(load, factor, speed)


@kernel
def _weight(load, factor):
    return weight_torque(load, factor)


class Shaft:
    """A shaft with its ledger, whose plant may be perturbed."""

    def __init__(self, load: Load, speed: float, *, friction: float = 0.0, damping: float = 0.0) -> None:
        self.load, self.speed = load, speed
        self.friction, self.damping = friction, damping
        self.account = np.zeros(shaft_ledger.ENTRIES)
        self.way = 0.0

    def turn(self, machine: float, factor: float, inertia: float = INERTIA, **perturbed: float) -> None:
        """Turn it for a period; `perturbed`: torques (N m) that the plant has instead of the right ones."""
        opposing = _opposing(self.load, factor, abs(self.speed))
        weight = perturbed.get("weight", _weight(self.load, factor))
        moved = perturbed.get("opposing", opposing + self.friction)
        motion = Motion(*_move(machine - weight, moved, self.damping, inertia, self.speed, PERIOD))
        drag = float(drag_torque(self.load, abs(self.speed)))
        _account(
            self.account,
            self.load,
            factor,
            inertia,
            (self.speed, motion.gained, motion.share),
            PERIOD,
            (machine, opposing, drag),
            self.friction,
            self.damping,
        )
        # The mean speed, integrated: of each part where the shaft comes to rest within the period.
        end = self.speed + motion.gained
        if motion.share < 1.0:
            self.way += 0.5 * PERIOD * (self.speed * motion.share + end * (1.0 - motion.share))
        else:
            self.way += 0.5 * PERIOD * (self.speed + end)
        self.speed = end

    @property
    def error(self) -> float:
        return shaft_error(self.account)


TORQUES = st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=60)


@pytest.mark.parametrize("kind", LOADS)
@given(
    torques=TORQUES,
    speed=st.floats(-30.0, 30.0),
    factor=st.floats(0.0, 1.0),
    friction=st.sampled_from([0.0, 0.1]),
    damping=st.sampled_from([0.0, 1e-3, 5.0]),
)
@settings(max_examples=60, deadline=None, derandomize=True, database=None)
def test_it_closes_for_every_load_also_through_standstill(
    kind: str, torques: list[float], speed: float, factor: float, friction: float, damping: float
) -> None:
    shaft = Shaft(LOADS[kind], speed, friction=friction, damping=damping)
    for torque in torques:
        shaft.turn(torque, factor)
    assert shaft.error < 1e-12
    assert shaft.account[shaft_ledger.KINETIC] == pytest.approx(0.5 * INERTIA * shaft.speed**2, rel=1e-12)
    for name in shaft_ledger.OPPOSING:
        assert shaft.account[getattr(shaft_ledger, name)] >= 0.0, name
    size = LOADS[kind].size
    lifted = {"hoist": size * factor, "vehicle": size * factor / hypot(1.0, factor)}.get(
        kind, 0.0
    ) * shaft.way
    found = shaft.account[shaft_ledger.HOIST] + shaft.account[shaft_ledger.GRADE]
    assert found == pytest.approx(lifted, rel=1e-9, abs=1e-12)


def test_every_kind_of_work_has_its_own_entry() -> None:
    entries = {"brake": "BRAKE", "power": "POWER", "fan": "FAN", "hoist": "HOIST", "vehicle": "GRADE"}
    for kind, load in LOADS.items():
        shaft = Shaft(load, 10.0, friction=0.1)
        for _ in range(20):
            shaft.turn(0.5, 0.5)
        works = {
            name
            for name in (*entries.values(), "ROLLING", "DRAG")
            if shaft.account[getattr(shaft_ledger, name)]
        }
        assert works == {entries[kind], *(("ROLLING", "DRAG") if kind == "vehicle" else ())}
        assert shaft.account[shaft_ledger.FRICTION] == pytest.approx(0.1 * shaft.way, rel=1e-12)


PERTURBED: dict[str, tuple[str, float, dict[str, float]]] = {
    "a hoist that opposes": ("hoist", -10.0, {"weight": -0.5}),
    "a vehicle that climbs backward": ("vehicle", -10.0, {"weight": -0.4}),
    "a brake that drives": ("brake", 10.0, {"opposing": -0.4}),
    "a fan without work": ("fan", 10.0, {"opposing": 0.0}),
}


@pytest.mark.parametrize("kind", PERTURBED)
def test_a_plant_that_creates_energy_does_not_pass(kind: str) -> None:
    load, speed, perturbed = PERTURBED[kind]
    right, wrong = Shaft(LOADS[load], speed), Shaft(LOADS[load], speed)
    for _ in range(10):
        right.turn(0.0, 1.0)
        wrong.turn(0.0, 1.0, **perturbed)
    assert right.error < 1e-12
    assert wrong.error > 1e-6


def test_friction_that_drives_does_not_pass_although_its_energy_is_counted() -> None:
    shaft = Shaft(LOADS["hoist"], 10.0, friction=-1e-6)
    shaft.turn(0.0, 1.0)
    assert shaft.error > 1e-9


@pytest.mark.parametrize("grown", [1.0, 1.0 + 1e-8])
def test_a_speed_that_grows_between_two_periods_does_not_pass(grown: float) -> None:
    shaft = Shaft(LOADS["brake"], 10.0)
    for _ in range(10):
        shaft.speed *= grown
        shaft.turn(0.4, 1.0)
    assert (shaft.error > 1e-9) is (grown > 1.0)


def test_what_is_not_a_number_never_passes() -> None:
    shaft = Shaft(LOADS["brake"], 10.0)
    shaft.turn(nan, 1.0)
    assert shaft.error == inf


def test_inertia_comes_and_goes_with_its_kinetic_energy_at_the_speed_of_the_shaft() -> None:
    shaft = Shaft(LOADS["brake"], 10.0)
    for inertia in (INERTIA, 0.3 * INERTIA, INERTIA):
        shaft.turn(0.4, 1.0, inertia)
    assert shaft.speed == pytest.approx(10.0, rel=1e-12)
    assert shaft.account[shaft_ledger.BROUGHT] == pytest.approx(0.0, abs=1e-12)
    shaft.turn(0.4, 1.0, 0.3 * INERTIA)
    assert shaft.account[shaft_ledger.BROUGHT] == pytest.approx(-0.7 * 0.5 * INERTIA * 100.0, rel=1e-12)
    assert shaft.error < 1e-12


def test_a_shaft_that_never_turns_backward_has_the_same_ledger() -> None:
    load, speed, account = LOADS["vehicle"], 3.0, np.zeros(shaft_ledger.ENTRIES)
    for number in range(40):
        machine = 0.2 if number % 20 > 12 else 0.0
        opposing = _opposing(load, 0.1, speed)
        resisting = opposing + _weight(load, 0.1)
        motion = Motion(*_move_forward(machine * PERIOD, resisting, 1e-3, speed, PERIOD))
        moved = (speed, motion.gained, motion.share)
        drag = float(drag_torque(load, speed))
        _account(account, load, 0.1, 1e-3, moved, PERIOD, (machine, opposing, drag), 0.0, 0.0)
        speed += motion.gained
    assert speed == 0.0
    assert shaft_error(account) < 1e-12
