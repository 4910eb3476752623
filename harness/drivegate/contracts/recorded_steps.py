"""The steps of a run as sensed and answered, recorded to the last bit whatever the contract."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from drivegate.candidates.controller import CompiledController, Controller
from drivegate.candidates.fault import Fault
from drivegate_models.loop.step_recording import recorder_of, recording_step


class RecordingController(CompiledController):
    """A controller that records every step of another one, which has been reset."""

    def __init__(self, inner: Controller, rows: NDArray[Any]) -> None:
        """Record into rows of `drivegate_models.loop.step_recording.row_layout`."""
        super().__init__(recording_step(), recorder_of(rows, inner.step_address, inner.state_address))
        self._inner = inner
        self._rows = rows

    @property
    def fault(self) -> Fault | None:
        """What ended the last run, if the inner controller knows."""
        return self._inner.fault

    @property
    def steps(self) -> int:
        """Number of steps that are recorded."""
        return int(self._state[0]["count"])

    def reset(self, nameplate: Any) -> None:
        """Reset the inner controller."""
        self._inner.reset(nameplate)
        # A reset may make another controller.
        self._state[0]["step_address"] = self._inner.step_address
        self._state[0]["state_address"] = self._inner.state_address
