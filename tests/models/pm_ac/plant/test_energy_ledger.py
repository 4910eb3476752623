"""Energy closes for any PM AC drive and any schedule of its gates, and no event is awaited for ever."""

from __future__ import annotations

import pytest
from tests.models.pm_ac.plant.drawn_periods import check_energy, drawn_run

CLOSURE = 1e-9
"""Greatest part of the throughput that may be missing."""


def check(seeds: range) -> None:
    missing = {seed: check_energy(drawn_run(seed)) for seed in seeds}
    worst = max(missing, key=missing.__getitem__)
    assert missing[worst] <= CLOSURE, f"run {worst} misses {missing[worst]:.1e} of its throughput"


@pytest.mark.kernel
def test_energy_closes_for_some_drawn_drives() -> None:
    check(range(60))


def test_energy_closes_for_thousands_of_drawn_drives() -> None:
    check(range(60, 4000))


@pytest.mark.kernel
def test_energy_closes_on_a_link_below_the_drop_of_the_switches() -> None:
    """Driven legs then lie beyond both rails, which every bound of the voltages has to know."""
    run = drawn_run(5621)
    assert run.link < run.drive.switch_drop
    check(range(5621, 5622))
