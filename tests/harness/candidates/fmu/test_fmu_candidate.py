"""FMUs as candidates: real ones, built from C, answer like the C they are built from; all others are reported."""

import gc
import io
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import numpy as np
import pytest
from tests.harness import worker_jobs

from drivegate.candidates.fault import CandidateFault, FaultKind
from drivegate.candidates.fmu.instance import FmuError
from drivegate.candidates.fmu.loading import _unpacked, unpack
from drivegate.candidates.fmu.variables import CURRENT, DUTY
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job
from drivegate.containment.watches import WorkerLimits
from drivegate.drives.running import run_scenario
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.contract.current.signals import Nameplate, Sense
from drivegate_models.errors import InputError

ROOT = Path(__file__).parents[4]
EXAMPLES = ROOT / "examples"
BUILDER = ROOT / "harness/drivegate/templates/new/fmu/fmi/build_fmu.py"
QUICK = WorkerLimits(step_processor_seconds=0.3, start_processor_seconds=30.0, idle_seconds=30.0)
NAMEPLATE = Nameplate(
    *(5, 11, 48.0, 52.36, 1500.0, 26.0, 0.0005, 0.25, 0.08, 0.00288, 0.339, 0.05),
    *(1, 2.513, 4.0, 0.576, 0.00417, 157.08),
)
SENSE = Sense(0.0, 157.0, 156.5, (1.0, 2.0, -3.0, 0.5, 0.0), 6.5, 47.9)
VERSIONS = (2, 3)
DESCRIPTION = "modelDescription.xml"

# It counts its steps, reports what it sensed, and does something particular in the fifth.
SOURCE = """
#include <math.h>
#include <stdlib.h>
#include "drivegate.h"
typedef struct {{ drivegate_nameplate plate; double count; }} controller;
{declarations}
int64_t drivegate_abi_version(void) {{ return DRIVEGATE_ABI_VERSION; }}
int64_t drivegate_state_size(void) {{ return {size}; }}
int drivegate_reset(void *state, const drivegate_nameplate *plate) {{
    controller *self = {self};
    *self = (controller){{*plate, 0.0}};
    {reset}
    return 0;
}}
void drivegate_step(void *state, const drivegate_sense *sense, drivegate_command *command) {{
    controller *self = {self};
    self->count += 1.0;
    command->current_reference = self->count;
    command->advance_angle = 0.5;
    command->input_power = sense->time;
    if (self->count == 5.0) {{ {fifth} }}
    {step}
}}
"""
SENSED = """
    double sensed[] = {sense->time, sense->speed_reference, sense->speed, sense->current_magnitude_sum,
        sense->half_supply_voltage, (double)sense->phase_count, sense->phase_currents[0], sense->phase_currents[1],
        sense->phase_currents[2], sense->phase_currents[3], sense->phase_currents[4],
        (double)self->plate.phases, (double)self->plate.pole_pairs, self->plate.half_supply_voltage,
        self->plate.base_speed, self->plate.rated_power, self->plate.current_limit, self->plate.control_period,
        self->plate.hysteresis_band, self->plate.resistance, self->plate.inductance, self->plate.emf_constant,
        self->plate.inertia, (double)self->plate.kind, self->plate.window, self->plate.conducting_phases,
        self->plate.advance_start, self->plate.advance_slope, self->plate.highest_speed};
    command->current_reference = sensed[(int)self->count - 1];
"""


@pytest.fixture(scope="module")
def workshop(tmp_path_factory, build_fmu):
    """Build each FMU once, from what is particular of its controller."""
    folder, built = tmp_path_factory.mktemp("workshop"), {}

    def make(version=2, *, phases=5, power=False, only_once=False, **parts):
        key = (version, phases, power, only_once, *sorted(parts.items()))
        if key not in built:
            place = {"size": "0", "self": "&only", "declarations": "static controller only;"}
            usual = {"size": "sizeof(controller)", "self": "state", "declarations": ""}
            texts = {"reset": "", "fifth": "", "step": "", **(place if only_once else usual), **parts}
            source = folder / f"mine_{len(built)}.c"
            source.write_text(SOURCE.format(**texts), encoding="utf-8")
            built[key] = build_fmu(
                [source], source.with_suffix(".fmu"), fmi=version, phases=phases, estimates_power=power
            )
        return built[key]

    return make


