"""What is not a number never passes for a balance of energy."""

from __future__ import annotations

from math import inf, nan

import numpy as np
import pytest

from drivegate_models.compilation.kernels import kernel
from drivegate_models.loop.observation import empty_run
from drivegate_models.loop.observing import observe_energy
from drivegate_models.machine import ledger
from drivegate_models.pm_ac.loop_kernel import _balance

pytestmark = pytest.mark.kernel


@kernel
def _observe(run, after, period):
    observe_energy(run[0], 1.0, 1.0, 0.0, after, period)


@kernel
def _missing(growth, stored, period):
    return _balance(1.0, 1.0, growth, stored, 1.0, period)


@pytest.mark.parametrize("entry", [ledger.EXCHANGED, ledger.SQUARE, ledger.IMPULSE])
def test_an_entry_that_is_not_a_number_breaks_the_balance_for_good(entry: int) -> None:
    # As attributes, also where compilation is switched off.
    run, period = empty_run().view(np.recarray), np.zeros(ledger.ENTRIES)
    period[ledger.EXCHANGED] = period[ledger.IMPULSE] = 1.0
    _observe(run, 0.0, period)
    assert run["exchange_error"][0] == 0.0
    broken = period.copy()
    broken[entry] = nan
    _observe(run, 0.0, broken)
    _observe(run, 0.0, period)
    assert run["exchange_error"][0] == inf


@pytest.mark.parametrize("entry", [ledger.EXCHANGED, ledger.SQUARE, ledger.IMPULSE, ledger.UPPER])
def test_an_entry_that_is_not_a_number_breaks_the_balance_of_duty_ratios(entry: int) -> None:
    period = np.zeros(ledger.ENTRIES)
    period[ledger.EXCHANGED] = period[ledger.IMPULSE] = period[ledger.UPPER] = 1.0
    assert _missing(0.0, 1.0, period) == 0.0
    period[entry] = nan
    assert not _missing(0.0, 1.0, period) <= 1e-9
