"""A campaign that is killed loses nothing that was finished, and two never write into one folder."""

import os
import random
import signal
import time
from pathlib import Path

import pytest

from drivegate.studies.campaign.file import read_campaign
from drivegate.studies.campaign.folder import LOCK, CampaignFolder
from drivegate.studies.campaign.plan import planned
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.errors import InputError

# So many that on a busy machine, too, some are left when this process is notified of the first ones.
DRAWS = 20


def results(output: Path) -> dict[Path, int]:
    return {path: path.stat().st_mtime_ns for path in (output / "runs").rglob("*.parquet")}


def wait_for(output: Path, files: int, process) -> None:
    deadline = time.monotonic() + 120.0
    while len(results(output)) < files and process.poll() is None:
        assert time.monotonic() < deadline, "the campaign makes no progress"
        time.sleep(0.01)


@pytest.mark.nightly
def test_killed_at_any_moment_it_goes_on_to_the_same_bytes(write, start, finish, folder, bytes_of):
    # Of short runs nothing would be left to go on with a tenth of a second later.
    long = load_scenario("fig5-search").replaced(name="long", duration_s=30.0)
    (folder / "long.json").write_text(long.to_json(), encoding="utf-8")
    file = write(cases=["long.json"], draws=DRAWS, runs_per_file=1, checks=["CMD-1", "ROB-1"])
    finish(file, "whole")
    chance = random.Random(5)
    output = folder / "out"
    process = start("campaign", file, "--output", "out", "--workers", 2)
    wait_for(output, 2, process)
    time.sleep(chance.uniform(0.0, 0.1))
    os.kill(process.pid, signal.SIGKILL)
    # Its workers hold its output open as long as they live.
    process.communicate(timeout=20)
    kept = results(output)
    assert len(kept) < DRAWS, "it was killed when all was done"
    assert (output / LOCK).exists(), "a killed campaign cannot tidy up, and the next one must cope"
    document = finish(file, "out")
    assert document["timing"]["runs_made"] == DRAWS - len(kept)
    finished = results(output)
    assert {path: finished.get(path) for path in kept} == kept, "finished files must not be touched"
    assert bytes_of(output) == bytes_of(folder / "whole")
    again = finish(file, "out")
    assert again["timing"]["runs_made"] == 0


def test_a_second_campaign_in_the_same_folder_is_refused_with_who_writes(write, folder):
    plan = planned(read_campaign(write()), folder)
    with CampaignFolder(folder / "out", plan):
        with pytest.raises(InputError) as refused, CampaignFolder(folder / "out", plan):
            pytest.fail("two campaigns must not hold one folder")
        assert f"process {os.getpid()} on " in str(refused.value)
        assert "is being written by another campaign" in str(refused.value)
    with CampaignFolder(folder / "out", plan):
        assert (folder / "out" / LOCK).exists()
    assert not (folder / "out" / LOCK).exists()


def test_what_a_killed_campaign_has_half_written_is_removed(write, folder):
    plan = planned(read_campaign(write()), folder)
    with CampaignFolder(folder / "out", plan) as held:
        half = held.path_of(next(plan.chunks())).with_name(".0123.partial")
        half.write_bytes(b"half")
    with CampaignFolder(folder / "out", plan):
        assert not half.exists()


def test_a_disk_that_fails_is_one_sentence_and_leaves_what_was_there(write, folder, monkeypatch):
    plan = planned(read_campaign(write()), folder)
    with CampaignFolder(folder / "out", plan) as held:
        path = held.path_of(next(plan.chunks()))
        held.write(path, b"first")

        def full(*_: object) -> None:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr("os.fsync", full)
        with pytest.raises(InputError) as refused:
            held.write(path, b"second")
        assert "No space left on device" in str(refused.value)
        assert "goes on" in str(refused.value)
        assert path.read_bytes() == b"first"
        assert list(path.parent.glob(".*")) == []
