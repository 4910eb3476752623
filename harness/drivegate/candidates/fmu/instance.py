"""One instance of an FMU, stepped as a controller.

In each control period the inputs are set at its start t, one communication step is done from t over the control
period, and the outputs are read; they are the command for that same period. The first step also initialises the
FMU, so that its equations start from the first measurements.
"""

from __future__ import annotations

import ctypes
import weakref
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from struct import Struct
from typing import Any, ClassVar, Final, TypeAlias

from drivegate.candidates.contract import AnyNameplate
from drivegate.candidates.fmu.description import FmuDescription
from drivegate.candidates.fmu.log import callbacks_2, forget_messages, log_3, with_messages
from drivegate.candidates.fmu.variables import PORTS, Connections
from drivegate_models.contract.current.signals import Command
from drivegate_models.contract.duty.signals import DutyCommand

WARNING: Final = 1
"""The worst status of an FMI function with which a run goes on."""

_FATAL: Final = 4
_STATUSES: Final = ("OK", "Warning", "Discard", "Error", "Fatal", "Pending")


class FmuError(Exception):
    """A function of an FMU reported that it failed."""


class FmuInstance(ABC):
    """An FMU as an object with `reset` and `step`."""

    prefix: ClassVar[str]
    """What the names of the version's functions begin with."""
    set_name: ClassVar[str]
    """The function that sets the inputs."""
    get_name: ClassVar[str]
    """The function that gets the outputs."""

    def __init__(self, description: FmuDescription, slave: Any) -> None:
        connections = description.connections
        fields = PORTS[connections.contract].fields
        inputs = len(connections.signals) + sum(count for _, count in connections.arrays)
        outputs = sum(count for _, count in connections.outputs)
        self.description = description
        self._slave = slave
        self._component: int | None = None
        self._free: weakref.finalize[[int], FmuInstance] | None = None
        self._initialised = False
        self._period = 0.0
        self._signals = [fields.index(name) for name in connections.signals]
        self._answer = _answer_of(connections)
        self._arrays = [fields.index(name) for name, _ in connections.arrays]
        self._input_references = _references(connections.input_references)
        self._output_references = _references(connections.output_references)
        self._inputs = (ctypes.c_double * inputs)()
        self._outputs = (ctypes.c_double * outputs)()
        self._write = Struct(f"={inputs}d").pack_into
        self._read = Struct(f"={outputs}d").unpack_from
        self._ends = ctypes.c_bool()
        self._set_inputs: Callable[[], int]
        self._get_outputs: Callable[[], int]
        self._do_step: Callable[[float, float], int]

    def reset(self, nameplate: AnyNameplate) -> None:
        """Replace the instance by a new one, so that nothing of an earlier run is left in it."""
        self.close()
        forget_messages()
        try:
            self._instantiate(bool(self.description.log_categories))
        except Exception as error:
            raise FmuError(with_messages(f"{self.prefix}Instantiate returned no instance")) from error
        component: int = self._slave.component
        self._component = component
        self._free = weakref.finalize(self, self._freeing_function(), component)
        # At the end of the process its memory goes anyway, and its code may be gone already.
        self._free.atexit = False
        self._initialised = False
        self._period = nameplate.control_period
        self._bind(component)
        with self._failures_reported():
            if self.description.log_categories:
                self._slave.setDebugLogging(True, self.description.log_categories)
            for parameter in self.description.connections.parameters:
                self._set_parameter(
                    parameter.kind, parameter.value_reference, getattr(nameplate, parameter.field)
                )

    def step(self, sense: Any) -> Any:
        """Answer for one control period."""
        if self._component is None:
            raise FmuError(
                "the FMU can be instantiated once in a process, and another instance took this one's place"
            )
        time = sense.time
        arrays = [value for place in self._arrays for value in sense[place]]
        self._write(self._inputs, 0, *[sense[place] for place in self._signals], *arrays)
        if not self._initialised:
            with self._failures_reported():
                self._initialise(time)
            self._initialised = True
        if (status := self._set_inputs()) > WARNING:
            self._fail(self.set_name, status)
        if (status := self._do_step(time, self._period)) > WARNING:
            self._fail(f"{self.prefix}DoStep", status)
        if self._ends.value:
            raise FmuError(with_messages(f"{self.prefix}DoStep requested the end of the simulation"))
        if (status := self._get_outputs()) > WARNING:
            self._fail(self.get_name, status)
        return self._answer(self._read(self._outputs))

    def close(self) -> None:
        """Free the instance, if there is one."""
        self._component = None
        if self._free is not None:
            self._free()
            self._free = None

    @abstractmethod
    def _instantiate(self, with_log: bool) -> None:
        """Have the library make an instance."""

    @abstractmethod
    def _freeing_function(self) -> Callable[[int], None]:
        """Return the function that frees an instance."""

    @abstractmethod
    def _bind(self, component: int) -> None:
        """Make the three calls of a step ready; fmpy's own methods take much longer."""

    @abstractmethod
    def _set_parameter(self, kind: str, value_reference: int, value: float) -> None:
        """Set one parameter."""

    @abstractmethod
    def _initialise(self, time: float) -> None:
        """Go through initialisation with the inputs as they are."""

    def _fail(self, function: str, status: int) -> None:
        """Turn a status into an exception. After a fatal error not even the memory may be freed."""
        if status == _FATAL and self._free is not None:
            self._free.detach()
        name = _STATUSES[status] if status < len(_STATUSES) else str(status)
        raise FmuError(with_messages(f"{function} returned {self.prefix}{name}"))

    @contextmanager
    def _failures_reported(self) -> Iterator[None]:
        from fmpy.fmi1 import FMICallException

        try:
            yield
        except FMICallException as error:
            self._fail(error.function, error.status)