@pytest.fixture(autouse=True)
def surroundings(monkeypatch, tmp_path, no_process_left):
    """Hold the tests to leaving nothing behind."""
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(scratch))
    monkeypatch.setenv("TMPDIR", str(scratch))
    yield
    _unpacked.cache_clear()
    gc.collect()
    assert list(scratch.iterdir()) == [], "a temporary file is left"


@pytest.fixture
def altered(tmp_path):
    """Copy an FMU with its description, or its other files, changed."""

    def make(fmu, *replacements, rename=lambda name: name, more=()):
        copy = tmp_path / "altered.fmu"
        with zipfile.ZipFile(fmu) as source, zipfile.ZipFile(copy, "w", zipfile.ZIP_DEFLATED) as target:
            for name in source.namelist():
                content = source.read(name)
                if name == DESCRIPTION:
                    for old, new in replacements:
                        assert old.encode() in content, f"the description has no {old}"
                        content = content.replace(old.encode(), new.encode())
                if rename(name):
                    target.writestr(rename(name), content)
            for name, content in more:
                target.writestr(name, content)
        return copy

    return make


def controller_of(fmu):
    return load_controller(resolve_candidate(str(fmu)))


def stepped(controller, times, sense=SENSE):
    """Step the object behind the bridge, as the bridge does."""
    return [controller._fmu.step(sense._replace(time=time)) for time in times]


def refusal_of(fmu):
    with pytest.raises(InputError) as refusal:
        controller_of(fmu)
    sentence = str(refusal.value)
    assert "\n" not in sentence
    assert "Traceback" not in sentence
    return sentence


# What a working FMU does


@pytest.mark.parametrize("version", VERSIONS)
def test_the_example_as_an_fmu_gives_the_trace_of_the_same_source_bit_for_bit(version, tmp_path, build_fmu):
    source = EXAMPLES / "c" / "controller.c"
    fmu = build_fmu([source], tmp_path / "example.fmu", fmi=version)
    scenario = load_scenario("fig5-search").model_copy(update={"duration_s": 6.0})
    traces = [
        run_scenario(scenario, load_controller(resolve_candidate(str(file))), trace_every=1).trace
        for file in (source, fmu)
    ]
    assert np.ptp(traces[0]["advance_deg"]) > 5.0, "a trace in which nothing happens proves nothing"
    # What was not sensed is not a number, which is equal to none.
    assert traces[0].tobytes() == traces[1].tobytes()


@pytest.mark.parametrize("version", VERSIONS)
def test_inputs_and_parameters_arrive_and_the_answer_is_of_the_same_period(version, workshop):
    controller = controller_of(workshop(version, power=True, step=SENSED))
    controller.reset(NAMEPLATE)
    sensed = [
        *(SENSE.time, SENSE.speed_reference, SENSE.speed, SENSE.current_magnitude_sum),
        *(SENSE.half_supply_voltage, 5.0, *SENSE.phase_currents, *NAMEPLATE),
    ]
    times = [k * NAMEPLATE.control_period for k in range(len(sensed))]
    commands = stepped(controller, times)
    assert [command.current_reference for command in commands] == sensed
    assert [command.input_power for command in commands] == times, "outputs are those of the step just done"


@pytest.mark.parametrize("version", VERSIONS)
def test_without_an_estimate_of_power_there_is_none(version, workshop):
    controller = controller_of(workshop(version))
    controller.reset(NAMEPLATE)
    (command,) = stepped(controller, [0.0])
    assert np.isnan(command.input_power)


@pytest.mark.parametrize("version", VERSIONS)
def test_a_reset_forgets_everything_and_instances_share_nothing(version, workshop):
    fmu = workshop(version)
    first, second = controller_of(fmu), controller_of(fmu)
    times = [k * NAMEPLATE.control_period for k in range(3)]
    for controller in (first, second, first):
        controller.reset(NAMEPLATE)
    for controller in (first, second, first):
        controller.reset(NAMEPLATE)
        assert [command.current_reference for command in stepped(controller, times)] == [1.0, 2.0, 3.0]
    assert stepped(second, [0.0])[0].current_reference == 4.0


