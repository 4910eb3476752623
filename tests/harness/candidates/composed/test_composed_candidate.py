"""Controllers composed of built-in blocks and blocks of a user's own: the same formula, the same bits."""

from pathlib import Path

import pytest

from drivegate.candidates.builtin.loading import BuiltinController
from drivegate.candidates.composed.loading import ComposedController, load_controller
from drivegate.candidates.fault import CandidateFault
from drivegate.candidates.resolution import resolve_candidate
from drivegate.drives.running import run_scenario
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.controllers.current.builtin import SEARCHES
from drivegate_models.errors import InputError

EXAMPLES = Path(__file__).parents[4] / "examples" / "compose"
# The first has the search step over the edge and recover; in the others angle and supply move.
SCENARIOS = {
    "lock-up": load_scenario("lock-up").replaced(duration_s=6.0),
    "dip": load_scenario("lock-up").replaced(
        duration_s=3.0, supply_v=((0.0, 48.0), (1.0, 48.0), (1.1, 44.0)), sensors="mcs96"
    ),
    "rising": load_scenario("lock-up").replaced(
        duration_s=3.0, initial_speed_rpm=480.0, speed_rpm=((0.0, 480.0), (2.0, 900.0))
    ),
}


@pytest.fixture
def manifest(tmp_path):
    """Write a manifest, and beside it the blocks that it names."""

    def write(blocks, source="", entry="reference", **keys):
        (tmp_path / "mine.py").write_text(source, encoding="utf-8")
        table = {"schema": 1, "name": "mine", "kind": "compose", "entry": entry} | keys
        lines = [f"{key} = {value!r}" for key, value in table.items()]
        lines += ["[blocks]", *(f'{name} = "{value}"' for name, value in blocks.items())]
        file = tmp_path / "candidate.toml"
        file.write_text("\n".join(lines), encoding="utf-8")
        return file

    return write


def digest(controller, scenario):
    return run_scenario(scenario, controller).digest


@pytest.mark.parametrize("base", SEARCHES)
@pytest.mark.parametrize("name", SCENARIOS)
def test_with_no_block_of_its_own_it_is_the_built_in_controller(base, name):
    scenario = SCENARIOS[name]
    assert digest(ComposedController(base, {}), scenario) == digest(
        BuiltinController(SEARCHES[base]), scenario
    )


@pytest.mark.parametrize(
    ("base", "blocks"),
    [
        ("reference", ["speed_regulator"]),
        ("reference", ["angle_model"]),
        ("reference", ["angle_model", "speed_regulator"]),
        ("initial", ["angle_model", "speed_regulator"]),
        ("published", ["search"]),
        ("published", ["speed_regulator", "search"]),
    ],
)
@pytest.mark.parametrize("name", SCENARIOS)
def test_a_block_with_the_reference_s_formula_gives_the_reference_s_bits(base, blocks, name, manifest):
    entries = {
        "angle_model": "angle_model.py:initial_angle",
        "speed_regulator": "speed_regulator.py:Regulator",
        "search": "flowchart_search.py:Search",
    }
    file = manifest({block: f"{EXAMPLES}/{entries[block]}" for block in blocks}, entry=base)
    composed = load_controller(resolve_candidate(str(file)))
    scenario = SCENARIOS[name]
    expected = digest(BuiltinController(SEARCHES[base]), scenario)
    assert digest(composed, scenario) == expected
    assert digest(composed, scenario) == expected, "reset must forget everything"


def test_an_example_declares_what_it_is():
    candidate = resolve_candidate(str(EXAMPLES / "candidate.toml"))
    assert (candidate.name, candidate.kind) == ("reference-with-my-regulator", "compose")
    assert candidate.declaration.estimates_power
    assert [source.name for source in candidate.sources] == ["speed_regulator.py"]
    assert candidate.details.blocks[0][0] == "speed_regulator"


def test_the_hash_covers_the_blocks_and_the_base(manifest):
    blocks = {"search": f"{EXAMPLES}/flowchart_search.py:Search"}
    hashes = {
        resolve_candidate(str(manifest(blocks, entry=base))).content_hash for base in ("published", "initial")
    }
    hashes.add(
        resolve_candidate(str(manifest({"search": "mine.py:Search"}, "class Search: pass"))).content_hash
    )
    assert len(hashes) == 3


