"""The closed loop against the same algorithm by hand in C at -O3: in lock-step, and how much slower."""

import time
from pathlib import Path
from typing import Any

import pytest

from drivegate.studies.bench.loop_rates import YARDSTICK_SIMULATED, yardstick_ratio
from drivegate.studies.bench.plan import YARDSTICK_BAR
from drivegate.studies.bench.workbench import Workbench, operating_scenario

# One core's own time, whatever else the machine does.
pytestmark = pytest.mark.benchmark(timer=time.process_time)

FOLDER = Path(__file__).parent / "c_yardstick"


@pytest.mark.parametrize("speed", [500, 1000, 1500, 2000])
@pytest.mark.parametrize("candidate", ["initial", "reference"])
def test_yardstick(benchmark: Any, tmp_path: Path, candidate: str, speed: int) -> None:
    bench = Workbench(tmp_path, quick=False, yardstick_folder=FOLDER)
    ratio = yardstick_ratio(bench, candidate, speed)
    assert ratio.checked.valid, f"not in step: {ratio.checked.told}"
    own = None if candidate == "initial" else bench.controller(candidate)
    prepared = bench.yardstick().prepared(operating_scenario(speed, "ideal", YARDSTICK_SIMULATED), own)
    benchmark.pedantic(prepared, rounds=5)
    benchmark.extra_info["drivegate_over_c"] = round(ratio.value, 3)
    assert ratio.value <= YARDSTICK_BAR, f"{ratio.value:.2f} × the time of C, above {YARDSTICK_BAR} ×"
