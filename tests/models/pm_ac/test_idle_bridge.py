"""What a controller senses before a run while the bridge is off, and that its answers do not act there."""

from __future__ import annotations

from collections.abc import Callable
from math import nan, pi
from typing import Any

import numpy as np
import pytest
from tests.models.duty_runs import COLUMN, PERIOD
from tests.models.pm_ac.recorded_senses import Recorded, motoring, recorded
from tests.models.pm_ac.test_sensing import converters, encoder, hall

from drivegate_models.pm_ac.plant.drive import PmAcDrive
from drivegate_models.pm_ac.sensing import DC_LINK, IN_LINE, LOW_SIDE, DutySensors, real_duty_sensors

Factory = Callable[..., PmAcDrive]
RESTING, WAITING, STEPS = 7, 32, 20
BEFORE = RESTING + WAITING
ROOT_THREE = 3.0**0.5


def begun(drive: PmAcDrive, speed: float, **options: Any) -> Recorded:
    """Run a controller that commands no finite duty ratio while the bridge is off."""
    answer = motoring(drive)

    def enabled(sense: Any, command: Any) -> None:
        if sense.enable:
            answer(sense, command)
        else:
            command["first_duty"] = nan
            command["first_leg"] = 9

    before = {"resting": RESTING, "waiting": WAITING}
    return recorded(drive, speed, STEPS, enabled, **(before | options))


def turned(drive: PmAcDrive, speed: float, steps: int) -> float:
    """Return the electrical angle that the shaft turns by (rad)."""
    return drive.pole_pairs * speed * steps * PERIOD


def test_the_bridge_is_off_before_the_run_and_the_run_is_the_same_after_that(interior: Factory) -> None:
    drive = interior()
    shown = begun(drive, 150.0)
    senses = shown.senses
    assert senses["enable"].tolist() == [0] * BEFORE + [1] * STEPS
    assert senses["time"] == pytest.approx(np.arange(BEFORE + STEPS) * PERIOD, abs=1e-15)
    assert senses["speed"].tolist() == [0.0] * RESTING + [150.0] * (WAITING + STEPS)
    assert not np.ptp(senses["angle"][: RESTING + 1])
    assert not shown.currents[: BEFORE + 1].any()
    assert (senses["phase_voltages"][:RESTING] == -drive.diode_drop).all()
    along = drive.pole_pairs * 150.0 * drive.magnet_flux
    phases = senses["phase_voltages"][RESTING:BEFORE]
    vector = (2.0 * phases[:, 0] - phases[:, 1] - phases[:, 2]) / 3.0
    vector = vector + 1j * (phases[:, 1] - phases[:, 2]) / ROOT_THREE
    rotor = vector * np.exp(-1j * drive.pole_pairs * senses["angle"][RESTING:BEFORE])
    assert rotor == pytest.approx(1j * along, abs=1e-9), "the EMF shows with the bridge off"
    assert shown.run.steps == BEFORE + STEPS
    usual = recorded(
        drive, 150.0, STEPS, motoring(drive), initial_angle=turned(drive, 150.0, WAITING) % (2.0 * pi)
    )
    assert shown.run.trace == pytest.approx(usual.run.trace, rel=1e-9, abs=1e-9, nan_ok=True)
    assert shown.run.totals == pytest.approx(usual.run.totals, rel=1e-9, abs=1e-12)
    assert usual.senses["enable"].all()


def test_a_machine_that_rectifies_does_so_before_the_run(interior: Factory) -> None:
    drive = interior()
    speed = 1.5 * drive.link_voltage / (ROOT_THREE * drive.pole_pairs * drive.magnet_flux)
    # A whole number of waiting turns, so that the run without them begins at the same angle.
    speed = 2.0 * pi * round(turned(drive, speed, WAITING) / (2.0 * pi)) / turned(drive, 1.0, WAITING)
    shown, usual = begun(drive, speed), recorded(drive, speed, STEPS, motoring(drive))
    assert not shown.currents[:RESTING].any()
    assert np.abs(shown.currents[RESTING:BEFORE]).max() > 0.1
    assert (shown.senses["supply_current"][RESTING + 1 : BEFORE] < 0.0).all()
    peaks = [run.trace[:, COLUMN["peak_current"]] for run in (shown.run, usual.run)]
    assert peaks[0] == pytest.approx(peaks[1], rel=1e-5)