@pytest.mark.parametrize("version", VERSIONS)
def test_of_an_fmu_that_keeps_its_state_in_globals_the_last_one_reset_works(version, workshop):
    fmu = workshop(version, only_once=True)
    with zipfile.ZipFile(fmu) as archive:
        assert b'canBeInstantiatedOnlyOncePerProcess="true"' in archive.read(DESCRIPTION)
    first, second = controller_of(fmu), controller_of(fmu)
    first.reset(NAMEPLATE)
    stepped(first, [0.0])
    second.reset(NAMEPLATE)
    assert stepped(second, [0.0])[0].current_reference == 1.0
    with pytest.raises(Exception, match="another instance took this one's place"):
        stepped(first, [0.0])


@pytest.mark.parametrize("version", VERSIONS)
def test_an_fmu_runs_in_a_worker_and_is_unpacked_once(version, workshop):
    with Judge(resolve_candidate(str(workshop(version)))) as worker:
        first, longer, again = (worker.run(Job(worker_jobs.drive, steps)) for steps in (4, 30, 4))
        folders = list(Path(tempfile.gettempdir()).rglob("drivegate-fmu-*"))
    assert first == again == 1.0 + 2.0 + 3.0 + 4.0
    assert longer == sum(range(31))
    assert len(folders) == 1, "each run would unpack it again"


def test_a_time_input_is_set(workshop, altered):
    fmu = altered(workshop(2, step=SENSED), ('name="phase_currents[5]"', 'name="time"'))
    with pytest.raises(InputError, match="takes 4 phase currents, but the motor has 5 phases"):
        controller_of(fmu).reset(NAMEPLATE)
    controller = controller_of(fmu)
    controller.reset(NAMEPLATE._replace(phases=4))
    times = [k * NAMEPLATE.control_period for k in range(11)]
    answers = stepped(controller, times, SENSE._replace(phase_currents=(1.0, 2.0, 3.0, 4.0)))
    assert [answer.current_reference for answer in answers[6:]] == [1.0, 2.0, 3.0, 4.0, times[-1]]


def test_the_phases_must_be_those_of_the_drive(workshop):
    controller = controller_of(workshop(3))
    with pytest.raises(InputError, match="takes 5 phase currents, but the motor has 3 phases"):
        controller.reset(NAMEPLATE._replace(phases=3))


def test_an_fmu_needs_no_phase_currents(workshop, altered):
    fmu = altered(workshop(2), ('name="phase_currents[', 'causality="local" name="was['))
    fmu = altered_causality(fmu)
    controller = controller_of(fmu)
    controller.reset(NAMEPLATE._replace(phases=3))
    assert stepped(controller, [0.0], SENSE._replace(phase_currents=(1.0, 2.0, 3.0)))


def altered_causality(fmu):
    """Leave out the second of two causalities of a variable."""
    with zipfile.ZipFile(fmu) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    lines = contents[DESCRIPTION].decode().splitlines()
    lines = [line.replace(' causality="input"', "") if "was[" in line else line for line in lines]
    contents[DESCRIPTION] = "\n".join(lines).encode()
    with zipfile.ZipFile(fmu, "w") as archive:
        for name, content in contents.items():
            archive.writestr(name, content)
    return fmu


def test_the_page_names_every_variable():
    page = (ROOT / "docs" / "candidates" / "fmu.md").read_text(encoding="utf-8")
    names = [f"{name}[1]" for name in DUTY.input_arrays]
    for ports in (CURRENT, DUTY):
        names += [*ports.inputs, *ports.more_inputs, *ports.outputs, *ports.more_outputs, *ports.parameters]
        names += [f"{array}[1]" for array in (*ports.arrays, *ports.more_arrays)]
    assert [name for name in names if f"`{name}`" not in page] == []


def test_a_manifest_names_an_fmu_and_declares_for_it(workshop, tmp_path):
    fmu = shutil.copy(workshop(2, power=True), tmp_path / "own.fmu")
    manifest = tmp_path / "candidate.toml"
    text = 'schema = 1\nname = "mine"\nkind = "fmu"\nentry = "own.fmu"\nestimates_power = true\n'
    manifest.write_text(text, encoding="utf-8")
    candidate = resolve_candidate(str(manifest))
    assert (candidate.name, candidate.kind, candidate.declaration.estimates_power) == ("mine", "fmu", True)
    assert candidate.content_hash == resolve_candidate(str(fmu)).content_hash
    manifest.write_text(text.replace("own.fmu", "mine.zip"), encoding="utf-8")
    with pytest.raises(InputError, match=r"the key 'entry' is 'mine.zip', .* must be a file \*.fmu"):
        resolve_candidate(str(manifest))


