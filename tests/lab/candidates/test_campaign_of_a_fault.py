"""A campaign of a sound and a faulty controller of duty ratios: the rows and the counterexample of each."""

import json

import pandas
import pytest
from tests.harness.studies.campaign.conftest import folder, short_case, write
from tests.harness.studies.campaign.duty.test_duty_campaign import duty_cases, plan

from drivegate.contracts.duty.columns import DutyColumns
from drivegate.studies.campaign.engine import packed, run_chunk
from drivegate.studies.campaign.folder import CampaignFolder, table_bytes
from drivegate.studies.campaign.row import JUDGED_CHECKS
from drivegate.studies.campaign.summary import summarised

__all__ = ["duty_cases", "folder", "plan", "short_case", "write"]


def test_rows_have_the_margins_and_observations_of_the_contract(plan, folder):
    whole = plan(
        candidates=["foc", "faulty:long-period"],
        grid={"load_share": [0.5, 1.0]},
        spread={},
        draws=1,
        runs_per_file=4,
    )
    with CampaignFolder(folder / "out", whole) as held:
        for chunk in whole.chunks():
            runs = [whole.run(chunk.first + place) for place in range(chunk.length)]
            rows = run_chunk(packed(whole), chunk)
            held.write(held.path_of(chunk), table_bytes(runs, rows, ("load_share",), whole.checks))
        sound, faulty = summarised(whole, held, 0.95)["candidates"]
    assert (sound["verdicts"], faulty["verdicts"]) == ({"pass": 4}, {"fail": 4})
    frame = pandas.read_parquet(folder / "out" / "runs").sort_values("run")
    margins = [column.removeprefix("margin_") for column in frame.columns if column.startswith("margin_")]
    assert tuple(margins) == JUDGED_CHECKS["duty"]
    assert set(DutyColumns.observations) <= set(frame.columns)
    assert "advance_mean_deg" not in frame.columns
    half, full = frame["torque_mean_nm"].to_numpy()[:2]
    assert full == pytest.approx(2.0 * half, rel=0.1), "the share of the load is that of the torque reference"
    assert (frame["energy_residual"] < 1e-9).all()
    broken = next(check for check in faulty["checks"] if check["id"] == "DUT-1")
    kept = json.loads((folder / "out" / broken["counterexample"]).read_text(encoding="utf-8"))
    assert (kept["check"], kept["scenario"]["drive"]["name"]) == ("DUT-1", "pm-ac-interior")