@pytest.mark.parametrize("shunt", [IN_LINE, LOW_SIDE, DC_LINK])
def test_the_offset_of_each_shunt_shows_before_the_run(interior: Factory, shunt: int) -> None:
    offsets = np.array([0.3, -0.2, 0.1])
    sensors = real_duty_sensors(converters()._replace(offsets=offsets), shunt=shunt, window=1e-6)
    shown = begun(interior(), 150.0, sensors=sensors)
    # Within half a step of the converter.
    assert shown.currents[:BEFORE] == pytest.approx(np.tile(offsets, (BEFORE, 1)), abs=10.0 / 4096)


@pytest.mark.parametrize("position", ["encoder", "hall"])
def test_a_sensor_of_edges_turns_with_the_shaft_from_standstill_on(interior: Factory, position: str) -> None:
    drive = interior()
    sensors: DutySensors = real_duty_sensors(
        converters(),
        encoder=encoder(1024, 150.0) if position == "encoder" else None,
        hall=hall(drive.pole_pairs, 150.0) if position == "hall" else None,
    )
    shown = begun(drive, 150.0, sensors=sensors)
    assert not shown.senses["speed"][:RESTING].any()
    assert shown.senses["speed"][RESTING:] == pytest.approx(150.0, rel=1e-3)
    true = np.maximum(np.arange(BEFORE + STEPS) - RESTING, 0) * 150.0 * PERIOD
    apart = np.remainder(shown.senses["angle"] - true + pi, 2.0 * pi) - pi
    assert np.abs(apart).max() < (2e-3 if position == "encoder" else 0.05)


def test_false_edges_come_at_their_time_in_the_run(interior: Factory) -> None:
    glitches = np.array([[10.2 * PERIOD, 3.0]])
    counter = encoder(1024, 0.0)._replace(glitches=glitches)
    shown = begun(interior(), 0.0, sensors=real_duty_sensors(converters(), encoder=counter))
    counts = shown.senses["encoder_count"]
    assert np.flatnonzero(np.diff(counts)).tolist() == [BEFORE + 10]


@pytest.mark.parametrize("kind", [None, LOW_SIDE])
def test_the_bridge_is_off_again_from_a_restart_on(interior: Factory, kind: int | None) -> None:
    drive = interior()
    sensors = None if kind is None else real_duty_sensors(converters(), shunt=kind)
    shown = begun(drive, 150.0, restarts=(10,), waiting=4, resting=0, sensors=sensors)
    senses, commands = shown.senses, shown.run.commands[4:]
    assert senses["enable"].tolist() == [0] * 4 + [1] * 10 + [0] * 4 + [1] * (STEPS - 14)
    off = np.logical_and.reduce([commands[leg] == 0 for leg in ("first_leg", "second_leg", "third_leg")])
    assert np.flatnonzero(off).tolist() == [10, 11, 12, 13], "what it answers meanwhile is not kept"
    peaks = shown.column("peak_current")
    assert peaks[9] > 0.1
    # It is off at once, not only after the delay, and its answer acts after the delay again.
    assert (np.diff(peaks[9:12]) < 0.0).all()
    assert not peaks[11:15].any()


def test_a_restart_without_waiting_leaves_the_bridge_on(interior: Factory) -> None:
    drive = interior()
    usual = recorded(drive, 150.0, STEPS, motoring(drive))
    restarted = recorded(drive, 150.0, STEPS, motoring(drive), restarts=(10,))
    assert np.array_equal(restarted.run.trace, usual.run.trace, equal_nan=True)
    assert restarted.senses["enable"].all()
