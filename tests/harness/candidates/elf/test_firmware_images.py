"""One firmware, linked in four styles, answers the same: by registers, in a HAL project, and in a super-loop."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import own_candidate
from drivegate.contracts.duty.scenarios.building import torque_scenario
from drivegate.drives.running import recorded
from drivegate_cases.drive.drive_document import load_drive

pytestmark = pytest.mark.needs("arm-none-eabi-gcc")

FOLDER = Path(__file__).parents[4] / "examples" / "firmware" / "interrupt"
SCENARIO = torque_scenario(load_drive("pm-ac-interior"), 1000.0, (1.5,)).model_copy(
    update={"duration_s": 0.02}
)


def torque_of(folder: Path, manifest: str, debug: str = "-g") -> NDArray[np.float64]:
    """Build an image with given debug information, run it for some control periods, and return the torque."""
    shutil.copytree(FOLDER, folder, ignore=shutil.ignore_patterns("*.elf"))
    makefile = folder / "Makefile"
    text = makefile.read_text(encoding="utf-8")
    assert text.count("DEBUG = -g\n") == 1
    makefile.write_text(text.replace("DEBUG = -g\n", f"DEBUG = {debug}\n"), encoding="utf-8")
    candidate = resolve_candidate(str(folder / manifest))
    loaded = own_candidate(candidate)
    column: NDArray[np.float64] = recorded(loaded, SCENARIO, loaded.controller()).run.column("torque")
    return column


@pytest.fixture(scope="module")
def by_registers(tmp_path_factory: pytest.TempPathFactory) -> NDArray[np.float64]:
    torque = torque_of(tmp_path_factory.mktemp("registers") / "made", "registers.toml")
    assert torque[-1] > 1.0, "it runs"
    return torque


@pytest.mark.one_in(2)
@pytest.mark.parametrize(
    ("manifest", "debug"),
    [
        ("hal.toml", "-gdwarf-2"),
        ("hal.toml", "-gdwarf-3"),
        ("hal.toml", "-gdwarf-4"),
        ("loop.toml", "-gdwarf-5"),
    ],
)
def test_a_project_with_a_vendors_linker_script_answers_as_its_control_alone(
    by_registers: NDArray[np.float64], tmp_path: Path, manifest: str, debug: str
) -> None:
    assert np.array_equal(torque_of(tmp_path / "made", manifest, debug), by_registers)
