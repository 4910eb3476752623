"""The table `[link]`: what it refuses, in one sentence each, and what follows from what it leaves out."""

from __future__ import annotations

import re
from typing import Any

import pytest

from drivegate_cases.drive.drive_document import load_drive
from drivegate_cases.drive.pm_ac.document import PmAcDocument
from drivegate_models.errors import InputError
from drivegate_models.pm_ac.plant.dc_link import BATTERY, RECTIFIER, DcLink

HUB = load_drive("pm-ac-hub")
CHOPPER = load_drive("pm-ac-chopper")
OWN: dict[str, Any] = {"capacitance_f": 1e-3, "source_resistance_ohm": 0.1}


def with_link(drive: Any, **link: Any) -> PmAcDocument:
    changed = drive.replaced(link={key: value for key, value in link.items() if value is not None})
    assert isinstance(changed, PmAcDocument)
    return changed


def changed_link(drive: Any, **changes: Any) -> PmAcDocument:
    return with_link(drive, **(drive.to_mapping()["link"] | changes))


@pytest.mark.parametrize(
    ("drive", "changes", "message"),
    [
        (HUB, {"capacitance_f": None}, "'capacitance_f' is missing, but source = \"battery\" requires it"),
        (HUB, {"source": "ideal"}, "is for a link with a capacitor; state source"),
        (HUB, {"charge_limit_a": -8.0}, "must be at least 0: it is the size of the current"),
        (HUB, {"source_inductance_h": 1e-9}, "of 6.25e-05 s; leave the inductance out"),
        (HUB, {"source_inductance_h": 20.0}, "in henries, 20 µH are 2e-05"),
        (
            HUB,
            {"source_inductance_h": 0.02},
            "oscillates with its source by itself at the rated power of 250 W",
        ),
        (HUB, {"charge_limit_a": 0.0}, 'state source = "rectifier" for one that does not'),
        (HUB, {"source_voltage_v": 48.0}, "is 48, but must be the link_voltage_v of [inverter], 36 V"),
        (HUB, {"link_limit_v": 30.0}, "'link_limit_v' in [link] is 30, but must be above the nominal 36 V"),
        (HUB, {"link_limit_v": 43e3}, "at most 10 times the nominal 36 V; is it in volts?"),
        (
            HUB,
            {"capacitance_f": 1e-6, "source_resistance_ohm": 1e-3},
            "than a twentieth of the control period",
        ),
        (HUB, {"capacitance_f": 1.0}, "at most 0.77; is it in farads?"),
        (HUB, {"discharge_limit_a": 0.012}, "must be 0.69 to 6.9e+02: a rated power of 250 W takes 6.94 A"),
        (HUB, {"charge_limit_a": 8000.0}, "takes 6.94 A; is it in amperes?"),
        (
            CHOPPER,
            {"chopper_resistance_ohm": 0.15},
            "but a rated power of 2200 W requires 2.4 to 1.2e+04 ohm",
        ),
        (HUB, {"capacitance_f": 4e-8, "source_resistance_ohm": 100.0}, "is it in farads?"),
        (HUB, {"source_resistance_ohm": 3.0}, "a rated power of 250 W requires at most 0.648 ohm"),
        (CHOPPER, {"charge_limit_a": 2.0}, 'source = "rectifier" takes nothing back'),
        (
            CHOPPER,
            {"chopper_off_v": 500.0},
            "'chopper_off_v' in [link] is 500, but must be above the nominal 560 V",
        ),
        (
            CHOPPER,
            {"chopper_on_v": 700.0},
            "'chopper_on_v' in [link] is 700, but must be above chopper_off_v, 710",
        ),
        (CHOPPER, {"chopper_on_v": 900.0}, "is 900, but must be below the link's limit of 800 V"),
        (CHOPPER, {"chopper_off_v": None}, "a chopper requires all of chopper_on_v, chopper_off_v and"),
    ],
)
def test_a_link_that_does_not_fit_is_refused_in_one_sentence(
    drive: PmAcDocument, changes: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=re.escape(message)) as refused:
        changed_link(drive, **changes)
    assert "\n" not in str(refused.value)


def test_other_kinds_of_drives_take_no_link() -> None:
    drive = load_drive("star-3-phase")
    with pytest.raises(
        InputError, match=re.escape('the table [link] is for drives of the kind "pm-ac"; leave it out')
    ):
        drive.replaced(link={"source": "battery", **OWN})


def test_an_ideal_link_is_the_same_as_none() -> None:
    interior = load_drive("pm-ac-interior")
    ideal = with_link(interior, source="ideal")
    assert ideal.plant() == interior.plant()
    assert ideal.plant().dc_link == DcLink()


def test_limits_that_are_left_out_follow_from_the_drive() -> None:
    rated = 250.0 / 36.0
    battery = with_link(HUB, source="battery", **OWN).plant().dc_link
    assert (battery.source, battery.charge_limit) == (BATTERY, pytest.approx(rated))
    assert battery.discharge_limit == pytest.approx(1.5 * rated)
    assert battery.limit == pytest.approx(1.2 * 36.0)
    rectifier = with_link(HUB, source="rectifier", **OWN).plant().dc_link
    assert (rectifier.source, rectifier.charge_limit) == (RECTIFIER, 0.0)
    assert rectifier.source_inductance == 0.0


@pytest.mark.parametrize(
    ("inductance", "overshoot"),
    # The damping is half the resistance over the impedance of inductance and capacitor: 0.5, 1 and none.
    [(1e-5, 0.163), (2.5e-6, 0.0), (None, 0.0)],
)
def test_a_step_of_the_source_exceeds_it_by_the_damping(inductance: float | None, overshoot: float) -> None:
    link = with_link(HUB, source="battery", source_inductance_h=inductance, **OWN).real_link
    assert link is not None
    assert link.overshoot == pytest.approx(overshoot, abs=1e-3)
