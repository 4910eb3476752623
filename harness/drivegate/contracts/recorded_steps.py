"""The steps of a run as sensed and answered, recorded to the last bit whatever the contract."""

from __future__ import annotations

from typing import Any

from numpy.typing import NDArray

from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import Fault
from drivegate_models.loop.step_recording import recorder_of, recording_step


class RecordingController:
    """A controller that records every step of another one, which has been reset.

    Attributes
    ----------
    step_address, state_address : int
        Addresses of the recorder's step and of its state; valid as long as this object lives.
    """

    def __init__(self, inner: Controller, rows: NDArray[Any]) -> None:
        """Record into rows of `drivegate_models.loop.step_recording.row_layout`."""
        self._inner = inner
        self._rows = rows
        self._recorder = recorder_of(rows, inner.step_address, inner.state_address)
        self._step = recording_step()
        self.step_address: int = self._step.address
        self.state_address: int = self._recorder.ctypes.data

    @property
    def fault(self) -> Fault | None:
        """What ended the last run, if the inner controller knows."""
        return self._inner.fault

    @property
    def steps(self) -> int:
        """Number of steps that are recorded."""
        return int(self._recorder[0]["count"])

    def reset(self, nameplate: Any) -> None:
        """Reset the inner controller."""
        self._inner.reset(nameplate)
        # A reset may make another controller.
        self._recorder[0]["step_address"] = self._inner.step_address
        self._recorder[0]["state_address"] = self._inner.state_address
