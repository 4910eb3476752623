"""`drivegate new`: a candidate of each kind that works, and whose own test runs."""

import re
import subprocess
import sys
import tomllib
from datetime import UTC, datetime, timedelta

import pytest
import yaml

from drivegate.candidates.resolution import resolve_candidate
from drivegate.commands.new import CHOICES, DRIVE, REQUIREMENTS, SCENARIO
from drivegate.contracts.current.checks.catalogue import CHECKS
from drivegate.results.provenance import versions
from drivegate.results.waivers import read_waivers
from drivegate.studies.diff.diff import Rule, compared
from drivegate.studies.new import KINDS, WAIVED, WHEELS, wheel_name, write_candidate
from drivegate_cases.scenario.scenario import load_scenario
from drivegate_models.errors import InputError

WHEEL = f"{WHEELS}/{wheel_name()}"
COMMON = {
    "README.md",
    "candidate.toml",
    "test_controller.py",
    "waivers.toml",
    ".gitignore",
    ".github/workflows/drivegate.yml",
    ".github/actions/drivegate/action.yml",
    f"{WHEELS}/requirements.txt",
    WHEEL,
}
TODAY = datetime.now(UTC).date()
NEEDED = {"rust": "cargo", "cortex-m": "arm-none-eabi-gcc"}
PAPER = "paper-5-phase"
OF_CURRENTS = [
    pytest.param(kind, marks=[pytest.mark.needs(NEEDED[kind])] if kind in NEEDED else [])
    for kind, template in KINDS.items()
    if "current" in template.folders
]
# From standstill to above base speed, so that every branch of the algorithm is taken.
RISING = load_scenario("lock-up").replaced(
    duration_s=1.5,
    initial_speed_rpm=300.0,
    speed_rpm=((0.0, 300.0), (0.1, 300.0), (0.1, 900.0), (0.8, 900.0), (0.8, 700.0)),
    load={"kind": "constant_torque", "torque_nm": 2.0, "factor": [[0.0, 1.0]]},
)


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_written_whole_and_states_the_next_step(command, tmp_path, kind):
    ended = command("new", kind, "my-own", "--json")
    document, folder = ended.document, tmp_path / "my-own"
    assert ended.code == 0
    assert set(document["files"]) == {
        path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()
    }
    assert set(document["files"]) >= COMMON | {KINDS[kind].source}
    assert document["next"][0] == "cd my-own"
    host = " host.toml" if kind == "cortex-m" else ""
    only = " --only DEC-1" if kind in {"python", "fmu", "exec"} else ""
    assert document["next"][-1] == f"drivegate check{host} --effort quick{only}"
    listed = (folder / "README.md").read_text(encoding="utf-8").splitlines()
    assert {document["next"][-1], "drivegate check --effort quick"} <= set(listed)
    assert tomllib.loads((folder / "candidate.toml").read_text(encoding="utf-8"))["name"] == "my-own"
    for path in folder.rglob("*"):
        text = path.read_text(encoding="utf-8") if path.is_file() and path.suffix != ".whl" else ""
        left = re.findall(r"@(?:name|expires|source|wheel|install|here|pipeline)@", text)
        assert not left, f"{path.name} has a blank left"


def test_people_are_shown_the_next_step(command):
    ended = command("new", "rust", "mine", "--output", "some where/else")
    assert "src/lib.rs" in ended.out
    assert "next: cd 'some where/else' && drivegate check --effort quick" in ended.out


def test_the_kinds_on_the_command_line_are_those_that_there_are():
    assert set(CHOICES) == {*KINDS, DRIVE, REQUIREMENTS, SCENARIO}


@pytest.mark.one_in(3)
@pytest.mark.parametrize("kind", OF_CURRENTS)
def test_every_kind_gives_the_commands_of_the_built_in_line_of_angles(tmp_path, kind):
    folder = tmp_path / "mine"
    write_candidate(kind, "mine", folder, TODAY, PAPER)
    candidate = resolve_candidate(str(folder / "candidate.toml"))
    assert candidate.name == "mine"
    # So what `initial` passes and fails is what the new candidate passes and fails.
    ended = compared(resolve_candidate("initial"), candidate, RISING, Rule(), before=0, after=0)
    assert (ended.fault, ended.difference, ended.steps) == (None, None, RISING.control_periods)
    is_counted = [costs.instructions > 0 for costs in ended.costs]
    assert is_counted == [False, kind == "cortex-m"], "instructions of an image"


def test_the_wheel_is_drivegate_as_it_is_here(tmp_path):
    write_candidate("python", "mine", tmp_path / "mine", TODAY)
    write_candidate("c", "other", tmp_path / "other", TODAY)
    wheel = tmp_path / "mine" / WHEEL
    assert wheel.read_bytes() == (tmp_path / "other" / WHEEL).read_bytes(), "equal sources, other bytes"
    assert wheel.stat().st_size < 2_000_000, "the documentation calls it 2 MB at most"
    pip = [sys.executable, "-m", "pip", "install", "--no-index", "--no-deps", "--no-compile", "--target"]
    subprocess.run([*pip, "there", wheel], cwd=tmp_path, check=True, capture_output=True)
    # Isolated from the drivegate that runs this test, but for what that one needs of others.
    program = (
        f"import sys; sys.path.insert(0, {str(tmp_path / 'there')!r})\n"
        "from importlib.metadata import distribution\n"
        "from drivegate.results.provenance import versions\n"
        "import drivegate, drivegate_models, drivegate_cases, drivegate_reports as reports\n"
        "print(drivegate.__file__, reports.__file__, distribution('drivegate').locate_file(''), versions()['sources'])"
    )
    ended = subprocess.run(
        [sys.executable, "-c", program], cwd=tmp_path, check=True, capture_output=True, text=True
    )
    *places, digest = ended.stdout.split()
    assert all(place.startswith(str(tmp_path / "there")) for place in places), places
    assert digest == versions()["sources"], "it has other sources"


