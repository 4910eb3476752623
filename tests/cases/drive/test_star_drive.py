"""Drives of the kind `star` as documents, and what scenarios of them cannot have."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest

from drivegate_cases.documents.document import parse_document
from drivegate_cases.drive.drive_document import DriveDocument, drive_names, load_drive
from drivegate_cases.drive.limits import limits_of
from drivegate_cases.scenario.scenario import Scenario
from drivegate_models.half_bridge.plant.drive import Drive
from drivegate_models.star.plant.drive import REGULATIONS, StarDrive

PAPER, STAR = load_drive("paper-5-phase"), load_drive("star-3-phase")
STARS = [name for name in drive_names() if load_drive(name).kind == "star"]


@pytest.mark.parametrize("name", STARS)
def test_a_packaged_star_has_a_source_for_each_value(name: str) -> None:
    drive = load_drive(name)
    reported = {f"{table}.{key}" for table, sentences in drive.provenance.items() for key in sentences}
    stated = {
        f"{table}.{key}"
        for table in ("machine", "inverter", "rating", "advance", "requirements")
        for key in getattr(drive, table).model_fields_set
    }
    assert stated - reported == set(), f"{name} does not say where these are from"


def test_the_star_has_the_iron_and_copper_of_the_paper_drive() -> None:
    machine, other = STAR.machine, PAPER.machine
    share = PAPER.machine.phases / STAR.machine.phases
    assert machine.resistance_ohm * share == pytest.approx(other.resistance_ohm)
    assert machine.inductance_h * share == pytest.approx(other.inductance_h)
    assert machine.emf_constant_v_s_per_rad == other.emf_constant_v_s_per_rad
    assert machine.core_loss_conductance_s == pytest.approx(other.core_loss_conductance_s * share)
    assert STAR.rating.current_limit_a == pytest.approx(PAPER.rating.current_limit_a * share, rel=1e-3)


def test_the_plant_is_that_of_the_kind() -> None:
    assert isinstance(STAR.plant(), StarDrive)
    assert isinstance(PAPER.plant(), Drive)


@pytest.mark.parametrize("scheme", REGULATIONS)
def test_the_plant_chops_by_the_scheme_that_is_named(scheme: str) -> None:
    assert STAR.replaced(regulation=scheme).plant()._asdict()["regulation"] == REGULATIONS[scheme]


def test_schemes_of_regulation_are_other_drives() -> None:
    assert STAR.replaced(regulation="pwm-on").values_hash != STAR.values_hash


@pytest.mark.parametrize("phases", [1, 2, 4])
def test_a_star_of_few_or_even_phases_is_refused(refusal: Callable[..., str], phases: int) -> None:
    mapping = STAR.to_mapping()
    mapping["machine"]["phases"] = phases
    message = refusal(parse_document, mapping, DriveDocument, "here")
    assert message.endswith(f"the key 'machine.phases' is {phases}, but must be odd and at least 3 in a star")


def test_decoupled_phases_have_no_scheme(refusal: Callable[..., str]) -> None:
    mapping = PAPER.to_mapping()
    mapping["inverter"]["regulation"] = "upper-only"
    message = refusal(parse_document, mapping, DriveDocument, "here")
    assert "the key 'inverter.regulation' is for the kind \"star\"" in message


def test_a_scheme_that_there_is_not_is_refused_with_those_that_there_are(refusal: Callable[..., str]) -> None:
    mapping = STAR.to_mapping()
    mapping["inverter"]["regulation"] = "lower-only"
    message = refusal(parse_document, mapping, DriveDocument, "here")
    assert all(f"'{scheme}'" in message for scheme in REGULATIONS), message


def test_the_link_of_a_star_has_no_halves_to_differ(refusal: Callable[..., str]) -> None:
    mapping = {
        "schema": 2,
        "name": "unequal",
        "drive": "star-3-phase",
        "duration_s": 1.0,
        "speed_rpm": [[0.0, 600.0]],
        "load": {"kind": "constant_torque", "torque_nm": 1.0, "factor": [[0.0, 0.0], [0.2, 1.0]]},
        "imbalance": [[0.0, 0.03]],
    }
    message = refusal(parse_document, mapping, Scenario, "here")
    assert "the key 'imbalance' is for a split supply" in message


def test_a_star_that_states_no_ripple_has_no_limit_of_it() -> None:
    mapping = STAR.to_mapping()
    for key in ("ripple_percent", "closed_loop_ripple_percent"):
        del mapping["requirements"][key]
        del mapping["provenance"]["requirements"][key]
    drive = parse_document(mapping, DriveDocument, "here")
    assert limits_of(drive).ripple == limits_of(drive).closed_loop_ripple == math.inf
    again = parse_document(drive.to_mapping(), DriveDocument, "here")
    assert again == drive, "a document that is written and read has other limits"


def test_decoupled_phases_that_state_no_ripple_have_the_limits_of_the_paper() -> None:
    mapping = PAPER.to_mapping()
    del mapping["requirements"], mapping["provenance"]["requirements"]
    limits = limits_of(parse_document(mapping, DriveDocument, "here"))
    assert (limits.ripple, limits.closed_loop_ripple) == (0.13, 0.20)
