"""What is measured, and how some of it is chosen."""

import pytest

from drivegate.drives.kinds import DRIVE_KINDS
from drivegate_lab.bench.plan import chosen, planned
from drivegate_models.errors import InputError

PLAN = planned(quick=False, cold=True)
NAMES = [one.name for one in PLAN]


def test_every_candidate_speed_and_sensor_is_measured():
    assert len(set(NAMES)) == len(NAMES)
    loops = {name for name in NAMES if name.startswith("loop.")}
    assert loops == {
        f"loop.{candidate}.{speed}.{sensors}"
        for candidate in ("reference", "numba", "c", "python", "exec")
        for speed in (500, 1000, 1500, 2000)
        for sensors in ("ideal", "mcs96")
    }
    others = {"steady.band", "steady.ideal", "oracle.least-sum", "start.help"}
    others |= {f"gate.{state}.{kind}" for state in ("warm", "cold") for kind in DRIVE_KINDS}
    others |= {"start.import", "memory.run", "overhead.python"}
    others |= {"star.loop.500", "star.loop.1000", "star.loop.1500", "star.steady"}
    assert others <= set(NAMES)


def test_bars_are_those_of_the_design():
    bars = {one.name: one.bar for one in PLAN if one.bar is not None}
    assert bars["loop.reference.1500.ideal"] == 300.0
    assert bars["loop.python.1500.ideal"] == 50.0
    assert bars["star.loop.1000"] == 300.0
    assert bars["star.steady"] == 50_000.0
    assert bars["loop.exec.1500.ideal"] == 3.0
    assert bars["overhead.python"] == 5.0
    assert bars["steady.band"] == bars["steady.ideal"] == 50_000.0
    gates = (bars["gate.warm.half-bridge"], bars["gate.cold.pm-ac"])
    assert (*gates, bars["start.help"]) == (60.0, 120.0, 0.3)
    assert bars["start.import"] == 0.15


def test_the_cold_gate_is_measured_only_where_requested():
    asked = set(NAMES) - {one.name for one in planned(quick=False, cold=False)}
    assert asked == {name for name in NAMES if name.startswith("gate.")} - {"gate.warm.half-bridge"}


def test_quick_work_is_another_setting():
    quick = {one.name: one.setting for one in planned(quick=True, cold=True)}
    same = {one.name for one in PLAN if quick[one.name] == one.setting}
    assert same == {"oracle.least-sum", "start.help", "start.import", "memory.run"}


@pytest.mark.parametrize(
    ("names", "count"),
    [((), len(NAMES)), (("loop.c",), 8), (("loop.c.500.ideal", "steady"), 3), (("loop",), 40)],
)
def test_rows_are_chosen_by_name_or_group(names, count):
    assert len(chosen(PLAN, names)) == count


def test_an_unknown_name_is_refused_with_the_nearest():
    with pytest.raises(
        InputError, match=r"'lop' names nothing .* nearest is 'loop'; there are loop, overhead, steady"
    ):
        chosen(PLAN, ("loop", "lop"))
    with pytest.raises(InputError, match="names nothing"):
        chosen(PLAN, ("loo",))