def test_its_waivers_expire_and_its_own_test_is_the_gate(tmp_path):
    folder = tmp_path / "mine"
    write_candidate("c", "mine", folder, TODAY, PAPER)
    waivers = read_waivers(folder / "waivers.toml", ["mine"])
    assert [waiver.expires for waiver in waivers] == [TODAY + WAIVED] * 2
    ended = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-W", "ignore", "--collect-only"],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert ended.returncode == 0, ended.stdout[-3000:]
    items = re.findall(r"test_conformance\[(\S+)\]", ended.stdout)
    assert items == ["candidate", *(check.id for check in CHECKS)]


def test_a_folder_with_something_in_it_is_left_alone(tmp_path, refused):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "note.txt").write_text("precious", encoding="utf-8")
    assert "nothing is ever overwritten" in refused("new", "c", "mine")
    (tmp_path / "file").write_text("precious", encoding="utf-8")
    assert "exists already" in refused("new", "c", "mine", "--output", "file")


def test_an_empty_folder_is_filled(command, tmp_path):
    (tmp_path / "mine").mkdir()
    assert command("new", "python", "mine").code == 0
    assert (tmp_path / "mine" / "controller.py").is_file()
    assert [path.name for path in tmp_path.iterdir()] == ["mine"], "nothing may be left beside the folder"


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (["cobol", "mine"], "'cobol' is not one of"),
        (["c"], "NAME"),
        (["c", "../mine"], "must begin with a letter"),
        (["c", "m" * 65], "64 at most"),
        (["c", "mine", "--output", "/proc/mine"], "cannot be written"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(refused, words, reason):
    assert reason in refused("new", *words)


def test_a_failure_to_write_leaves_nothing(tmp_path, monkeypatch):
    monkeypatch.setattr("pathlib.Path.rename", lambda *_: (_ for _ in ()).throw(OSError(28, "No space left")))
    with pytest.raises(InputError, match="No space left"):
        write_candidate("c", "mine", tmp_path / "mine", TODAY + timedelta(days=1))
    assert list(tmp_path.iterdir()) == []


def test_in_a_repository_the_workflow_goes_where_it_runs(command, refused, tmp_path):
    (tmp_path / ".git").mkdir()
    document = command("new", "c", "mine", "--output", "boards/mine", "--json").document
    assert "../../.github/workflows/drivegate.yml" in document["files"]
    text = (tmp_path / ".github/workflows/drivegate.yml").read_text(encoding="utf-8")
    given = yaml.safe_load(text)["jobs"]["gate"]["steps"][-1]
    assert (tmp_path / given["uses"] / "action.yml").is_file()
    for name in ("candidate", "install", "waivers"):
        assert (tmp_path / given["with"][name]).is_file(), name
    # A second one has a name of its own, and a third one of the same name is refused.
    assert command("new", "c", "mine", "--output", "other").code == 0
    assert (tmp_path / ".github/workflows/drivegate-mine.yml").is_file()
    assert "nothing is ever overwritten" in refused("new", "c", "mine", "--output", "third")
    assert "cannot be named in a pipeline" in refused("new", "c", "mine", "--output", "a folder")
    assert command("new", "c", "mine", "--output", "a folder", "--ci", "none").code == 0
    readme = (tmp_path / "a folder" / "README.md").read_text(encoding="utf-8")
    assert ".github" not in readme
    assert not (tmp_path / "a folder" / ".github").exists()


def test_for_gitlab_there_is_one_file_that_includes_others(command, tmp_path):
    (tmp_path / ".git").mkdir()
    assert command("new", "c", "mine", "--ci", "gitlab").code == 0
    found = yaml.safe_load((tmp_path / ".gitlab-ci.yml").read_text(encoding="utf-8"))
    assert (tmp_path / found[".drivegate"]["variables"]["DRIVEGATE"]).is_file()
    assert " check mine/candidate.toml " in found["gate"]["script"][0]
    ended = command("new", "c", "second", "--ci", "gitlab")
    assert "add to .gitlab-ci.yml: include: [{local: second/.gitlab-ci.yml}]" in ended.out
    assert (tmp_path / "second" / ".gitlab-ci.yml").is_file()


def test_the_pipeline_of_an_fmu_installs_fmpy_too(tmp_path):
    for kind in ("c", "fmu"):
        write_candidate(kind, "mine", tmp_path / kind, TODAY)
    usual, more = (
        (tmp_path / kind / f"{WHEELS}/requirements.txt").read_text(encoding="utf-8") for kind in ("c", "fmu")
    )
    assert more.startswith(usual)
    listed = re.findall(r"^([a-z0-9-]+)==", more, re.MULTILINE)
    assert "fmpy" in listed[usual.count("==") :]
    assert not set(re.findall(r"^([a-z0-9-]+)==", more[len(usual) :], re.MULTILINE)) & set(
        re.findall(r"^([a-z0-9-]+)==", usual, re.MULTILINE)
    ), "pip refuses what is listed twice"


def test_git_ignores_what_checks_and_builds_write(tmp_path):
    write_candidate("rust", "mine", tmp_path / "mine", TODAY)
    ignored = (tmp_path / "mine" / ".gitignore").read_text(encoding="utf-8").split()
    assert {"drivegate-report/", "__pycache__/", "/target"} <= set(ignored)
