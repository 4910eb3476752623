"""A Python controller behind its C function: what it senses, what it may answer, how each fault is reported."""

import ctypes
import fractions
import math
from types import SimpleNamespace

import numpy as np
import pytest

from drivegate import Command, Nameplate, Sense
from drivegate.candidates.fault import LONGEST_MESSAGE, LONGEST_TRACEBACK, CandidateFault, FaultKind
from drivegate.candidates.python.bridge import PythonController
from drivegate.candidates.python.loading import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate_models.contract.current.records import COMMAND, STOP, command_record, sense_record
from drivegate_models.errors import InputError

NAMEPLATE = Nameplate(
    *(5, 11, 48.0, 52.36, 1500.0, 26.0, 0.0005, 0.25, 0.08, 0.00288, 0.339, 0.05),
    *(1, 2.513, 4.0, 0.576, 0.00417, 157.08),
)
SENSE = Sense(0.25, 157.0, 156.5, (1.0, 2.0, -3.0, 0.5, 0.0), 6.5, 47.9)
STEP = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p)


def controller_of(step, reset=lambda nameplate: None):
    return PythonController(SimpleNamespace(step=step, reset=reset))


def stepped(controller, sense=SENSE):
    """Call the controller's step by its address, as the compiled loop does."""
    record, command = sense_record(sense, np.empty(len(sense.phase_currents))), command_record()
    currents = np.array(sense.phase_currents)
    record["phase_currents"] = currents.ctypes.data
    STEP(controller.step_address)(controller.state_address, record.ctypes.data, command.ctypes.data)
    return command[0]


def raising(error):
    def step(sense):
        raise error

    return step


def test_the_controller_receives_the_sense_as_it_is():
    sensed = []
    stepped(controller_of(lambda sense: sensed.append(sense) or Command(1.0, 0.5)))
    assert sensed == [SENSE]
    assert isinstance(sensed[0], Sense)
    assert isinstance(sensed[0].phase_currents, tuple)


def test_the_controller_follows_records_that_move_and_change_their_size():
    sensed = []
    controller = controller_of(lambda sense: sensed.append(sense) or Command(1.0, 0.5))
    senses = [
        SENSE._replace(time=float(phases), phase_currents=(1.5,) * phases) for phases in (5, 3, 5, 0, 9)
    ]
    for sense in senses:
        stepped(controller, sense)
    assert sensed == senses


@pytest.mark.parametrize(
    ("command", "expected"),
    [
        (Command(12.5, 0.7), (12.5, 0.7, math.nan)),
        (Command(12.5, 0.7, 850.0), (12.5, 0.7, 850.0)),
        (Command(-1.0, 99.0, -5.0), (-1.0, 99.0, -5.0)),
        (Command(12, 0, 850), (12.0, 0.0, 850.0)),
        (Command(np.float32(0.5), np.int64(1), np.float64(2.0)), (0.5, 1.0, 2.0)),
        (Command(fractions.Fraction(1, 4), 0.0), (0.25, 0.0, math.nan)),
    ],
)
def test_the_command_reaches_the_record(command, expected):
    controller = controller_of(lambda sense: command)
    record = stepped(controller)
    assert controller.fault is None
    assert record["struct_size"] == COMMAND.itemsize
    np.testing.assert_array_equal([record[name] for name in Command._fields], expected)


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        (None, "step returned None, but must return a drivegate.Command(current_reference, advance_angle)"),
        ((1.0, 0.5), "step returned an object of type tuple, but must return a drivegate.Command"),
        (1.0, "step returned an object of type float, but must return a drivegate.Command"),
        (Command(math.nan, 0.5), "current_reference is nan, but must be finite"),
        (Command(1.0, math.inf), "advance_angle is inf, but must be finite"),
        (Command(1.0, 0.5, -math.inf), "input_power is -inf, but must be finite, or NaN for no estimate"),
        (Command("1", 0.5), "current_reference is of type str, but must be a real number"),
        (Command(True, 0.5), "current_reference is of type bool, but must be a real number"),
        (Command(1.0, None), "advance_angle is of type NoneType, but must be a real number"),
        (Command(1.0, 0.5, None), "input_power is of type NoneType, but must be a real number"),
        (Command(1.0, 1j), "advance_angle is of type complex, but must be a real number"),
        (Command(1.0, np.bool_(True)), "advance_angle is of type bool, but must be a real number"),
        (Command(np.array([1.0]), 0.5), "current_reference is of type ndarray, but must be a real number"),
        (Command(10**400, 0.5), "current_reference is an integer too large for a 64-bit float"),
    ],
)
def test_an_invalid_output_stops_the_loop_and_is_reported(answer, message):
    controller = controller_of(lambda sense: answer)
    record = stepped(controller)
    assert record["struct_size"] == STOP
    assert controller.fault.kind is FaultKind.INVALID_OUTPUT
    assert controller.fault.message.startswith(message)
    assert controller.fault.phase == "step"


