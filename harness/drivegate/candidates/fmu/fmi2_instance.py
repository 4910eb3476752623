"""An FMU of FMI 2.0, through the functions of that version."""

import ctypes
from collections.abc import Callable
from functools import partial

from drivegate.candidates.fmu.instance import WARNING, FmuInstance, block_of, function_of
from drivegate.candidates.fmu.log import callbacks_2


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
