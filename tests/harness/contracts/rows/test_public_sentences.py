"""Sentences of public requirement lists as rows, each judged on runs that meet it and runs that miss it.

Twenty sentences: of the functional safety of drives (IEC 61800-5-2), of rotating machines (IEC 60034-1), of pedal
assistance (Directive 2002/24/EC, EN 15194), and as data sheets of servo drives state them. Three need a position or a
temperature, which no run shows, and are no rows.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from tests.harness.contracts.rows.synthetic import INTERIOR, judged, row, times_of

from drivegate.contracts.duty.scenarios.building import (
    failing,
    load_step_scenario,
    speed_scenario,
    torque_scenario,
)
from drivegate.scenarios.changes import with_supply
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_cases.scenario.scenario import Scenario

assert isinstance(INTERIOR, PmAcDocument)
BASE = INTERIOR.rating.base_speed_rpm
TORQUE = INTERIOR.rating.rated_torque_nm
CURRENT = INTERIOR.rating.current_limit_a
STEP = load_step_scenario(INTERIOR, 1000.0, 1.0, (0.0, 1.0))
LOADED_S = next(time for time, share in STEP.load_profile if share == 1.0)
SPEED = speed_scenario(INTERIOR, (1000.0,))
START = speed_scenario(INTERIOR, (200.0,), initial_speed_rpm=0.0)
RELEASE = torque_scenario(INTERIOR, 500.0, (1.0, 0.0))
RELEASED_S = next(time for time, torque in RELEASE.torque_reference_profile if torque == 0.0)
HELD = torque_scenario(INTERIOR, 500.0, (0.0, TORQUE))
STEPPED_S = HELD.torque_reference_profile[-1][0]
BROKEN = failing(SPEED, "stuck-current", 0.05)
DROPPED = with_supply(STEP, ((0.0, 1.0), (LOADED_S, 1.0), (LOADED_S, 0.9))).replaced(load=SPEED.load)


def from_on(scenario: Scenario, time_s: float, before: Any, after: Any) -> np.ndarray:
    """Return a signal that changes at once."""
    return np.where(times_of(scenario) >= time_s - 1e-9, after, before)


def ramp(scenario: Scenario, slope: float) -> np.ndarray:
    return slope * times_of(scenario)


@dataclass(frozen=True)
class Sentence:
    """A sentence with its row and two runs, or without a row where none can say it."""

    source: str
    text: str
    scenario: Scenario = SPEED
    row: dict[str, Any] | None = None
    meets: dict[str, Any] = field(default_factory=dict)
    misses: dict[str, Any] = field(default_factory=dict)


EPAC, SAFETY, MACHINES, SERVO = (
    "Directive 2002/24/EC, EN 15194",
    "IEC 61800-5-2",
    "IEC 60034-1",
    "servo data sheet",
)
SENTENCES = (
    Sentence(
        EPAC,
        "The motor has a maximum continuous rated power of 0.25 kW.",
        SPEED,
        {"quantity": "shaft_power_w", "statistic": "mean", "for_s": 0.1, "at_most": 250.0},
        {"torque_nm": 2.0, "speed_rpm": 1000.0},
        {"torque_nm": 3.0, "speed_rpm": 1000.0},
    ),
    Sentence(
        EPAC,
        "Its output is finally cut off as the vehicle reaches 25 km/h.",
        SPEED,
        {"when": {"speed_rpm": (1500.0, 1e4)}, "quantity": "torque_nm", "at_most": 0.02},
        {"speed_rpm": ramp(SPEED, 3e4), "torque_nm": np.where(ramp(SPEED, 3e4) < 1490.0, 1.0, 0.0)},
        {"speed_rpm": ramp(SPEED, 3e4), "torque_nm": np.where(ramp(SPEED, 3e4) < 1700.0, 1.0, 0.0)},
    ),
    Sentence(
        EPAC,
        "It is cut off sooner if the cyclist stops pedalling: within 50 ms.",
        RELEASE,
        {
            "when": {"event": "step of torque reference", "torque_reference_nm": (0.0, 0.0)},
            "between_s": (0.05,),
            "quantity": "torque_nm",
            "statistic": "absolute",
            "at_most": 0.05,
        },
        {"torque_nm": from_on(RELEASE, RELEASED_S + 0.04, 1.0, 0.0)},
        {"torque_nm": from_on(RELEASE, RELEASED_S + 0.06, 1.0, 0.0)},
    ),
    Sentence(
        EPAC,
        "The start-up assistance goes up to 6 km/h.",
        START,
        {"when": "start", "quantity": "speed_rpm", "at_most": 220.0},
        {"speed_rpm": 210.0},
        {"speed_rpm": 230.0},
    ),
    Sentence(
        SAFETY,
        "STO: power that can cause rotation is not applied to the motor.",
        BROKEN,
        {
            "when": "failure",
            "between_s": (0.01,),
            "quantity": "peak_current_a",
            "at_most": 0.1,
        },
        {"peak_current_a": from_on(BROKEN, 0.058, 5.0, 0.0)},
        {"peak_current_a": from_on(BROKEN, 0.07, 5.0, 0.0)},
    ),
    Sentence(
        SAFETY,
        "SLS: the motor does not exceed the specified speed limit.",
        SPEED,
        {"quantity": "speed_rpm", "statistic": "absolute", "at_most": 1100.0},
        {"speed_rpm": -1050.0},
        {"speed_rpm": -1150.0},
    ),
    Sentence(
        SAFETY,
        "SSR: the motor speed is kept within specified limits.",
        STEP,
        {"when": "step of load", "quantity": "speed_rpm", "within": (900.0, 1100.0)},
        {"speed_rpm": from_on(STEP, LOADED_S, 1000.0, 950.0)},
        {"speed_rpm": from_on(STEP, LOADED_S, 1000.0, 850.0)},
    ),
    Sentence(
        SAFETY,
        "SLT: the motor does not exceed the specified torque.",
        SPEED,
        {"quantity": "torque_percent", "statistic": "absolute", "at_most": 120.0},
        {"torque_nm": -1.1 * TORQUE},
        {"torque_nm": -1.3 * TORQUE},
    ),
    Sentence(
        SAFETY,
        "STR: the motor torque is kept within specified limits.",
        HELD,
        {
            "when": "step of torque reference",
            "between_s": (0.01,),
            "quantity": "torque_nm",
            "within": (0.9 * TORQUE, 1.1 * TORQUE),
        },
        {"torque_nm": from_on(HELD, STEPPED_S + 0.005, 0.0, TORQUE)},
        {"torque_nm": from_on(HELD, STEPPED_S + 0.015, 0.0, TORQUE)},
    ),
    Sentence(
        SAFETY,
        "SLA: the motor does not exceed the specified acceleration limit.",
        START,
        {"quantity": "acceleration_rpm_per_s", "statistic": "absolute", "at_most": 5000.0},
        {"speed_rpm": ramp(START, 4000.0)},
        {"speed_rpm": ramp(START, -6000.0)},
    ),
    Sentence(
        SAFETY,
        "SDI: the shaft does not move in the unintended direction.",
        START,
        {"quantity": "speed_rpm", "at_least": -1.0},
        {"speed_rpm": ramp(START, 100.0)},
        {"speed_rpm": ramp(START, -100.0)},
    ),
    Sentence(SAFETY, "SOS: the motor does not deviate from the stopped position by a defined amount."),
    Sentence(SAFETY, "SLI: the shaft does not exceed the specified limit of position increment."),
    Sentence(SAFETY, "SMT: the motor's temperature does not exceed its upper limit."),
    Sentence(
        MACHINES,
        "The motor withstands an excess torque of 60 % without stalling or abrupt change in speed.",
        load_step_scenario(INTERIOR, 1000.0, 1.6 * TORQUE, (0.0, 1.0)),
        {
            "when": {"event": "step of load", "step_percent": (155.0, 165.0)},
            "quantity": "speed_deviation_percent",
            "statistic": "peak",
            "at_most": 20.0,
        },
        {"speed_reference_rpm": 1000.0, "speed_rpm": 1000.0 - 0.15 * BASE},
        {"speed_reference_rpm": 1000.0, "speed_rpm": 1000.0 - 0.25 * BASE},
    ),
    Sentence(
        SERVO,
        "Speed fluctuation: 0.01 % of rated speed at most for a load fluctuation of 0 to 100 %.",
        STEP,
        {
            "when": "step of load",
            "between_settling_times": (1.0,),
            "quantity": "speed_deviation_percent",
            "statistic": "mean",
            "within": (-0.01, 0.01),
        },
        {"speed_reference_rpm": 1000.0, "speed_rpm": 1000.0 - 0.5e-4 * BASE},
        {"speed_reference_rpm": 1000.0, "speed_rpm": 1000.0 - 1.5e-4 * BASE},
    ),
    Sentence(
        SERVO,
        "Speed fluctuation: 0 % of rated speed for a voltage fluctuation of 10 %.",
        DROPPED,
        {
            "when": {"event": "step of link", "step_percent": (-11.0, 11.0)},
            "between_mechanical_times": (0.1,),
            "quantity": "speed_deviation_percent",
            "statistic": "absolute",
            "at_most": 0.05,
        },
        {"speed_reference_rpm": 1000.0, "speed_rpm": 1000.0},
        {"speed_reference_rpm": 1000.0, "speed_rpm": 1000.0 + 1e-3 * BASE},
    ),
    Sentence(
        SERVO,
        "Torque control precision: 1 %.",
        HELD,
        {
            "when": "step of torque reference",
            "between_s": (0.02,),
            "for_s": 0.01,
            "quantity": "torque_deviation_nm",
            "statistic": "mean",
            "within": (-0.01 * TORQUE, 0.01 * TORQUE),
        },
        {"torque_reference_nm": TORQUE, "torque_nm": 0.995 * TORQUE},
        {"torque_reference_nm": TORQUE, "torque_nm": 0.985 * TORQUE},
    ),
    Sentence(
        SERVO,
        "The maximum current flows for 30 ms at most.",
        SPEED,
        {"quantity": "current_percent", "for_s": 0.03, "at_most": 50.0},
        {"direct_current_a": from_on(SPEED, 0.02, CURRENT, 0.0)},
        {"direct_current_a": from_on(SPEED, 0.04, CURRENT, 0.0)},
    ),
    Sentence(
        SERVO,
        "The speed settles with two crossings at most, and does not hunt.",
        STEP,
        {
            "when": "step of load",
            "quantity": "speed_deviation_rpm",
            "statistic": "sign changes",
            "at_most": 2,
        },
        {"speed_rpm": np.where(np.abs(times_of(STEP) - LOADED_S - 0.02) < 0.01, 10.0, -10.0)},
        {"speed_rpm": np.where((times_of(STEP) * 100.0) % 2.0 < 1.0, 10.0, -10.0)},
    ),
)


def test_there_are_twenty_sentences_and_most_are_rows() -> None:
    assert len(SENTENCES) == 20
    assert sum(sentence.row is not None for sentence in SENTENCES) >= 17


@pytest.mark.parametrize("place", [place for place, one in enumerate(SENTENCES) if one.row is not None])
def test_a_sentence_tells_a_run_that_meets_it_from_one_that_misses_it(place: int) -> None:
    sentence = SENTENCES[place]
    one = row(text=sentence.text, **(sentence.row or {}))
    met, missed = (judged(one, sentence.scenario, **signals) for signals in (sentence.meets, sentence.misses))
    assert met is not None, sentence.text
    assert missed is not None, sentence.text
    assert met.met, (sentence.text, met)
    assert not missed.met, (sentence.text, missed)