def test_the_builder_works_from_the_command_line_and_states_what_fails(tmp_path):
    (tmp_path / "mine.c").write_text(
        SOURCE.format(declarations="", size="sizeof(controller)", self="state", reset="", fifth="", step="")
    )
    command = [sys.executable, str(BUILDER), "mine.c", "--fmi", "3", "--phases", "3"]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (ran.returncode, ran.stdout) == (0, "mine.fmu\n"), ran.stderr
    assert controller_of(tmp_path / "mine.fmu")._fmu.description.connections.arrays == (
        ("phase_currents", 3),
    )
    (tmp_path / "mine.c").write_text("int main(void) { return missing; }\n")
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ran.returncode == 1
    assert ran.stderr.endswith("the controller does not compile\n")


# What fails while it runs

FAULTS = {
    "segfault": (
        "*(volatile int *)8 = 1;",
        FaultKind.CRASH,
        "SIGSEGV (Segmentation fault) after 4 completed steps",
    ),
    "abort": ("abort();", FaultKind.CRASH, "SIGABRT (Aborted) after 4 completed steps"),
    "exit": ("exit(3);", FaultKind.CRASH, "exit status 3 after 4 completed steps"),
    "loop": (
        "for (volatile int i = 0;;) i = 1;",
        FaultKind.HANG,
        "no progress within 0.3 s of processor time",
    ),
    "nan": ("command->advance_angle = NAN;", FaultKind.INVALID_OUTPUT, "advance_angle is nan"),
    "infinity": (
        "command->current_reference = INFINITY;",
        FaultKind.INVALID_OUTPUT,
        "current_reference is inf",
    ),
}


@pytest.mark.one_in(6)
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_in_a_step_gets_its_verdict_and_the_next_job_works(fault, version, workshop):
    statement, kind, message = FAULTS[fault]
    candidate = resolve_candidate(str(workshop(version, fifth=statement)))
    with Judge(candidate, limits=QUICK) as worker:
        fault = worker.once(Job(worker_jobs.drive, 7))
        assert (fault.kind, fault.phase, fault.step) == (kind, "step", 4)
        assert message in fault.message
        assert worker.run(Job(worker_jobs.drive, 3)) == 6.0


@pytest.mark.parametrize("version", VERSIONS)
def test_a_status_of_failure_is_reported_with_what_the_fmu_logged(version, workshop, altered):
    fmu = altered(workshop(version), ('name="control_period"', 'name="sample_time"'))
    with Judge(resolve_candidate(str(fmu))) as worker:
        fault = worker.run(Job(worker_jobs.drive, 7))
    assert (fault.kind, fault.phase, fault.step, fault.error) == (FaultKind.EXCEPTION, "step", 0, "FmuError")
    assert fault.message == (
        f"FmuError: fmi{version}DoStep returned fmi{version}Error: the communication step is 0.0005 s, but the "
        "parameter control_period is 0 s"
    )
    assert fault.sense["speed"] == 99.0
    assert tempfile.gettempdir() not in fault.traceback


@pytest.mark.parametrize("version", VERSIONS)
def test_a_controller_that_refuses_its_reset_is_reported_in_the_first_step(version, workshop):
    with Judge(resolve_candidate(str(workshop(version, reset="return 7;")))) as worker:
        fault = worker.run(Job(worker_jobs.drive, 7))
    assert fault.message == (
        f"FmuError: fmi{version}ExitInitializationMode returned fmi{version}Error: drivegate_reset returned 7"
    )


@pytest.mark.parametrize("version", VERSIONS)
def test_no_instance_is_a_fault_of_the_reset(version, workshop, altered):
    token = {2: 'guid="', 3: 'instantiationToken="'}[version]
    controller = controller_of(altered(workshop(version), (token, token + "another")))
    with pytest.raises(CandidateFault) as raised:
        controller.reset(NAMEPLATE)
    fault = raised.value.fault
    assert (fault.kind, fault.phase) == (FaultKind.EXCEPTION, "reset")
    assert fault.message.endswith("returned no instance: modelDescription.xml belongs to another build")


