"""A controller that numba compiles: what an author may write, and what is reported when it is wrong."""

import subprocess
import sys

import numba
import numpy as np
import pytest
from numba import types
from numba.np.numpy_support import carray

from drivegate import NumbaController, phase_current
from drivegate.candidates.fault import CandidateFault, FaultKind
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.native.numba_loading import load_numba_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.running import run_scenario
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.contract.current.records import COMMAND, NAMEPLATE, SENSE
from drivegate_models.errors import InputError

STATE = np.dtype([("limit", np.float64), ("steps", np.int64)])


@pytest.fixture(scope="module")
def scenario():
    """A short run."""
    return load_scenario("fig5-search").replaced(duration_s=0.25)


def reset(state, nameplate):
    state.limit = nameplate.current_limit
    state.steps = 0


def step(state, sense, command):
    state.steps += 1
    command.current_reference = state.limit if sense.speed < sense.speed_reference else 0.0
    command.advance_angle = 0.0


def raising_step(state, sense, command):
    state.steps += 1
    if state.steps == 5:
        raise ValueError("too late")
    command.current_reference = 1.0
    command.advance_angle = 0.0


def raising_reset(state, nameplate):
    if nameplate.phases == 5:
        raise RuntimeError("five phases")


def loaded(*, state=STATE, reset=reset, step=step):
    return load_numba_controller(NumbaController(state, reset=reset, step=step), "mine")


def test_it_is_compiled_once_a_process_and_each_instance_has_its_own_state():
    definition = NumbaController(STATE, reset=reset, step=step)
    one, other = (load_numba_controller(definition, "mine") for _ in range(2))
    assert one.step_address == other.step_address, "the same step is compiled twice"
    assert one.state_address != other.state_address
    assert one.step_address != loaded().step_address, "another definition has the same step"


def pointer(layout):
    return types.CPointer(numba.from_dtype(layout))


RESET_TYPE = types.int32(pointer(STATE), pointer(NAMEPLATE))
STEP_TYPE = types.void(pointer(STATE), pointer(SENSE), pointer(COMMAND))


@numba.cfunc(RESET_TYPE)
def reset_callback(state, nameplate):
    carray(state, 1)[0].limit = carray(nameplate, 1)[0].current_limit
    return 0


@numba.cfunc(STEP_TYPE)
def step_callback(state, sense, command):
    sensed = carray(sense, 1)[0]
    carray(command, 1)[0].current_reference = (
        carray(state, 1)[0].limit if sensed.speed < sensed.speed_reference else 0.0
    )
    carray(command, 1)[0].advance_angle = 0.0


def test_functions_and_callbacks_give_the_same_commands(scenario):
    digests = {
        run_scenario(scenario, controller).digest
        for controller in (
            loaded(),
            loaded(step=numba.njit(step), reset=numba.njit(reset)),
            loaded(step=step_callback, reset=reset_callback),
            loaded(state=STATE.itemsize, step=step_callback, reset=reset_callback),
            loaded(state=[("limit", "f8"), ("steps", "i8")]),
        )
    }
    assert len(digests) == 1


def test_a_phase_current_is_read_through_the_sense(scenario):
    def reading_step(state, sense, command):
        total = 0.0
        for phase in range(sense.phase_count):
            total += phase_current(sense, phase)
        command.current_reference = 5.0
        command.advance_angle = 0.0
        command.input_power = total

    controller = loaded(step=reading_step)
    run = run_scenario(scenario, controller)
    assert run.last_command[0]["input_power"] == pytest.approx(float(run.last_currents.sum()))


def test_an_exception_in_step_is_reported_with_its_inputs(scenario):
    with pytest.raises(CandidateFault) as caught:
        run_scenario(scenario, loaded(step=raising_step))
    fault = caught.value.fault
    assert (fault.kind, fault.phase, fault.step) == (FaultKind.EXCEPTION, "step", 4)
    assert fault.message == "ValueError: too late"
    assert fault.time == pytest.approx(4 * 0.0005)
    assert "raising_step" in fault.traceback


