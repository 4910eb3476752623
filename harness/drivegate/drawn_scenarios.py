"""Scenarios drawn by Hypothesis, as integer steps from nominal, so that they shrink and print well."""

from __future__ import annotations

from hypothesis import strategies as st

from drivegate.fixed_scenarios import base_speed_scenario, steady_scenario
from drivegate_cases.motor import Motor
from drivegate_cases.scenario import Scenario

SPEED_STEP_RPM = 10
"""Step of drawn speeds (rpm)."""
LOWEST_LOADED_RPM = 550
"""Lowest speed of a loaded run; with less the reference motor cannot be started under rated power (rpm)."""
HIGHEST_LOADED_RPM = 1500
"""Highest speed of a loaded run (rpm)."""
LOAD_STEP = 0.05
"""Step of drawn loads, as a share of rated power (1)."""


def _loaded_speeds() -> st.SearchStrategy[float]:
    """Draw a speed (rpm), simplest at the highest."""
    steps = (HIGHEST_LOADED_RPM - LOWEST_LOADED_RPM) // SPEED_STEP_RPM
    return st.integers(0, steps).map(lambda slower: float(HIGHEST_LOADED_RPM - SPEED_STEP_RPM * slower))


def steady_scenarios(motor: Motor) -> st.SearchStrategy[Scenario]:
    """Draw runs at one speed under one load.

    Parameters
    ----------
    motor : Motor
        The motor.

    Returns
    -------
    SearchStrategy
        Of scenarios from 550 to 1500 rpm and from 10 % to all of rated power; simplest at 1500 rpm and rated
        power.
    """
    return st.builds(
        lambda speed, lighter, constant_power: steady_scenario(
            motor,
            speed,
            power_share=round(1.0 - LOAD_STEP * lighter, 2),
            constant_power=constant_power,
        ),
        _loaded_speeds(),
        st.integers(0, 18),
        st.booleans(),
    )


def constant_power_scenarios(motor: Motor) -> st.SearchStrategy[Scenario]:
    """Draw runs at rated power.

    Parameters
    ----------
    motor : Motor
        The motor.

    Returns
    -------
    SearchStrategy
        Of scenarios from 550 to 1500 rpm.
    """
    return st.builds(
        lambda speed: steady_scenario(motor, speed, power_share=1.0, constant_power=True), _loaded_speeds()
    )


def base_speed_scenarios(motor: Motor) -> st.SearchStrategy[Scenario]:
    """Draw unloaded runs through base speed.

    Parameters
    ----------
    motor : Motor
        The motor.

    Returns
    -------
    SearchStrategy
        Of scenarios that start 5 to 400 rpm below base speed, go 5 to 40 rpm above it, and come down by 4 to
        10 rpm/s, slower than the unloaded shaft coasts.
    """
    return st.builds(
        lambda below, above, fall: base_speed_scenario(
            motor, motor.base_speed_rpm - 5.0 * below, motor.base_speed_rpm + 5.0 * above, float(fall)
        ),
        st.integers(1, 80),
        st.integers(1, 8),
        st.integers(4, 10),
    )


def drawn_scenarios(motor: Motor) -> st.SearchStrategy[Scenario]:
    """Draw a scenario of any family.

    Parameters
    ----------
    motor : Motor
        The motor.

    Returns
    -------
    SearchStrategy
        Of scenarios.
    """
    return st.one_of(steady_scenarios(motor), constant_power_scenarios(motor), base_speed_scenarios(motor))