@pytest.mark.parametrize(
    "error",
    [ValueError("wrong gain"), SystemExit(3), KeyboardInterrupt(), GeneratorExit(), RecursionError("deep")],
    ids=lambda error: type(error).__name__,
)
def test_an_exception_in_step_stops_the_loop_and_is_reported(error):
    controller = controller_of(raising(error))
    record = stepped(controller)
    fault = controller.fault
    assert record["struct_size"] == STOP
    assert (fault.kind, fault.phase, fault.error) == (FaultKind.EXCEPTION, "step", type(error).__name__)
    assert fault.message.startswith(type(error).__name__)
    assert (fault.time, fault.sense) == (SENSE.time, SENSE._asdict())
    assert "in step" in fault.traceback
    assert "in _step" not in fault.traceback, "the traceback must start at the candidate's own frame"


def test_the_first_fault_stays_until_the_next_reset():
    controller = controller_of(raising(ValueError("first")))
    stepped(controller)
    stepped(controller, SENSE._replace(time=9.0))
    assert controller.fault.time == SENSE.time
    controller.reset(NAMEPLATE)
    assert controller.fault is None


def test_an_endless_recursion_is_an_exception():
    def step(sense):
        return step(sense)

    controller = controller_of(step)
    stepped(controller)
    assert controller.fault.error == "RecursionError"


def test_an_exception_that_cannot_be_printed_is_still_reported():
    class Unprintable(Exception):
        def __str__(self):
            raise RuntimeError("no text")

    controller = controller_of(raising(Unprintable()))
    stepped(controller)
    assert controller.fault.message == "Unprintable: (its text cannot be had: RuntimeError)"


def test_what_is_reported_is_bounded_and_printable():
    controller = controller_of(raising(ValueError("\x1b[31m" + "line\n\ud800\t" * 100_000)))
    stepped(controller)
    fault = controller.fault
    assert len(fault.message) == LONGEST_MESSAGE
    assert fault.message.startswith(r"ValueError: \x1b[31mline\n\ud800\tline")
    assert fault.message.isprintable()
    assert len(fault.traceback) <= LONGEST_TRACEBACK
    assert all(line.isprintable() for line in fault.traceback.split("\n"))


def test_memory_addresses_are_left_out_of_what_is_reported():
    messages = set()
    for thing in (object(), object()):
        controller = controller_of(raising(ValueError(f"{thing!r} is wrong")))
        stepped(controller)
        messages.add(controller.fault.message)
    assert messages == {"ValueError: <object object at 0x…> is wrong"}


def test_reset_passes_the_nameplate_and_takes_over_a_new_step():
    instance = SimpleNamespace(step=lambda sense: Command(1.0, 0.0))

    def reset(nameplate):
        instance.step = lambda sense: Command(nameplate.current_limit, 0.0)

    instance.reset = reset
    controller = PythonController(instance)
    controller.reset(NAMEPLATE)
    assert stepped(controller)["current_reference"] == NAMEPLATE.current_limit


def test_an_exception_in_reset_is_reported():
    controller = controller_of(lambda sense: Command(1.0, 0.0), raising(ZeroDivisionError("no gain")))
    with pytest.raises(CandidateFault) as caught:
        controller.reset(NAMEPLATE)
    fault = caught.value.fault
    assert fault is controller.fault
    assert (fault.kind, fault.phase, fault.message) == (
        FaultKind.EXCEPTION,
        "reset",
        "ZeroDivisionError: no gain",
    )


