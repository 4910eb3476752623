"""Manifests: what they may say, and what is reported about one that says something else."""

import json
from dataclasses import astuple, fields
from math import pi, radians

import pytest

from drivegate.candidates.contract_keys import CONTRACT_KEYS
from drivegate.candidates.declaration import Declaration
from drivegate.candidates.manifest import Manifest
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.kinds import drive_for
from drivegate_cases.documents.document import parse_document, read_document
from drivegate_models.errors import InputError

LEAST = {"schema": 1, "name": "mine", "kind": "python", "entry": "controller.py:Mine"}
FLOWCHART = {"k1_rpm": 5.0, "k2_w": 2.0, "step_deg": 1.0, "period_s": 0.1}


def parsed(**changes):
    return parse_document({**LEAST, **changes}, Manifest, "candidate.toml")


def test_the_least_manifest_declares_nothing_special():
    assert parsed().declaration() == Declaration()


def test_a_full_manifest_is_read_from_toml(tmp_path):
    file = tmp_path / "candidate.toml"
    file.write_text(
        """
        schema = 1
        name = "flowchart search"
        kind = "python"
        entry = "controller.py:Search"
        sources = ["controller.py", "gains.py"]
        profile = "flowchart"
        estimates_power = true
        power_window_s = 0.1
        speed_range_rpm = [0.0, 2000.0]

        [flowchart]
        k1_rpm = 30.0
        k2_percent = 0.1
        step_deg = 1.0
        period_s = 0.1
        """,
        encoding="utf-8",
    )
    manifest = read_document(file, Manifest)
    assert manifest.sources == ("controller.py", "gains.py")
    declaration = manifest.declaration()
    assert (declaration.estimates_power, declaration.speed_range_rpm) == (True, (0.0, 2000.0))
    assert declaration.power_window_s == 0.1
    assert astuple(declaration.flowchart) == pytest.approx((pi, 0.0, 0.001, radians(1.0), 0.1))


def test_a_power_tolerance_may_be_in_watts():
    profile = parsed(profile="flowchart", flowchart=FLOWCHART).declaration().flowchart
    assert (profile.power_tolerance, profile.power_tolerance_fraction) == (2.0, 0.0)


def test_a_native_candidate_may_have_flags_and_headers():
    manifest = parsed(kind="c", entry="controller.c", include=["include"], flags=["-O3"])
    assert (manifest.include, manifest.flags) == (("include",), ("-O3",))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"kid": "python"}, "the nearest known key is 'kind'"),
        ({"kind": "rust"}, "'kind'"),
        ({"name": ""}, "'name'"),
        ({"schema": 2}, "newer"),
        ({"estimates_power": "yes"}, "'estimates_power'"),
        ({"profile": "flowchart"}, "needs a table [flowchart]"),
        ({"flowchart": FLOWCHART}, "the table [flowchart] needs the profile 'flowchart'"),
        ({"profile": "flowchart", "flowchart": {**FLOWCHART, "k2_percent": 0.1}}, "exactly one of"),
        ({"profile": "flowchart", "flowchart": {**FLOWCHART, "step_deg": 0.0}}, "'flowchart.step_deg'"),
        ({"profile": "flowchart", "flowchart": {"k1_rpm": 5.0}}, "'flowchart.step_deg' is missing"),
        ({"speed_range_rpm": [2000.0, 0.0]}, "'speed_range_rpm[1]'"),
        ({"speed_range_rpm": [2000.0, 500.0]}, "the lowest speed first"),
        ({"estimates_power": True, "power_window_s": -0.1}, "'power_window_s'"),
        ({"power_window_s": 0.1}, "the key 'power_window_s' needs 'estimates_power = true'"),
        (
            {
                "profile": "flowchart",
                "flowchart": {"k1_rpm": 5.0, "k2_percent": 100.0, "step_deg": 1.0, "period_s": 0.1},
            },
            "'flowchart.k2_percent'",
        ),
        (
            {"kind": "builtin", "sources": ["a.csv"]},
            "the key 'sources' is for the kinds 'python', 'c', 'so',",
        ),
        ({"flags": ["-O3"]}, "the key 'flags' is for the kind 'c', but the kind is 'python'"),
        ({"kind": "compose"}, "the key 'kind' is \"compose\", but must be 'python', 'builtin', 'c'"),
        ({"blocks": {"search": "mine.py:Search"}}, "the key 'blocks' is unknown"),
    ],
)
def test_a_wrong_manifest_is_reported_in_one_sentence(changes, sentence):
    with pytest.raises(InputError) as caught:
        parsed(**changes)
    message = str(caught.value)
    assert sentence in message
    assert message.startswith("candidate.toml")
    assert "\n" not in message