@pytest.mark.one_in(2)
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize(
    ("status", "name", "freed"),
    [(2, "Discard", True), (3, "Error", True), (4, "Fatal", False), (9, "9", True)],
)
def test_each_status_has_its_name_and_after_a_fatal_one_nothing_is_called(
    status, name, freed, version, workshop
):
    controller = controller_of(workshop(version))
    controller.reset(NAMEPLATE)
    controller._fmu._do_step = lambda time, period: status
    with pytest.raises(FmuError, match=f"fmi{version}DoStep returned fmi{version}{name}$"):
        stepped(controller, [0.0])
    assert controller._fmu._free.alive is freed, "a corrupted instance must not even be freed"
    controller.reset(NAMEPLATE)
    assert stepped(controller, [0.0])[0].current_reference == 1.0


def test_an_fmu_that_asks_to_end_the_simulation_has_failed(workshop):
    controller = controller_of(workshop(3))
    controller.reset(NAMEPLATE)

    def ending(time, period):
        controller._fmu._ends.value = True
        return 0

    controller._fmu._do_step = ending
    with pytest.raises(FmuError, match="fmi3DoStep requested the end of the simulation"):
        stepped(controller, [0.0])


# What is refused

UNUSABLE = {
    "missing input": (
        [('name="speed_reference"', 'name="speed_refrence"')],
        "there is no input 'speed_reference' (the nearest input is 'speed_refrence')",
    ),
    "unknown input": (
        [('name="phase_currents', 'name="phase_current')],
        "nothing is known of the input 'phase_current",
    ),
    "missing outputs": (
        [('name="current_reference"', 'name="current"'), ('name="advance_angle"', 'name="angle"')],
        "there is no output 'current_reference' (the nearest output is 'current'), there is no output 'advance_angle'",
    ),
}


@pytest.mark.one_in(2)
@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("case", UNUSABLE)
def test_variables_that_do_not_fit_are_all_reported(case, version, workshop, altered):
    replacements, reason = UNUSABLE[case]
    sentence = refusal_of(altered(workshop(version), *replacements))
    assert reason in sentence
    assert "a controller has the" in sentence


def test_ill_typed_variables_are_all_reported(workshop, altered):
    text = '<ScalarVariable name="speed" valueReference="2" causality="input" variability="discrete">\n      <Real'
    parameter = 'name="inertia" valueReference="40" causality="parameter" variability="fixed">\n      <Real'
    sentence = refusal_of(
        altered(
            workshop(2),
            (text, text.replace("Real", "Integer")),
            (parameter, parameter.replace("Real", "Boolean")),
            (
                'name="current_reference" valueReference="11" causality="output"',
                'name="current_reference" valueReference="11" causality="local"',
            ),
        )
    )
    for reason in (
        "'speed' is of the type Integer, but must be Real",
        "'inertia' is of the type Boolean, but must be Real",
        "'current_reference' is of the causality local, but must be an output",
    ):
        assert reason in sentence


def test_arrays_are_only_for_the_phase_currents(workshop, altered):
    sentence = refusal_of(
        altered(
            workshop(3),
            ('name="phase_currents"', 'name="speed"'),
            ('name="speed" valueReference="2"', 'name="x" valueReference="2"'),
        )
    )
    assert "'speed' is an array, but must be a single value" in sentence


def test_a_gap_among_the_phase_currents_is_reported(workshop, altered):
    sentence = refusal_of(altered(workshop(2), ('name="phase_currents[2]"', 'name="phase_currents[6]"')))
    assert "there is no input 'phase_currents[2]'" in sentence