GOOD = "def reset(self, nameplate): pass\n def step(self, sense): pass\n"


@pytest.fixture
def loaded(tmp_path, monkeypatch):
    """Load a class from source text."""
    monkeypatch.syspath_prepend(tmp_path)

    def load(text, name="Mine"):
        file = tmp_path / "controller.py"
        file.write_text(text, encoding="utf-8")
        return load_controller(resolve_candidate(f"{file}:{name}"))

    return load


def test_a_class_is_loaded_with_its_neighbours(loaded, tmp_path):
    (tmp_path / "neighbour_of_controller.py").write_text("GAIN = 2.5\n", encoding="utf-8")
    text = (
        "from drivegate import Command\nfrom neighbour_of_controller import GAIN\nclass Mine:\n"
        " def reset(self, nameplate): pass\n def step(self, sense): return Command(GAIN, 0.0)\n"
    )
    assert stepped(loaded(text))["current_reference"] == 2.5


def test_a_class_inside_a_class_is_loaded(loaded):
    assert loaded(
        f"class Outer:\n class Mine:\n  {GOOD.replace(chr(10) + ' ', chr(10) + '  ')}", "Outer.Mine"
    )


def test_each_load_makes_a_new_instance_of_a_module_imported_once(tmp_path):
    file = tmp_path / "counted_controller.py"
    file.write_text(f"print('imported')\nclass Mine:\n {GOOD}", encoding="utf-8")
    candidate = resolve_candidate(f"{file}:Mine")
    first, second = load_controller(candidate), load_controller(candidate)
    assert first.instance is not second.instance
    assert type(first.instance) is type(second.instance)


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        (
            "class Mine:\n  def reset(self) pass\n",
            "line 2: expected ':'; the file must be Python that version",
        ),
        ("import absent_module_of_mine\n", "cannot be imported: No module named 'absent_module_of_mine'"),
        (
            "from drivegate import Comand\n",
            "cannot be imported: cannot import name 'Comand' from 'drivegate'",
        ),
        (
            "class Mime:\n pass\n",
            "there is no class 'Mine' in controller.py, the nearest class there is 'Mime'",
        ),
        (
            "from drivegate import Command\n",
            "there is no class 'Mine' in controller.py, and no other class",
        ),
        ("def Mine(): pass\n", "'Mine' in controller.py is not a class"),
        ("class Mine:\n def reset(self, n): pass\n", "has no method 'step'; a controller has reset"),
        ("class Mine:\n def step(self, s): pass\n", "has no method 'reset'; a controller has reset"),
        ("class Mine:\n step = reset = 3\n", "has no method 'reset'"),
    ],
)
def test_a_candidate_that_cannot_be_used_is_refused(loaded, text, sentence):
    with pytest.raises(InputError) as caught:
        loaded(text)
    assert sentence in str(caught.value)


@pytest.mark.parametrize(
    ("text", "error"),
    [
        (f"class Mine:\n {GOOD} def __init__(self, gain): pass\n", "TypeError"),
        (f"class Mine:\n {GOOD} def __init__(self): 1 / 0\n", "ZeroDivisionError"),
        (f"1 / 0\nclass Mine:\n {GOOD}", "ZeroDivisionError"),
        (f"raise SystemExit\nclass Mine:\n {GOOD}", "SystemExit"),
        ("import drivegate_models.errors as e\nraise e.InputError('mine')\n", "InputError"),
    ],
)
def test_a_candidate_that_fails_while_loading_gets_its_verdict(loaded, text, error):
    with pytest.raises(CandidateFault) as caught:
        loaded(text)
    assert (caught.value.fault.kind, caught.value.fault.phase) == (FaultKind.EXCEPTION, "loading")
    assert caught.value.fault.error == error
    assert "python_loading.py" not in caught.value.fault.traceback
    assert "importlib" not in caught.value.fault.traceback