def block_of(references: ctypes.Array[ctypes.c_uint32]) -> tuple[int, int]:
    """Return where value references are, and how many."""
    return ctypes.addressof(references), len(references)


def function_of(library: ctypes.CDLL, name: str, types: tuple[Any, ...]) -> Callable[..., int]:
    """Find a function of an FMU that is called in every step; fmpy's own methods take much longer."""
    function: Callable[..., int] = ctypes.CFUNCTYPE(ctypes.c_int, *types)((name, library))
    return function


def _references(values: tuple[int, ...]) -> ctypes.Array[ctypes.c_uint32]:
    return (ctypes.c_uint32 * len(values))(*values)


_Answer: TypeAlias = Callable[[tuple[float, ...]], Any]
"""From the outputs' values, in the order of the connections, to a Command or a DutyCommand."""


def _answer_of(connections: Connections) -> _Answer:
    """Make what turns the outputs of an FMU into commands."""
    return _ANSWERS[connections.contract](connections)


def _of_angles(_connections: Connections) -> _Answer:
    # The fields of the command are the outputs, in their order.
    return lambda values: Command(*values)


def _of_duty_ratios(connections: Connections) -> _Answer:
    places: dict[str, slice] = {}
    start = 0
    for name, count in connections.outputs:
        places[name] = slice(start, start + count)
        start += count
    arrays = {name: place for name, place in places.items() if name in ("duty_ratios", "legs")}
    scalars = {name: place.start for name, place in places.items() if name not in arrays}

    def answer(values: tuple[float, ...]) -> DutyCommand:
        fields: dict[str, Any] = {name: values[place] for name, place in scalars.items()}
        fields |= {name: values[place] for name, place in arrays.items()}
        if "legs" in fields:
            fields["legs"] = tuple(map(_whole, fields["legs"]))
        if "fault" in fields:
            fields["fault"] = _whole(fields["fault"])
        return DutyCommand(**fields)

    return answer


_ANSWERS: Final = {"current": _of_angles, "duty": _of_duty_ratios}