REFUSED = {
    "model exchange": (
        2,
        ("<CoSimulation", "<ModelExchange"),
        "is an FMU for model exchange; export it for co-simulation",
    ),
    "scheduled": (
        3,
        ("<CoSimulation", "<ScheduledExecution"),
        "is an FMU for scheduled execution; export it for co-sim",
    ),
    "tool": (
        2,
        ("<CoSimulation", '<CoSimulation needsExecutionTool="true"'),
        "needs the tool that exported it to run",
    ),
    "old": (
        2,
        ('fmiVersion="2.0"', 'fmiVersion="1.0"'),
        "is of FMI version '1.0'; export it for FMI 2.0 or 3.0",
    ),
    "new": (
        3,
        ('fmiVersion="3.0"', 'fmiVersion="4.0"'),
        "is of FMI version '4.0'; export it for FMI 2.0 or 3.0",
    ),
    "no version": (2, (' fmiVersion="2.0"', ""), "is of FMI version ''"),
    "no XML": (2, ("<fmiModelDescription", "<<fmi"), f"{DESCRIPTION} is no valid XML: not well-formed"),
    "identifier": (2, ('modelIdentifier="mine', 'modelIdentifier="../mine'), "but must be a name as in C"),
    "reference": (
        2,
        (' valueReference="2"', ' valueReference="two"'),
        f"{DESCRIPTION} is not as FMI requires: ERROR",
    ),
    "structure": (
        2,
        ('<Unknown index="', '<Unknown index="99'),
        f"{DESCRIPTION} is not as FMI requires: IndexError",
    ),
    "library": (2, ('modelIdentifier="mine', 'modelIdentifier="yours'), "but this platform needs binaries/"),
    "document type": (
        3,
        (
            "<fmiModelDescription",
            '<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]><fmiModelDescription',
        ),
        "has a document type, which may define entities of any size",
    ),
}


@pytest.mark.one_in(2)
@pytest.mark.parametrize("case", REFUSED)
def test_an_fmu_that_is_not_for_this_is_refused(case, workshop, altered):
    version, replacement, reason = REFUSED[case]
    assert reason in refusal_of(altered(workshop(version), replacement))


def test_a_rule_of_fmi_that_does_not_matter_here_may_be_broken(workshop, altered):
    fmu = altered(
        workshop(2), ('<Category name="logStatusError"', '<Category name="logStatusError" colour="red"')
    )
    assert controller_of(fmu).fault is None


@pytest.mark.parametrize("version", VERSIONS)
def test_code_for_another_platform_is_refused(version, workshop, altered):
    other = {2: "binaries/win64/m.dll", 3: "binaries/aarch64-darwin/m.dylib"}[version]
    sentence = refusal_of(
        altered(workshop(version), rename=lambda name: name if name == DESCRIPTION else other)
    )
    assert f"has binaries for {Path(other).parent.name} only, but this platform needs binaries/" in sentence


def test_an_fmu_without_code_is_refused(workshop, altered):
    sentence = refusal_of(altered(workshop(2), rename=lambda name: name if name == DESCRIPTION else ""))
    assert "has no binaries, but this platform needs" in sentence


@pytest.mark.parametrize("version", VERSIONS)
def test_a_library_that_is_none_is_refused(version, workshop, altered):
    here = Path.cwd()
    with zipfile.ZipFile(workshop(version)) as archive:
        (library,) = (name for name in archive.namelist() if name != DESCRIPTION)
    fmu = altered(
        workshop(version), rename=lambda name: name if name == DESCRIPTION else "", more=[(library, b"x")]
    )
    sentence = refusal_of(fmu)
    assert "has a library that cannot be loaded" in sentence
    assert tempfile.gettempdir() not in sentence
    assert Path.cwd() == here


def test_a_library_without_the_functions_of_fmi_is_refused(workshop, altered):
    with zipfile.ZipFile(workshop(3)) as archive:
        (library,) = (archive.read(name) for name in archive.namelist() if name != DESCRIPTION)
    with zipfile.ZipFile(workshop(2)) as archive:
        (name,) = (name for name in archive.namelist() if name != DESCRIPTION)
    fmu = altered(workshop(2), rename=lambda other: "" if other == name else other, more=[(name, library)])
    sentence = refusal_of(fmu)
    assert "has a library that cannot be loaded: " in sentence
    assert "fmi2" in sentence


# What is no FMU, or a hostile one


@pytest.mark.parametrize("content", [b"", b"PK\x03\x04 garbage", b"\0" * 1000, b"PK\x05\x06" + b"\xff" * 18])
def test_what_is_no_archive_is_refused(content, tmp_path):
    file = tmp_path / "mine.fmu"
    file.write_bytes(content)
    assert "is no zip archive, which every FMU is" in refusal_of(file)


