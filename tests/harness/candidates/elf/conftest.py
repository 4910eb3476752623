"""Images that a test links from a source and maps by a manifest."""

from __future__ import annotations

import ctypes
import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from drivegate.candidates.elf.loading import TargetController
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.resolution import resolve_candidate
from drivegate.contracts.duty.run import duty_nameplate
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate_cases.drive.drive_document import load_drive
from drivegate_models.contract.duty.records import duty_command_record, duty_sense_record

NAMEPLATE = duty_nameplate(torque_scenario(load_drive("pm-ac-surface"), 100.0, (0.0,)))
TARGET = ("-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-nostartfiles", "-Wl,-e,0")
PLACES = ("-Wl,-Ttext=0x08000000", "-Wl,-Tdata=0x20000000")
DUTIES = {f"duty_ratios[{leg}]": 0.5 for leg in range(3)}


class Loaded:
    """A controller, and its steps."""

    def __init__(self, controller: TargetController, file: Path) -> None:
        self.controller, self.file = controller, file
        self._step = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)(controller.step_address)

    def reset(self) -> Loaded:
        self.controller.reset(NAMEPLATE)
        return self

    def step(self, **sensed: float) -> Any:
        sense, command = duty_sense_record(np.array([1.0, -2.0, 1.0])), duty_command_record()
        for name, value in sensed.items():
            sense[name] = value
        self._step(self.controller.state_address, sense.ctypes.data, command.ctypes.data)
        return command[0]

    @property
    def fault(self) -> str:
        """The message of what ended the last step; empty where it came to its end."""
        fault = self.controller.fault
        return "" if fault is None else fault.message


Load = Callable[..., Loaded]


@pytest.fixture
def load(tmp_path: Path) -> Load:
    """Link a source with further flags, and load it by a manifest with further keys and tables."""

    def loaded(
        source: str,
        flags: tuple[str, ...] = ("-O1", "-g"),
        places: tuple[str, ...] = PLACES,
        suffix: str = "elf",
        **keys: object,
    ) -> Loaded:
        (tmp_path / "mine.c").write_text(source, encoding="utf-8")
        # Images are read once by their names.
        image = f"{len([*tmp_path.iterdir()])}{suffix and '.'}{suffix}"
        command = ["arm-none-eabi-gcc", *TARGET, *flags, *places, "-o", image, "mine.c"]
        subprocess.run(command, cwd=tmp_path, check=True, capture_output=True)
        keys = {"step": "isr", "read": DUTIES, **keys}
        tables = {key: value for key, value in keys.items() if isinstance(value, dict)}
        lines = [
            'schema = 1\nname = "mine"\nkind = "elf"\ncontract = "duty"',
            f'entry = "{image}"',
            *(f"{key} = {json.dumps(value)}" for key, value in keys.items() if key not in tables),
        ]
        for name, table in tables.items():
            lines += [
                f"[{name}]",
                *(f"{json.dumps(key)} = {_written(value)}" for key, value in table.items()),
            ]
        manifest = tmp_path / "candidate.toml"
        manifest.write_text("\n".join(lines), encoding="utf-8")
        controller = load_controller(resolve_candidate(str(manifest)))
        assert isinstance(controller, TargetController)
        return Loaded(controller, tmp_path / image)

    return loaded


def _written(value: object) -> str:
    if not isinstance(value, dict):
        return json.dumps(value)
    return f"{{ {', '.join(f'{json.dumps(key)} = {_written(each)}' for key, each in value.items())} }}"
