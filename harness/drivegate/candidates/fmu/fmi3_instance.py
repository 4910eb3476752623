"""An FMU of FMI 3.0, through the functions of that version."""

import ctypes
from collections.abc import Callable
from functools import partial

from drivegate.candidates.fmu.instance import WARNING, FmuInstance, block_of, function_of
from drivegate.candidates.fmu.log import log_3


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