REGULATOR = """
class Regulator:
    def reset(self, nameplate): pass
    def step(self, speed_reference, speed, dt): return {answer}
"""


def test_a_regulator_without_an_integral_runs_with_the_guarded_search(manifest):
    file = manifest({"speed_regulator": "mine.py:Regulator"}, REGULATOR.format(answer="2"))
    run = run_scenario(SCENARIOS["rising"], load_controller(resolve_candidate(str(file))))
    assert run.last_command[0]["current_reference"] == 2.0


@pytest.mark.parametrize(
    ("answer", "kind", "reason"),
    [
        ("None", "invalid output", "speed_regulator.step is of type NoneType, but must be a current in A"),
        ("True", "invalid output", "of type bool"),
        ("float('nan')", "invalid output", "is nan, but must be finite"),
        ("1 / 0", "exception", "ZeroDivisionError"),
    ],
)
def test_what_a_block_does_wrong_is_a_fault_of_the_candidate(manifest, answer, kind, reason):
    file = manifest({"speed_regulator": "mine.py:Regulator"}, REGULATOR.format(answer=answer))
    controller = load_controller(resolve_candidate(str(file)))
    with pytest.raises(CandidateFault) as ended:
        run_scenario(SCENARIOS["rising"], controller)
    fault = ended.value.fault
    assert (fault.kind, fault.phase) == (kind, "step")
    assert reason in fault.message
    assert fault.sense["speed"] > 0.0


@pytest.mark.parametrize(
    ("blocks", "source", "reason"),
    [
        ({"search": "mine.py:Serch"}, "class Search: pass", "the nearest name there is 'Search'"),
        ({"search": "mine.py:search"}, "def search(): pass", "must be a class with reset"),
        ({"search": "mine.py:Search"}, "class Search:\n def reset(self, n): pass", "no method 'step'"),
        (
            {"search": "mine.py:Search"},
            "class Search:\n def reset(self, n): pass\n def step(self, sense): return 0.0",
            "takes (sense), but is called as search.step(sense, current_reference)",
        ),
        ({"angle_model": "mine.py:angle"}, "def angle(speed): return 0.0", "angle_model(speed, nameplate)"),
        ({"angle_model": "mine.py:Angle"}, "class Angle: pass", "'Angle' is a class"),
        ({"angle_model": "mine.py:angle"}, "angle = 0.5", "must be a function"),
        (
            {"speed_regulator": "mine.py:Regulator"},
            "class Regulator:\n def reset(self): pass\n def step(self, a, b, c): return 0.0",
            "speed_regulator.reset(nameplate)",
        ),
        ({"angle_model": "mine.py:angle"}, "def angle(speed, nameplate:", "line 1"),
    ],
)
def test_a_block_that_cannot_be_used_is_refused_in_one_sentence(manifest, blocks, source, reason):
    candidate = resolve_candidate(str(manifest(blocks, source)))
    with pytest.raises(InputError) as refused:
        load_controller(candidate)
    assert reason in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("blocks", "keys", "reason"),
    [
        ({}, {}, "must replace a block"),
        ({"serch": "mine.py:Search"}, {}, "'search'"),
        ({"search": "mine.py"}, {}, "must be file.py:name or module:name"),
        ({"search": "other.py:Search"}, {}, "other.py does not exist"),
        ({"search": "no_such_module:Search"}, {}, "no_such_module"),
        ({"search": "mine.py:Search"}, {"entry": "referense"}, "'reference'"),
        ({"search": "mine.py:Search"}, {"kind": "python"}, "is for the kind 'compose'"),
    ],
)
def test_a_manifest_that_composes_nothing_is_refused(manifest, blocks, keys, reason):
    file = manifest(blocks, **keys)
    with pytest.raises(InputError) as refused:
        resolve_candidate(str(file))
    assert reason in str(refused.value)


def test_the_kind_needs_its_table(tmp_path):
    file = tmp_path / "candidate.toml"
    file.write_text('schema = 1\nname = "mine"\nkind = "compose"\nentry = "reference"\n', encoding="utf-8")
    with pytest.raises(InputError, match=r"needs a table \[blocks\]"):
        resolve_candidate(str(file))
