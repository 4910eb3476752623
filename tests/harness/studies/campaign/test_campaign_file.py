"""The file of a campaign: what is refused, and in which words."""

import pytest

from drivegate.studies.campaign.file import read_campaign
from drivegate_models.errors import InputError

NORMAL = {"kind": "normal", "mean": 1.0, "sigma": 0.1, "lowest": 0.5, "highest": 1.5}
UNIFORM = {"kind": "uniform", "lowest": 0.9, "highest": 1.1}


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"candidate": ["reference"]}, "the nearest known key is 'candidates'"),
        ({"candidates": []}, "'candidates'"),
        ({"candidates": ["initial", "initial"]}, "'initial' is listed twice"),
        ({"checks": ["CNV-9"]}, "'CNV-9' is no check that a campaign judges, the nearest is 'CNV-"),
        ({"checks": ["DET-1"]}, "'DET-1' is no check that a campaign judges"),
        ({"draws": 0}, "'draws' is 0"),
        ({"draws": 2_000_000, "grid": {"load_share": [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]}}, "at most 10000000"),
        (
            {"grid": {"resistence": [1.0]}},
            "'resistence' is no parameter of a grid, the nearest is 'resistance'",
        ),
        ({"grid": {"load_share": []}}, "the parameter 'load_share' has no values"),
        ({"grid": {"load_share": [1.0, 1.0]}}, "the parameter 'load_share' has a value twice"),
        ({"spread": {"inductanc": UNIFORM}}, "no parameter that can be spread, the nearest is 'inductance'"),
        ({"spread": {"speed_rpm": UNIFORM}}, "'speed_rpm' is no parameter that can be spread"),
        ({"spread": {"resistance": UNIFORM | {"kind": "gauss"}}}, "'spread.resistance.kind' is \"gauss\""),
        (
            {"spread": {"resistance": UNIFORM | {"lowest": 2.0}}},
            "'lowest' is 2, but must be below 'highest', 1.1",
        ),
        ({"spread": {"resistance": NORMAL | {"mean": 2.0}}}, "'mean' is 2, but must lie from 'lowest', 0.5"),
        ({"spread": {"resistance": NORMAL | {"sigma": 0.0}}}, "'spread.resistance.sigma' is 0.0"),
        ({"spread": {"resistance": NORMAL | {"sigm": 1.0}}}, "the nearest known key is 'sigma'"),
        ({"spread": {"resistance": UNIFORM}, "grid": {"resistance": [1.0]}}, "in 'grid' and in 'spread'"),
        ({"schema": 2}, "newer than this drivegate reads"),
    ],
)
def test_what_is_wrong_is_reported_in_one_sentence(write, changes, reason):
    file = write(**changes)
    with pytest.raises(InputError) as refused:
        read_campaign(file)
    sentence = str(refused.value)
    assert reason in sentence
    assert "\n" not in sentence
    assert "campaign.json" in sentence, "the sentence must name the file"


def test_the_length_of_files_follows_from_the_number_of_runs(write):
    assert read_campaign(write(draws=12, runs_per_file=None)).file_length == 1
    assert read_campaign(write(draws=640, runs_per_file=None)).file_length == 10
    assert read_campaign(write(draws=1_000_000, runs_per_file=None)).file_length == 100
    assert read_campaign(write(draws=640, runs_per_file=7)).file_length == 7