def test_an_exception_in_reset_is_reported(scenario):
    with pytest.raises(CandidateFault) as caught:
        run_scenario(scenario, loaded(reset=raising_reset))
    fault = caught.value.fault
    assert (fault.kind, fault.phase, fault.message) == (
        FaultKind.EXCEPTION,
        "reset",
        "RuntimeError: five phases",
    )


def test_a_fault_does_not_show_in_the_next_run(scenario):
    with pytest.raises(CandidateFault):
        run_scenario(scenario, loaded(step=raising_step))
    controller = loaded()
    run_scenario(scenario, controller)
    assert controller.fault is None


def unknown_field(state, sense, command):
    command.current_referense = 1.0


def unknown_name(state, sense, command):
    command.current_reference = nothing(sense.speed)  # noqa: F821


def plain_function(state, sense, command):
    command.current_reference = helping(sense.speed)


def helping(speed):
    return speed


def two_arguments(sense, command):
    pass


@pytest.mark.parametrize(
    ("parts", "sentence"),
    [
        ({"step": unknown_field}, "mine: step does not compile: a record has no field 'current_referense'"),
        ({"step": unknown_name}, "mine: step does not compile: NameError: name 'nothing' is not defined"),
        ({"step": plain_function}, "Untyped global name 'helping'"),
        ({"step": plain_function}, "use numbers, records and functions compiled with numba.njit only"),
        ({"step": two_arguments}, "mine: step takes (sense, command), but must take (state, sense, command)"),
        ({"step": 3}, "mine: step is of type int, but must be a function step(state, sense, command)"),
        ({"step": step_callback}, "step is a numba.cfunc, but the other one is not"),
        ({"state": 16}, "mine: the state is a size; give a numpy dtype with named fields"),
        ({"state": "f8"}, "mine: the state is the dtype float64; give a numpy dtype with named fields"),
        ({"state": "nonsense"}, "mine: the state is no numpy dtype"),
        (
            {"state": [("table", "f8", (9_000_000,))]},
            "give a numpy dtype with named fields of 1 byte to 64 MiB",
        ),
        (
            {"step": step_callback, "reset": step_callback},
            "but must return int32 and take 2 pointers, as drivegate_reset in drivegate.h",
        ),
        ({"state": -1, "step": step_callback, "reset": reset_callback}, "the size of the state is -1, but"),
    ],
)
def test_what_is_wrong_is_reported_in_one_sentence(parts, sentence):
    with pytest.raises(InputError) as caught:
        loaded(**parts)
    message = str(caught.value)
    assert sentence in message
    assert message.isprintable()
    assert len(message) < 700


FILE = """
import numpy as np
from drivegate import NumbaController

def reset(state, nameplate):
    state.limit = nameplate.current_limit

def step(state, sense, command):
    command.current_reference = state.limit
    command.advance_angle = 0.0

mine = NumbaController(np.dtype([("limit", np.float64)]), reset=reset, step=step)
"""


def test_a_file_a_manifest_and_an_entry_point_may_name_one(tmp_path, monkeypatch, scenario):
    from importlib.metadata import EntryPoint, EntryPoints

    from drivegate.candidates import resolution as candidate_resolution

    (tmp_path / "product.py").write_text(FILE, encoding="utf-8")
    (tmp_path / "candidate.toml").write_text(
        'schema = 1\nname = "mine"\nkind = "python"\nentry = "product.py:mine"\n', encoding="utf-8"
    )
    monkeypatch.chdir(tmp_path)
    points = EntryPoints([EntryPoint("product", "product:mine", candidate_resolution.ENTRY_POINT_GROUP)])
    monkeypatch.setattr(candidate_resolution, "entry_points", lambda group: points.select(group=group))
    named = ("product.py:mine", "candidate.toml", "product")
    runs = [run_scenario(scenario, load_controller(resolve_candidate(name))) for name in named]
    assert len({run.digest for run in runs}) == 1


def test_the_public_name_costs_nothing():
    script = (
        "import sys; from drivegate import NumbaController; "
        "sys.exit(bool({'numba', 'numpy'} & set(sys.modules)))"
    )
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0, (
        "naming NumbaController must not import numba"
    )