def test_what_a_candidate_follows_is_declared():
    assert parsed(contract="duty", references=["torque"]).declaration().references == ("torque",)
    assert parsed(contract="duty", references=["current"]).declaration().follows_current
    assert parsed(contract="duty", detects=["open-phase"]).declaration().detects == ("open-phase",)
    assert parsed(contract="duty", current_bandwidth_rad_s=1000).declaration().current_bandwidth == 1000.0
    assert parsed(contract="duty", modulation="dpwm-min").declaration().modulation == "dpwm-min"
    assert parsed(contract="duty").declaration().modulation == "continuous"
    begun = parsed(contract="duty", reads_enable=True, calibration_time_s=0.25).declaration()
    assert (begun.reads_enable, begun.calibration_time_s) == (True, 0.25)
    assert begun.with_bridge_on() == parsed(contract="duty").declaration()


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"contract": "current", "references": ["speed"]}, "'references' is for the contract 'duty'"),
        ({"contract": "duty", "references": []}, "is empty, but must name 'speed', 'torque' or both"),
        ({"contract": "duty", "references": ["position"]}, "position"),
        ({"contract": "duty", "references": ["current", "speed"]}, "which excludes a further reference"),
        ({"contract": "duty", "references": ["current"], "detects": ["slip"]}, "which excludes 'detects'"),
        ({"contract": "current", "detects": ["open-phase"]}, "'detects' is for the contract 'duty'"),
        ({"contract": "duty", "detects": ["fire"]}, "fire"),
        ({"contract": "current", "reads_enable": True}, "'reads_enable' is for the contract 'duty'"),
        ({"contract": "current", "current_bandwidth_rad_s": 1e3}, "is for the contract 'duty'"),
        ({"contract": "duty", "current_bandwidth_rad_s": 0.0}, "current_bandwidth_rad_s"),
        ({"contract": "current", "control_every": 2}, "'control_every' is for the contract 'duty'"),
        ({"contract": "duty", "control_every": 33}, "control_every"),
        ({"contract": "current", "update_delay": 0}, "'update_delay' is for the contract 'duty'"),
        ({"contract": "duty", "update_delay": 2}, "must be 0 or 1"),
        ({"contract": "current", "modulation": "dpwm-1"}, "'modulation' is for the contract 'duty'"),
        ({"contract": "duty", "modulation": "flat-bottom"}, "must be 'continuous', 'dpwm-min', 'dpwm-max'"),
        ({"contract": "duty", "calibration_time_s": 0.1}, "needs 'reads_enable = true'"),
        ({"contract": "duty", "reads_enable": True, "calibration_time_s": 0.6}, "calibration_time_s"),
    ],
)
def test_other_references_are_refused(changes, words):
    with pytest.raises(InputError) as refusal:
        parsed(**changes)
    assert words in str(refusal.value)


STATED = {
    "references": ["torque"],
    "detects": ["open-phase"],
    "reverses": False,
    "reads_enable": True,
    "calibration_time_s": 0.1,
    "current_bandwidth_rad_s": 1e3,
    "control_every": 2,
    "update_delay": 0,
    "modulation": "dpwm-1",
    "flowchart": FLOWCHART,
    "speed_range_rpm": [0.0, 500.0],
    "estimates_power": True,
    "power_window_s": 0.1,
}
"""A value for each key that one contract alone has."""
NEEDED = {
    "calibration_time_s": {"reads_enable": True},
    "flowchart": {"profile": "flowchart"},
    "power_window_s": {"estimates_power": True},
}


def toml_value(value):
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {toml_value(item)}' for key, item in value.items())} }}"
    return json.dumps(value)


def as_toml(table):
    return "\n".join(f"{key} = {toml_value(value)}" for key, value in table.items())


def test_every_key_of_a_declaration_is_of_both_contracts_or_in_the_table():
    assert set(STATED) == set(CONTRACT_KEYS)
    of_both = {"requirements"}
    assert {key.field for key in CONTRACT_KEYS.values()} | of_both == {
        field.name for field in fields(Declaration)
    }


@pytest.mark.parametrize("key", CONTRACT_KEYS)
@pytest.mark.parametrize("way", ["stated", "imported", "the drive's"])
def test_a_key_of_the_other_contract_is_refused_wherever_the_contract_shows(tmp_path, key, way):
    own = CONTRACT_KEYS[key].contract
    other = {"current": "duty", "duty": "current"}[own]
    command = {"duty": "DutyCommand", "current": "Command"}[other]
    (tmp_path / "mine.py").write_text(
        f"from drivegate import {command}\nclass Mine: pass\n" if way == "imported" else "class Mine: pass\n"
    )
    drive = {"duty": "pm-ac-interior", "current": "paper-5-phase"}[other]
    changes = {"stated": {"contract": other}, "imported": {}, "the drive's": {"drive": drive}}[way]
    document = LEAST | {"entry": "mine.py:Mine"} | changes
    document |= {key: STATED[key]} | NEEDED.get(key, {})
    file = tmp_path / "candidate.toml"
    file.write_text(as_toml(document), encoding="utf-8")
    with pytest.raises(InputError, match=rf"is for the contract '{own}', but the contract is '{other}'"):
        drive_for(resolve_candidate(str(file)))
    document |= {"contract": own, "drive": {"duty": "pm-ac-interior", "current": "paper-5-phase"}[own]}
    (tmp_path / "mine.py").write_text("class Mine: pass\n")
    file.write_text(as_toml(document), encoding="utf-8")
    assert resolve_candidate(str(file)).contract == own
