"""FMUs that answer with duty ratios: known by their outputs, and given what the contract has."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from tests.harness.candidates.native.duty_sources import duty_source

from drivegate.candidates.declaration import Declaration
from drivegate.candidates.fault import CandidateFault, FaultKind
from drivegate.candidates.fmu.loading import FmuController
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.duty.contract import DUTY
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.kinds import drive_for
from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.contract.duty.signals import DutyNameplate, DutySense
from drivegate_models.errors import InputError
from drivegate_models.pm_ac.closed_loop import prepared_duty_loop

INTERIOR = load_drive("pm-ac-interior")
SHORT = torque_scenario(INTERIOR, 600.0, (0.0,)).replaced(duration_s=0.02)
NAMEPLATE: DutyNameplate = INTERIOR.duty_nameplate(1e-4, torque_reference=True)
SENSE = DutySense(
    0.0,
    1.5,
    (1.0, -3.0, 2.0),
    120.0,
    4.0,
    0.25,
    60.0,
    5,
    1234,
    2,
    (3.5, -0.5, 60.0),
    0,
    3.25,
    41.5,
    (3.0, -0.5, 61.0),
)
VERSIONS = (2, 3)

# The command shows what was sensed, one number a step, and the nameplate's numbers after them.
STATED = """
    double sensed[] = {sense->reference, sense->phase_currents[0], sense->phase_currents[1], sense->phase_currents[2],
        sense->supply_voltage, sense->supply_current, sense->angle, sense->speed, (double)sense->hall,
        (double)sense->encoder_count, (double)sense->trip, sense->phase_voltages[0], sense->phase_voltages[1],
        sense->phase_voltages[2], (double)sense->enable, sense->source_current, sense->winding_temperature,
        sense->mean_voltages[0], sense->mean_voltages[1], sense->mean_voltages[2],
        (double)known.kind, (double)known.reference_kind,
        (double)known.pole_pairs, (double)known.updates, (double)known.update_delay, known.supply_voltage,
        known.base_speed, known.highest_speed, known.rated_power, known.current_limit, known.control_period,
        known.dead_time, known.resistance, known.direct_inductance, known.quadrature_inductance, known.magnet_flux,
        known.inertia, known.core_loss_conductance, (double)known.control_every,
        known.switch_drop, known.diode_drop, known.position_error, known.link_capacitance,
        known.source_resistance, known.link_limit, known.charge_limit, known.discharge_limit,
        known.chopper_voltage, known.chopper_resistance, (double)known.position, known.least_speed,
        known.start_time, (double)known.is_reversing, known.heat_capacity, known.thermal_resistance,
        known.ambient_temperature, known.temperature_limit, known.temperature_coefficient, known.temperature_lag,
        known.voltage_filter};
    command->torque = sensed[self->steps - 1];
    command->legs[1] = self->steps < 3 ? DRIVEGATE_LEG_PWM : DRIVEGATE_LEG_OFF;
    command->fault = self->steps;
    if (self->steps == 5)"""


@pytest.fixture
def made(tmp_path: Path, build_fmu: Callable[..., Path]) -> Callable[..., Path]:
    """Build an FMU of a controller that does something particular in its fifth step, or in all."""

    def make(version: int = 2, **parts: str) -> Path:
        source = tmp_path / "mine.c"
        text = duty_source(**parts)
        if parts.get("top"):
            text = text.replace("    if (self->steps == 5)", STATED)
        source.write_text(text, encoding="utf-8")
        return build_fmu([source], tmp_path / "mine.fmu", fmi=version, contract="duty")

    return make


def changed(fmu: Path, old: str, new: str) -> str:
    """Change the description of an FMU."""
    with zipfile.ZipFile(fmu) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    assert old.encode() in contents["modelDescription.xml"]
    contents["modelDescription.xml"] = contents["modelDescription.xml"].replace(old.encode(), new.encode())
    with zipfile.ZipFile(fmu, "w") as archive:
        for name, content in contents.items():
            archive.writestr(name, content)
    return str(fmu)


def run(file: Path) -> int:
    """Run a controller in this process, and give the digest of its commands."""
    controller = load_controller(resolve_candidate(str(file)))
    return DUTY.record(prepared_duty_loop, Declaration(), SHORT, controller).run.digest


@pytest.mark.parametrize("version", VERSIONS)
def test_what_is_sensed_and_the_nameplate_arrive_and_the_whole_answer_comes_back(version, made) -> None:
    fmu = made(version, top="static drivegate_duty_nameplate known;", reset="known = *plate;")
    controller = load_controller(resolve_candidate(str(fmu)))
    assert isinstance(controller, FmuController)
    controller.reset(NAMEPLATE)
    wanted = [
        SENSE.reference,
        *SENSE.phase_currents,
        *SENSE[3:10],
        *SENSE.phase_voltages,
        SENSE.enable,
        SENSE.source_current,
        SENSE.winding_temperature,
        *SENSE.mean_voltages,
        *NAMEPLATE,
    ]
    answers = [controller._fmu.step(SENSE._replace(time=1e-4 * step)) for step in range(len(wanted))]
    assert [answer.torque for answer in answers] == wanted
    assert [answer.legs for answer in answers[:4]] == [(1, 1, 1), (1, 1, 1), (1, 0, 1), (1, 0, 1)]
    assert [answer.fault for answer in answers[:3]] == [1, 2, 3]
    assert all(0.0 <= ratio <= 1.0 for answer in answers for ratio in answer.duty_ratios)
    assert math.isnan(answers[0].input_power)
    assert math.isnan(answers[0].angle), "it estimates nothing that has no output"


def test_its_commands_are_those_of_the_same_source_in_c(made, tmp_path) -> None:
    # Each version is built from the same file.
    digests = [run(made(version)) for version in VERSIONS]
    assert set(digests) == {run(tmp_path / "mine.c")}


def test_what_it_does_wrong_is_a_verdict_with_its_step(made) -> None:
    with pytest.raises(CandidateFault) as raised:
        run(made(fifth_step="command->legs[1] = 7;"))
    fault = raised.value.fault
    assert (fault.kind, fault.step) == (FaultKind.INVALID_OUTPUT, 4), fault
    assert "legs are 1, 7, 1" in fault.message


def test_a_drive_of_the_other_contract_is_refused_in_one_sentence(made) -> None:
    candidate = resolve_candidate(str(made()))
    assert drive_for(candidate, INTERIOR) is INTERIOR
    currents = load_scenario("fig5-search")
    with pytest.raises(InputError, match="answers with duty ratios, but the drive takes a current reference"):
        load_controller(candidate).reset(currents.nameplate())


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        (
            'name="reference"',
            'name="refrence"',
            "there is no input 'reference' (the nearest input is 'refrence')",
        ),
        (
            'name="hall"',
            'name="halls"',
            "nothing is known of the input 'halls' (the nearest known one is 'hall')",
        ),
        (
            'name="duty_ratios[3]"',
            'name="third"',
            "'duty_ratios' has 2 values, but must have 3, one for each leg",
        ),
        ('name="legs[2]"', 'name="legs[4]"', "there is no output 'legs[2]'"),
    ],
)
def test_variables_that_do_not_fit_are_reported_with_those_of_this_contract(old, new, reason, made) -> None:
    with pytest.raises(InputError) as refused:
        load_controller(resolve_candidate(changed(made(), old, new)))
    sentence = str(refused.value)
    assert reason in sentence
    assert "a controller has the Real input reference and the Real outputs duty_ratios[1]" in sentence
    assert "\n" not in sentence