def test_an_archive_without_a_description_is_refused(tmp_path):
    file = tmp_path / "mine.fmu"
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("readme.txt", "nothing")
    assert f"has no {DESCRIPTION} in it" in refusal_of(file)


def test_a_damaged_archive_is_refused(workshop, tmp_path):
    content = bytearray(workshop(2).read_bytes())
    content[len(content) // 2] ^= 0xFF
    file = tmp_path / "mine.fmu"
    file.write_bytes(content)
    assert "is damaged: 'binaries/" in refusal_of(file)


@pytest.mark.parametrize("name", ["../outside", "a/../../outside", "/outside", "..\\outside", "c:outside"])
def test_an_entry_that_leads_outside_is_refused(name, workshop, altered, tmp_path):
    fmu = altered(workshop(2), more=[(name, "x")])
    sentence = refusal_of(fmu)
    assert "which may lead outside of its folder" in sentence
    assert not list(tmp_path.rglob("outside"))


def test_a_link_is_refused(workshop, altered):
    link = zipfile.ZipInfo("resources")
    link.external_attr = 0o120777 << 16
    assert "which may lead outside" in refusal_of(altered(workshop(2), more=[(link, "/etc")]))


def test_an_archive_that_would_fill_the_disk_is_refused_before_it_does(tmp_path):
    file, packed = tmp_path / "mine.fmu", io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for index in range(3):
            archive.writestr(f"zeros{index}", bytes(2**20))
    file.write_bytes(packed.getvalue())
    with pytest.raises(InputError, match="would unpack to 3 MiB; an FMU may have 2 MiB"):
        unpack(file, tmp_path / "none", most_bytes=2 * 2**20)
    with pytest.raises(InputError, match="has 3 files in it; an FMU may have 2"):
        unpack(file, tmp_path / "none", most_files=2)
    assert not (tmp_path / "none").exists()


def test_an_archive_that_lies_about_its_size_is_refused(tmp_path):
    file, packed = tmp_path / "mine.fmu", io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("zeros", bytes(2**20))
    size = (2**20).to_bytes(4, "little")
    file.write_bytes(packed.getvalue().replace(size, (10).to_bytes(4, "little")))
    folder = tmp_path / "folder"
    with pytest.raises(InputError, match="is damaged: 'zeros' in it cannot be unpacked"):
        unpack(file, folder)
    assert sum(found.stat().st_size for found in folder.iterdir()) <= 10


def test_a_description_in_another_encoding_has_no_document_type_either(workshop, altered):
    fmu = altered(
        workshop(2),
        rename=lambda name: "" if name == DESCRIPTION else name,
        more=[(DESCRIPTION, '<?xml version="1.0" encoding="UTF-16"?><!DOCTYPE x><x/>'.encode("utf-16"))],
    )
    assert "has a document type" in refusal_of(fmu)


def test_a_worker_refuses_too_and_leaves_nothing(workshop, altered):
    fmu = altered(workshop(2), ('name="speed"', 'name="velocity"'))
    with (
        Judge(resolve_candidate(str(fmu))) as worker,
        pytest.raises(InputError, match="there is no input 'speed'"),
    ):
        worker.run(Job(worker_jobs.drive, 3))


def test_a_file_that_is_missing_or_not_opened_is_no_matter_of_the_parent(tmp_path):
    with pytest.raises(InputError, match="does not exist; name an existing file"):
        resolve_candidate(str(tmp_path / "none.fmu"))
    garbage = tmp_path / "garbage.fmu"
    garbage.write_bytes(b"garbage")
    assert resolve_candidate(str(garbage)).kind == "fmu"


def test_without_fmpy_one_sentence_says_what_to_install(workshop, monkeypatch):
    monkeypatch.setitem(sys.modules, "fmpy", None)
    assert refusal_of(workshop(2)).endswith("is an FMU, which needs the package fmpy; pip install fmpy")


def test_a_changed_file_is_unpacked_again(workshop, tmp_path):
    file = tmp_path / "mine.fmu"
    for version in VERSIONS:
        file.write_bytes(workshop(version).read_bytes())
        assert controller_of(file)._fmu.description.version == version
    assert len(list(Path(tempfile.gettempdir()).iterdir())) == 2