def _whole(value: float) -> float | int:
    """Make a whole number of a real one; what is none is left for the contract to refuse."""
    return int(value) if value.is_integer() else value


class Fmi2Instance(FmuInstance):
    """An FMU of FMI 2.0 as an object with `reset` and `step`."""

    prefix = "fmi2"
    set_name = "fmi2SetReal"
    get_name = "fmi2GetReal"

    def _instantiate(self, with_log: bool) -> None:
        self._slave.instantiate(callbacks=callbacks_2(), loggingOn=with_log)

    def _freeing_function(self) -> Callable[[int], None]:
        free: Callable[[int], None] = self._slave.fmi2FreeInstance
        return free

    def _bind(self, component: int) -> None:
        values = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p)
        step = (ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_int)
        library = self._slave.dll
        self._set_inputs = partial(
            function_of(library, self.set_name, values),
            component,
            *block_of(self._input_references),
            ctypes.addressof(self._inputs),
        )
        self._get_outputs = partial(
            function_of(library, self.get_name, values),
            component,
            *block_of(self._output_references),
            ctypes.addressof(self._outputs),
        )
        do_step = function_of(library, "fmi2DoStep", step)
        self._do_step = lambda time, period: do_step(component, time, period, 1)

    def _set_parameter(self, kind: str, value_reference: int, value: float) -> None:
        if kind == "Integer":
            self._slave.setInteger([value_reference], [int(value)])
        else:
            self._slave.setReal([value_reference], [float(value)])

    def _initialise(self, time: float) -> None:
        slave = self._slave
        slave.setupExperiment(startTime=time)
        slave.enterInitializationMode()
        if (status := self._set_inputs()) > WARNING:
            self._fail(self.set_name, status)
        slave.exitInitializationMode()


class Fmi3Instance(FmuInstance):
    """An FMU of FMI 3.0 as an object with `reset` and `step`."""

    prefix = "fmi3"
    set_name = "fmi3SetFloat64"
    get_name = "fmi3GetFloat64"

    def _instantiate(self, with_log: bool) -> None:
        self._slave.instantiate(loggingOn=with_log, logMessage=log_3)

    def _freeing_function(self) -> Callable[[int], None]:
        free: Callable[[int], None] = self._slave.fmi3FreeInstance
        return free

    def _bind(self, component: int) -> None:
        values = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t, ctypes.c_void_p, ctypes.c_size_t)
        step = (ctypes.c_void_p, ctypes.c_double, ctypes.c_double, ctypes.c_bool, *(ctypes.c_void_p,) * 4)
        library = self._slave.dll
        self._set_inputs = partial(
            function_of(library, self.set_name, values),
            component,
            *block_of(self._input_references),
            ctypes.addressof(self._inputs),
            len(self._inputs),
        )
        self._get_outputs = partial(
            function_of(library, self.get_name, values),
            component,
            *block_of(self._output_references),
            ctypes.addressof(self._outputs),
            len(self._outputs),
        )
        do_step = function_of(library, "fmi3DoStep", step)
        unused, reached = (ctypes.c_bool * 2)(), ctypes.c_double()
        event, early = ctypes.addressof(unused), ctypes.addressof(unused) + 1
        ends, until = ctypes.addressof(self._ends), ctypes.addressof(reached)
        # Each step writes to their addresses, so they have to live as long as the instance.
        self._results = (unused, reached)
        self._do_step = lambda time, period: do_step(component, time, period, True, event, ends, early, until)

    def _set_parameter(self, kind: str, value_reference: int, value: float) -> None:
        if kind == "Float64":
            self._slave.setFloat64([value_reference], [float(value)])
        elif kind == "Int32":
            self._slave.setInt32([value_reference], [int(value)])
        else:
            self._slave.setInt64([value_reference], [int(value)])

    def _initialise(self, time: float) -> None:
        self._slave.enterInitializationMode(startTime=time)
        if (status := self._set_inputs()) > WARNING:
            self._fail(self.set_name, status)
        self._slave.exitInitializationMode()
