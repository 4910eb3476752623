"""``drivegate bench`` with the rows that it takes drivegate's sources for: yardstick in C, examples, duty ratios.

    python benchmarks/source_bench.py --only yardstick --compare before.json

The options are those of ``drivegate bench``, and so is the document.
"""

from __future__ import annotations

import sys
from functools import partial
from typing import Any, Final

import click

import duty_rates
import duty_yardstick
import example_rates
import peer_ratios
import yardstick_ratio
from drivegate.commands.conduct import Outcome, conducted, wants_json
from drivegate_lab.bench.measurements import SPEEDS_RPM
from drivegate_lab.bench.plan import PYTHON_BAR, RATE_UNIT, Planned, planned, run_setting
from drivegate_lab.commands import bench

PROGRAM: Final = "python benchmarks/source_bench.py"
YARDSTICK_BAR: Final = 1.2
"""Time over that of the same algorithm in C that the closed loop is meant to stay below."""
EXAMPLE_BAR: Final = 1.3
"""Time of a run with a compiled candidate over that with the built-in reference."""

DUTY_BARS: Final = {"ideal": 120.0, "dead-time": 100.0}
"""Rate that the loop of duty ratios is meant to reach with each bridge."""
EXPORT_BAR: Final = 7.0
"""Times the rate of motulator-export's bare loop that it is meant to reach on the same drive."""
MOTULATOR_BAR: Final = 2000.0
"""The same of motulator."""


def source_rows(*, quick: bool) -> tuple[Planned, ...]:
    """List what can be measured in the sources alone."""
    return (*_yardsticks(quick), *_examples(quick), *_duty_loops(quick), *_peers(quick))


def _yardsticks(quick: bool) -> list[Planned]:
    titles = {"initial": "initial against all of it in C", "reference": "reference against its plant in C"}
    duty = Planned(
        "yardstick.foc",
        "foc on a PM AC drive against its plant in C",
        f"{duty_yardstick.SIMULATED * (0.5 if quick else 1.0):g} s at a control period of 0.1 ms",
        "× its time",
        "less",
        YARDSTICK_BAR,
        duty_yardstick.yardstick_ratio,
    )
    loops = [
        Planned(
            f"yardstick.{candidate}.{speed}",
            f"{title}, {speed} rpm",
            run_setting(yardstick_ratio.SIMULATED, quick),
            "× its time",
            "less",
            YARDSTICK_BAR,
            partial(yardstick_ratio.yardstick_ratio, candidate=candidate, speed_rpm=speed),
        )
        for candidate, title in titles.items()
        for speed in SPEEDS_RPM
    ]
    return [*loops, duty]


def _examples(quick: bool) -> list[Planned]:
    setting = run_setting(example_rates.SIMULATED, quick)
    compiled = [
        Planned(
            f"example.{language}",
            f"examples/{language} against the built-in reference, 1500 rpm",
            setting,
            "× its time",
            "less",
            EXAMPLE_BAR,
            partial(example_rates.example_ratio, language=language),
        )
        for language in ("c", "numba", "rust")
    ]
    python = Planned(
        "example.python",
        "examples/python, 1500 rpm",
        setting,
        RATE_UNIT,
        "more",
        PYTHON_BAR,
        example_rates.python_example_rate,
    )
    return [*compiled, python]


def _duty_loops(quick: bool) -> list[Planned]:
    titles = {"ideal": "foc on a PM AC drive, ideal switches", "dead-time": "the same with 2 µs dead time"}
    simulated = duty_rates.SIMULATED * (0.5 if quick else 1.0)
    return [
        Planned(
            f"duty.foc.{bridge}",
            title,
            f"{simulated:g} s at a control period of 0.1 ms",
            RATE_UNIT,
            "more",
            DUTY_BARS[bridge],
            partial(duty_rates.duty_rate, bridge=bridge),
        )
        for bridge, title in titles.items()
    ]


def _peers(quick: bool) -> list[Planned]:
    """List the loop of duty ratios beside those of others, on the drive of 2.2 kW."""
    setting = f"{peer_ratios.SIMULATED * (0.5 if quick else 1.0):g} s at a control period of 0.125 ms"
    unit = "× its rate"
    bridges = {"ideal": "ideal switches", "dead-time": "2 µs dead time in both"}
    against_export = [
        Planned(
            f"peer.export.{bridge}",
            f"foc against motulator-export's bare loop, {words}",
            setting,
            unit,
            "more",
            EXPORT_BAR,
            partial(peer_ratios.export_ratio, bridge=bridge),
        )
        for bridge, words in bridges.items()
    ]
    turns = f"{peer_ratios.slow_turns(quick)} of each"
    motulator = Planned(
        "peer.motulator",
        "foc against motulator",
        f"{setting}, {turns}",
        unit,
        "more",
        MOTULATOR_BAR,
        peer_ratios.motulator_ratio,
    )
    same = Planned(
        "peer.same",
        "motulator's flux-vector control on both plants",
        f"0.5 s at a control period of 0.125 ms, {turns}",
        unit,
        "more",
        None,
        peer_ratios.same_controller_ratio,
    )
    return [*against_export, motulator, same]


@click.command(params=bench.command.params)
def command(*, quick: bool, cold: bool, **options: Any) -> Outcome:
    """Measure how fast drivegate is on this machine, also beside the same loop in C and with the examples."""
    plan = (*planned(quick=quick, cold=cold), *source_rows(quick=quick))
    return bench.bench_outcome(PROGRAM, plan, quick=quick, cold=cold, **options)


if __name__ == "__main__":
    sys.exit(conducted(lambda: command.main(standalone_mode=False), as_json=wants_json(sys.argv[1:])))
