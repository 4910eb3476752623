"""The runs of a campaign follow from their numbers alone."""

import numpy as np
import pytest

from drivegate.studies.campaign.file import NormalSpread, UniformSpread, read_campaign
from drivegate.studies.campaign.plan import below, drawn, planned
from drivegate_models.errors import InputError


@pytest.fixture
def plan(write, folder):
    def made(**changes):
        return planned(read_campaign(write(**changes)), folder)

    return made


def test_every_candidate_meets_the_same_drives_and_no_two_draws_are_alike(plan):
    whole = plan(candidates=["reference", "initial"], grid={"load_share": [0.5, 1.0]}, draws=5)
    runs = [whole.run(number) for number in range(whole.runs)]
    assert whole.runs == 20
    assert [run.number for run in runs] == list(range(20))
    for first, second in zip(runs[:10], runs[10:], strict=True):
        assert first.parameters == second.parameters
        assert first.seed == second.seed
    assert len({run.seed for run in runs[:10]}) == 10
    assert len({run.parameters["resistance"] for run in runs[:10]}) == 10
    assert [run.parameters["load_share"] for run in runs[:10]] == [0.5] * 5 + [1.0] * 5
    assert [run.draw for run in runs[:5]] == [0, 1, 2, 3, 4]


def test_a_run_depends_on_the_seed_and_its_number_alone(plan):
    few, many = plan(draws=3), plan(draws=300)
    assert few.run(2).parameters == many.run(2).parameters
    assert few.run(2).seed == many.run(2).seed
    assert few.run(2).parameters != plan(draws=3, seed=8).run(2).parameters


def test_one_more_spread_parameter_leaves_the_others_as_they_are(plan):
    fewer = plan(spread={"friction_added_n_m": {"kind": "uniform", "lowest": 0.0, "highest": 0.3}})
    assert plan().run(3).parameters["friction_added_n_m"] == fewer.run(3).parameters["friction_added_n_m"]


def test_parameters_change_the_case_and_leave_the_nameplate_or_not(plan):
    run = plan(
        grid={
            "speed_rpm": [900],
            "load_share": [0.5],
            "supply_share": [0.9],
            "inertia_kg_m2": [0.06],
            "phases": [5],
        }
    ).run(0)
    scenario = run.scenario
    assert scenario.speed_rpm == ((0.0, 900.0),)
    assert scenario.initial_speed_rpm == 900.0
    assert scenario.load_profile[-1][1] == 0.5
    assert scenario.supply_profile[0][1] == pytest.approx(0.9 * 48.0)
    assert scenario.drive.machine.inertia_kg_m2 == 0.06
    assert scenario.scales.resistance == run.parameters["resistance"]
    assert scenario.nameplate().resistance == scenario.drive.machine.resistance_ohm
    assert scenario.seed == run.seed


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"cases": ["fig5-serch"]}, "the nearest is 'fig5-search'"),
        ({"candidates": ["referense"]}, "the nearest known one is 'reference'"),
        ({"candidates": ["missing.py:Mine"]}, "missing.py does not exist"),
        ({"cases": ["missing.toml"]}, "missing.toml does not exist"),
        ({"cases": ["fig5-search", "./fig5.json"]}, "two cases of the campaign are called 'fig5-search'"),
        ({"grid": {"load_share": [11.0]}}, "the case 'short' cannot have the parameters of the campaign"),
        ({"grid": {"inductance": [0.0]}}, "the case 'short' cannot have the parameters of the campaign"),
        ({"grid": {"resistance_ohm": [-1.0]}}, "'machine.resistance_ohm' is -1"),
        (
            {"spread": {"resistance": {"kind": "uniform", "lowest": -0.5, "highest": 1.0}}},
            "the case 'short' cannot have the parameters of the campaign",
        ),
    ],
)
def test_what_a_campaign_names_must_exist_and_fit(plan, folder, changes, reason):
    (folder / "fig5.json").write_text(
        (folder / "short.json").read_text(encoding="utf-8").replace('"short"', '"fig5-search"'),
        encoding="utf-8",
    )
    with pytest.raises(InputError) as refused:
        plan(**changes)
    assert reason in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_locked_load_has_no_share(plan, folder, short_case):
    locked = folder / "locked.toml"
    locked.write_text(
        'schema = 2\nname = "locked"\ndrive = "paper-5-phase"\nduration_s = 0.5\nspeed_rpm = [[0.0, 900.0]]\n'
        '[load]\nkind = "locked"\n',
        encoding="utf-8",
    )
    with pytest.raises(InputError, match="has a load of kind 'locked', which has no share"):
        plan(cases=["locked.toml"], grid={"load_share": [1.0]})


def test_chunks_cover_every_run_once_and_never_mix_candidates(plan):
    whole = plan(candidates=["reference", "initial"], draws=7, runs_per_file=3)
    chunks = list(whole.chunks())
    numbers = [number for chunk in chunks for number in range(chunk.first, chunk.first + chunk.length)]
    assert numbers == list(range(14))
    assert [(chunk.candidate, chunk.part, chunk.length) for chunk in chunks] == [
        (0, 0, 3), (0, 1, 3), (0, 2, 1), (1, 0, 3), (1, 1, 3), (1, 2, 1),
    ]  # fmt: skip


def test_drawn_values_have_the_distribution_that_was_requested():
    shares = (np.arange(20_000) + 0.5) / 20_000
    normal = NormalSpread(kind="normal", mean=1.0, sigma=0.1, lowest=0.8, highest=1.2)
    values = np.array([drawn(normal, float(share)) for share in shares])
    assert values.min() >= 0.8
    assert values.max() <= 1.2
    assert values.mean() == pytest.approx(1.0, abs=1e-4)
    # A normal distribution cut off at two sigma has 0.8796 of the standard deviation.
    assert values.std() == pytest.approx(0.0880, abs=2e-4)
    uniform = UniformSpread(kind="uniform", lowest=2.0, highest=4.0)
    values = np.array([drawn(uniform, float(share)) for share in shares])
    assert values.mean() == pytest.approx(3.0, abs=1e-4)
    assert values.std() == pytest.approx(2.0 / 12.0**0.5, abs=1e-3)


def test_relative_paths_start_beside_the_campaign(tmp_path):
    assert below("own.py:Mine", tmp_path) == f"{tmp_path}/own.py:Mine"
    assert below("own.c", tmp_path) == f"{tmp_path}/own.c"
    assert below("/abs/own.toml", tmp_path) == "/abs/own.toml"
    for untouched in ("reference", "faulty:slope-doubled", "module:Class", "exec:./own --flag x.py"):
        assert below(untouched, tmp_path) == untouched
