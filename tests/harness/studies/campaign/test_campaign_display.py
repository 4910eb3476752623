"""A finished campaign on the console: the command that it names works as printed."""

import io

from drivegate.output.console import console_for
from drivegate.studies.campaign.display import show_campaign


def test_the_next_step_names_the_candidate_and_is_not_wrapped():
    stated = {"runs": 0, "margin_quantiles": [], "worst_run": None}
    check = {
        "id": "CNV-1",
        "level": "required",
        "counterexample": "counterexamples/mine/CNV-1.json",
        **stated,
    }
    mine = {
        "name": "mine",
        "verdicts": {"fail": 1},
        "checks": [check],
        "not_passed": stated,
        "first_faults": [],
    }
    document = {
        "confidence": 0.95,
        "quantiles": [],
        "output": "my campaign",
        "specifications": ["sub folder/mine.py:Mine"],
        "candidates": [mine],
    }
    stream = io.StringIO()
    show_campaign(console_for(stream), document)
    assert stream.getvalue().splitlines()[-1] == (
        "next: drivegate replay 'my campaign/counterexamples/mine/CNV-1.json' "
        "--candidate 'sub folder/mine.py:Mine'"
    ), "without --candidate, replay refuses a candidate that does not come with drivegate"
