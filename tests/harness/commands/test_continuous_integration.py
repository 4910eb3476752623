"""The recipes for CI servers: their shell lines run, and what they leave is what the servers are configured to take."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from packaging.requirements import Requirement

from drivegate.commands.check import command as check_command
from drivegate.results.waivers import read_waivers
from drivegate.studies.new import write_candidate
from drivegate_models.compilation.kernels import cache_key

ROOT = Path(__file__).parents[3]
REQUIREMENTS = ROOT / "harness/drivegate/templates/new/every/requirements.txt"
DOCS = ROOT / "docs"
INSTALL = "Install drivegate"
"""The step that must fail here: there is no index, and what it would install is what these tests run in."""
COMMIT = "c0ffee1234567890c0ffee1234567890c0ffee12"
SEED = str(0xC0FFEE12)
"""The seed that the recipes make of the commit's hash."""
HOSTILE = (
    "pip.py",
    "numba.py",
    "click.py",
    "sitecustomize.py",
    "usercustomize.py",
    "pytest.py",
    "drivegate.py",
    "json.py",
    "hashlib.py",
    "drivegate_models/__init__.py",
    "yaml.py",
    "psutil.py",
)
"""Files of a checkout that Python would find before its own and drivegate's, in the folder that it starts in."""
WITNESS = "import pathlib; pathlib.Path(__file__).with_suffix('.ran').touch()\n"
CANDIDATE = "published"
"""One that fails: the later steps have to run all the same."""
FOCUS = "--workers 1 --only CPW-1 --stop-at-first"
"""A required check that it fails, in few runs; the other checks take the same way through the recipe."""
OWN_TEST = "def test_nothing():\n    pass\n"


def recipes() -> list[dict[str, Any]]:
    text = (DOCS / "continuous_integration.md").read_text(encoding="utf-8")
    return [yaml.safe_load(block) for block in re.findall(r"```yaml\n(.*?)```", text, flags=re.DOTALL)]


GITHUB, GITLAB, HOOK = recipes()
ACTION = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))


def hostile_checkout(folder: Path) -> Path:
    """Fill a checkout with modules that note when they run, and with a report of an earlier run."""
    for name in HOSTILE:
        file = folder / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(WITNESS, encoding="utf-8")
    (folder / "drivegate-report").mkdir()
    for name in ("summary.md", "annotations.txt", "result.json", "junit.xml", "report.html"):
        (folder / "drivegate-report" / name).write_text("forged: pass", encoding="utf-8")
    return folder


def hostile_that_ran(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.rglob("*.ran"))


def ran(line: str, folder: Path, variables: dict[str, str]) -> subprocess.CompletedProcess[str]:
    environment = os.environ | {"PIP_NO_INDEX": "1", "PIP_DRY_RUN": "1"} | variables
    environment["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{environment['PATH']}"
    # The cache of this machine: a recipe's own would have everything compiled once more.
    environment.pop("DRIVEGATE_CACHE", None)
    if "DRIVEGATE_CACHE" in os.environ:
        environment["DRIVEGATE_CACHE"] = os.environ["DRIVEGATE_CACHE"]
    return subprocess.run(
        ["bash", "-e", "-o", "pipefail", "-c", line],
        check=False,
        cwd=folder,
        env=environment,
        capture_output=True,
        text=True,
        timeout=500,
    )


def filled(text: str, values: dict[str, str]) -> str:
    """Put values where GitHub would: the first of several that is not empty."""

    def value(found: re.Match[str]) -> str:
        return next((chosen for name in found[1].split("||") if (chosen := values[name.strip()])), "")

    return re.sub(r"\$\{\{(.*?)\}\}", value, text)


@dataclass(frozen=True)
class Job:
    """What a job left behind."""

    folder: Path
    """The checkout."""
    temporary: Path
    outputs: dict[str, dict[str, str]]
    """What each step has output, by its id."""
    codes: dict[str, int]
    stated: dict[str, str]
    """What each step printed."""

    @property
    def report(self) -> Path:
        return Path(self.outputs["check"]["folder"]) / "report"


def github_job(folder: Path, given: dict[str, str], focus: str) -> Job:
    """Take the shell steps of the action as a runner would, in a checkout."""
    assert set(given) <= set(ACTION["inputs"]), "the workflow gives what the action does not take"
    temporary = folder.with_name(f"{folder.name}-temp")
    temporary.mkdir()
    inputs = {name: str(known["default"]) for name, known in ACTION["inputs"].items()} | given
    values = {f"inputs.{name}": value for name, value in inputs.items()}
    values |= {"runner.temp": str(temporary), "runner.os": "Linux", "github.action_path": str(ROOT)}
    values["github.event.repository.default_branch"] = "main"
    # Everything is compiled here already.
    values["steps.earlier.outputs.cache-hit"] = "true"
    values["steps.check.outputs.folder"] = values["steps.tests.outputs.folder"] = ""
    files = {f"GITHUB_{name}": str(temporary / name) for name in ("OUTPUT", "ENV", "STEP_SUMMARY")}
    runner = {"GITHUB_WORKSPACE": str(folder), "RUNNER_TEMP": str(temporary), "GITHUB_SHA": COMMIT}
    job = Job(folder, temporary, {}, {}, {})
    for step in ACTION["runs"]["steps"]:
        if "run" not in step:
            continue
        if any(code for name, code in job.codes.items() if name != INSTALL) and "always()" not in step.get(
            "if", ""
        ):
            continue
        if not eval(filled_condition(step.get("if", "True"), values)):
            continue
        variables = {name: filled(text, values) for name, text in step.get("env", {}).items()}
        line = step["run"]
        if step["name"] == "Check the controller":
            line = line.replace("--fail-on", f"{focus} --fail-on")
        (temporary / "OUTPUT").unlink(missing_ok=True)
        ended = ran(line, Path(filled(step["working-directory"], values)), runner | variables | files)
        job.codes[step["name"]] = ended.returncode
        job.stated[step["name"]] = ended.stdout + ended.stderr
        if (temporary / "OUTPUT").exists():
            lines = (temporary / "OUTPUT").read_text(encoding="utf-8").splitlines()
            job.outputs[step["id"]] = dict(line.split("=", 1) for line in lines)
            values |= {
                f"steps.{step['id']}.outputs.{name}": text for name, text in job.outputs[step["id"]].items()
            }
    return job


@pytest.fixture(scope="module")
def github(tmp_path_factory: pytest.TempPathFactory) -> Job:
    """The steps for a candidate that fails, in a checkout that means harm."""
    folder = hostile_checkout(tmp_path_factory.mktemp("github"))
    (folder / "tests").mkdir()
    (folder / "tests" / "test_controller.py").write_text(OWN_TEST, encoding="utf-8")
    own = {
        "candidate": CANDIDATE,
        "waivers": "",
        "build": "touch built",
        "tests": "tests",
        "requirements": "",
    }
    return github_job(folder, GITHUB["jobs"]["gate"]["steps"][-1]["with"] | own, FOCUS)


def filled_condition(text: str, values: dict[str, str]) -> str:
    text = text.replace("always()", "True").replace("&&", "and")
    return re.sub(r"(inputs|runner|steps)(\.[a-z-]+)+", lambda found: repr(values[found[0]]), text)


@pytest.mark.nightly
def test_only_the_gate_fails_and_every_other_step_runs(github: Job) -> None:
    shell = [
        step["name"]
        for step in ACTION["runs"]["steps"]
        if "run" in step and "earlier.outputs.cache-hit" not in step.get("if", "")
    ]
    assert list(github.codes) == shell
    failing = ("Check the controller", INSTALL)
    assert github.codes == {name: int(name in failing) for name in shell}, github.stated
    assert (github.folder / "built").exists()


def test_nothing_of_a_checkout_runs_in_any_step(github: Job, tmp_path: Path) -> None:
    assert hostile_that_ran(github.folder) == []
    assert "No matching distribution" in github.stated[INSTALL], "pip was to look for the packages"
    # In the checkout, the same files do run.
    hostile_checkout(tmp_path)
    for line in (
        "python -m pip --version",
        "python -m drivegate.gate.warm_up",
        "python -c 'import click, numba'",
    ):
        ran(line, tmp_path, {})
    assert {"pip.ran", "drivegate.ran", "click.ran", "numba.ran"} <= set(hostile_that_ran(tmp_path))


def test_every_step_works_outside_of_the_checkout_without_its_modules() -> None:
    for step in ACTION["runs"]["steps"]:
        if "run" in step:
            assert step["working-directory"] == "${{ runner.temp }}", step["name"]
            assert step["env"]["PYTHONSAFEPATH"] == "1", step["name"]
    assert GITLAB[".drivegate"]["variables"]["PYTHONSAFEPATH"] == "1"
    assert "PYTHONSAFEPATH=1" in (ROOT / "Dockerfile").read_text(encoding="utf-8")


def test_actions_of_others_are_named_by_their_commits_and_credentials_do_not_stay() -> None:
    used = [step for step in (*ACTION["runs"]["steps"], *GITHUB["jobs"]["gate"]["steps"]) if "uses" in step]
    others = [step for step in used if not step["uses"].startswith("./")]
    assert all(re.fullmatch(r"actions/[a-z/-]+@[0-9a-f]{40}", step["uses"]) for step in others), others
    (checkout,) = (step for step in others if step["uses"].startswith("actions/checkout@"))
    assert checkout["with"]["persist-credentials"] is False


def test_what_is_installed_has_its_version_and_hash() -> None:
    text = REQUIREMENTS.read_text(encoding="utf-8")
    entries = re.split(r"\n(?=[a-z])", re.sub(r"^#.*\n", "", text, flags=re.MULTILINE).strip())
    pinned: dict[str, list[str]] = {}
    for entry in entries:
        assert re.search(r"--hash=sha256:[0-9a-f]{64}", entry), entry
        found = re.match(r"([a-z0-9-]+)==([^ ;]+)", entry)
        assert found, entry
        pinned.setdefault(found[1], []).append(found[2])
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    extras = project["project"]["optional-dependencies"]
    wanted = [
        *project["project"]["dependencies"],
        *project["build-system"]["requires"],
        *extras["coverage"],
        *extras["elf"],
        "pytest>=9.0",
    ]
    for requirement in map(Requirement, wanted):
        versions = pinned[requirement.name]
        assert all(requirement.specifier.contains(version) for version in versions), requirement
    for line in (
        *GITLAB[".drivegate"]["before_script"],
        *(s.get("run", "") for s in ACTION["runs"]["steps"]),
    ):
        for command in re.findall(r"pip install .*", line):
            assert (
                "--require-hashes --only-binary :all:" in command
                or "--no-deps --no-build-isolation" in command
            )


def test_failures_are_annotated_and_the_summary_is_shown(github: Job) -> None:
    shown = (github.temporary / "STEP_SUMMARY").read_text(encoding="utf-8")
    assert shown.startswith("# published: fail")
    printed = github.stated["Annotate what failed, and show the summary"]
    result = json.loads((github.report / "result.json").read_text(encoding="utf-8"))
    failed = {
        check["id"]
        for check in result["checks"]
        if (check["level"], check["verdict"]) == ("required", "fail")
    }
    assert set(re.findall(r"^::error title=published (\S+) fail::.", printed, re.MULTILINE)) == failed
    assert failed, "the candidate fails"


def test_the_seed_comes_from_the_commit_and_is_stated(github: Job) -> None:
    result = json.loads((github.report / "result.json").read_text(encoding="utf-8"))
    assert result["seed"] == int(SEED)
    assert f"--seed {SEED} repeats this check" in github.stated["Check the controller"]


def test_report_and_junit_are_kept_whatever_comes(github: Job) -> None:
    names = [step.get("name") for step in ACTION["runs"]["steps"]]
    for name, folder in (
        ("Keep report and JUnit", "check"),
        ("Keep results of the controller's own tests", "tests"),
    ):
        kept = ACTION["runs"]["steps"][names.index(name)]
        assert "upload-artifact" in kept["uses"]
        assert kept["if"].startswith("always()"), "a failure hides its report"
        assert kept["with"]["path"].startswith(f"${{{{ steps.{folder}.outputs.folder }}}}")
    assert names.index("Keep report and JUnit") < names.index("Run the controller's own tests"), (
        "tests could change it"
    )
    assert github.report.parent.parent == github.temporary, "the report is not outside of the checkout"
    assert (github.report / "report.html").is_file()
    assert ElementTree.parse(github.report / "junit.xml").getroot().findall(".//failure")
    tests = ElementTree.parse(Path(github.outputs["tests"]["folder"]) / "pytest.xml").getroot()
    assert tests.find("testsuite").get("tests") == "1"  # type: ignore[union-attr]


@pytest.mark.nightly
def test_a_committed_report_is_not_taken_for_the_one_of_a_refused_check(tmp_path: Path) -> None:
    folder = hostile_checkout(tmp_path / "checkout")
    job = github_job(folder, {"candidate": "none.toml"}, "")
    assert job.codes["Check the controller"] == 2
    assert job.codes["Annotate what failed, and show the summary"] == 0
    assert "forged" not in "".join(job.stated.values())
    assert not (job.temporary / "STEP_SUMMARY").exists()
    assert not job.report.exists()


def gitlab_ran(checkout: Path, *lines: str, code: int = 0) -> subprocess.CompletedProcess[str]:
    """Run the lines of a job after those that come before them, in one shell, without installing."""
    subprocess.run(["git", "init", "--quiet"], cwd=checkout, check=True)
    subprocess.run(["git", "add", "--all"], cwd=checkout, check=True)
    variables = GITLAB[".drivegate"]["variables"] | GITLAB["gate"]["variables"]
    variables |= {"CI_PROJECT_DIR": str(checkout), "CI_COMMIT_SHA": COMMIT}
    before = [
        f"{line} || true" if "pip install" in line else line for line in GITLAB[".drivegate"]["before_script"]
    ]
    ended = ran("\n".join([*before, *lines]), checkout, variables)
    assert ended.returncode == code, ended.stdout + ended.stderr
    return ended


def test_gitlab_shows_nothing_that_was_committed(tmp_path: Path) -> None:
    checkout = hostile_checkout(tmp_path / "checkout")
    gitlab_ran(checkout, *GITLAB["kernels"]["script"], *GITLAB["gate"]["script"], code=2)
    assert hostile_that_ran(checkout) == []
    assert not (checkout / "drivegate-report").exists()
    (checkout / ".drivegate-cache").mkdir()
    (checkout / ".drivegate-cache" / "kernel.nbc").touch()
    gitlab_ran(checkout, code=1)


def caching_steps(name: str) -> list[dict[str, Any]]:
    """The steps that restore and save the folder which the step of that name states."""
    return [
        step for step in ACTION["runs"]["steps"] if f"steps.{name}.outputs.folder" in str(step.get("with"))
    ]


def test_kernels_are_kept_under_a_key_of_what_they_are(github: Job) -> None:
    cached = caching_steps("kernels")
    assert github.outputs["kernels"]["key"] == cache_key()
    assert github.outputs["kernels"]["folder"] in (github.temporary / "ENV").read_text(encoding="utf-8")
    assert [step["uses"].split("@")[0] for step in cached] == ["actions/cache/restore", "actions/cache/save"]
    assert all("steps.kernels.outputs.key" in step["with"]["key"] for step in cached)


def test_what_later_jobs_load_is_stored_before_any_code_of_the_controller_runs() -> None:
    names = [step.get("name") for step in ACTION["runs"]["steps"]]
    first = names.index("Build the controller")
    assert first < names.index("Check the controller")
    for cache in ("kernels", "pip"):
        restored, saved = caching_steps(cache)
        assert restored["uses"].startswith("actions/cache/restore@")
        assert saved["uses"].startswith("actions/cache/save@")
        assert names.index(saved["name"]) < first
        assert restored["with"] == saved["with"]
    assert GITLAB["gate"]["cache"]["policy"] == "pull"
    assert "candidate" not in " ".join(GITLAB["kernels"]["script"])
    commands = [
        *GITLAB["kernels"]["script"],
        ACTION["runs"]["steps"][names.index("Compile the plant")]["run"],
    ]
    for command in commands:
        assert command == "python -m drivegate.gate.warm_up"


def test_one_workflow_and_one_action(tmp_path: Path) -> None:
    write_candidate("c", "mine", tmp_path / "mine", datetime.now(UTC).date())
    workflow = yaml.safe_load((tmp_path / "mine/.github/workflows/drivegate.yml").read_text(encoding="utf-8"))
    assert workflow == GITHUB, (
        "docs/continuous_integration.md shows another workflow than drivegate new writes"
    )
    action = (tmp_path / "mine/.github/actions/drivegate/action.yml").read_text(encoding="utf-8")
    assert action == (ROOT / "action.yml").read_text(encoding="utf-8")
    given = workflow["jobs"]["gate"]["steps"][-1]
    assert (tmp_path / "mine" / given["uses"] / "action.yml").is_file()
    assert workflow["jobs"]["gate"]["timeout-minutes"] >= 10
    # The check is in the gate already; its tests would run it a second time.
    assert "tests" not in given["with"]
    for name in ("candidate", "install", "requirements", "waivers"):
        assert (tmp_path / "mine" / given["with"][name]).is_file(), f"'{name}' names what is not there"


def test_no_input_gets_into_a_script_but_as_a_variable() -> None:
    for step in ACTION["runs"]["steps"]:
        assert "${{" not in step.get("run", ""), f"{step['name']} pastes an expression into a shell"
        assert "run" not in step or step["shell"] == "bash", "a composite action must name the shell"


def words_of_the_check(
    folder: Path, variables: dict[str, str], program: str = 'printf "%s\\n" "$@"'
) -> list[str]:
    """Return the arguments that the step of the check starts drivegate with, and at last its exit code."""
    step = next(step for step in ACTION["runs"]["steps"] if step.get("name") == "Check the controller")
    empty = dict.fromkeys(step["env"], "")
    runner = {"RUNNER_TEMP": str(folder), "GITHUB_WORKSPACE": "/checkout", "GITHUB_SHA": COMMIT}
    usual = {
        "MAIN": "main",
        "GITHUB_REF_NAME": "main",
        "MINUTES": "1",
        "GITHUB_OUTPUT": str(folder / "output"),
    }
    (folder / "bin").mkdir()
    (folder / "bin" / "drivegate").write_text(f"#!/bin/sh\n{program}\n", encoding="utf-8")
    (folder / "bin" / "drivegate").chmod(0o755)
    line = f'PATH="{folder}/bin:$PATH"\n{step["run"].replace("--kill-after 60", "--kill-after 1")}'
    ended = ran(line, folder, empty | usual | runner | variables)
    return [*ended.stdout.splitlines(), str(ended.returncode)]


def test_what_is_given_reaches_the_check(tmp_path: Path) -> None:
    given = {
        "DRIVE": "my drive.toml",
        "BASELINE": "b.json",
        "SEED": "7",
        "WAIVERS": "w.toml",
        "COVERAGE": "100,95",
        "CANDIDATE": "a b.toml",
    }
    words = words_of_the_check(tmp_path, given)
    assert words[:4] == ["-C", "/checkout", "check", "a b.toml"]
    for name, word in (
        ("drive", "my drive.toml"),
        ("baseline", "b.json"),
        ("seed", "7"),
        ("waivers", "w.toml"),
        ("coverage-at-least", "100,95"),
    ):
        assert words[words.index(f"--{name}") + 1] == word


def test_each_folder_of_the_input_root_reaches_the_check(tmp_path: Path) -> None:
    words = words_of_the_check(tmp_path, {"ROOT": "shared code:/opt/tables"})
    assert [words[at + 1] for at, word in enumerate(words) if word == "--root"] == [
        "shared code",
        "/opt/tables",
    ]


def test_a_check_that_stands_still_is_ended_and_said_to_be(tmp_path: Path) -> None:
    *_, said, code = words_of_the_check(tmp_path, {"MINUTES": "0.01"}, "kill -STOP $$")
    assert code in ("124", "137")
    assert said.startswith("::error title=drivegate::the check was ended after 0.01 minutes")


@pytest.mark.parametrize(
    ("given", "branch", "drawn"),
    [
        ("", "main", "default"),
        ("", "7/merge", "quick"),
        ("nightly", "main", "nightly"),
        ("quick", "main", "quick"),
    ],
)
def test_the_main_branch_is_checked_with_more_scenarios_than_a_pull_request(
    given: str, branch: str, drawn: str, tmp_path: Path
) -> None:
    words = words_of_the_check(tmp_path, {"EFFORT": given, "GITHUB_REF_NAME": branch})
    assert words[words.index("--effort") + 1] == drawn
    rules = GITLAB["gate"]["rules"]
    assert (GITLAB["gate"]["variables"], rules[0]["variables"]) == (
        {"EFFORT": "quick", "COVERAGE": ""},
        {"EFFORT": "default"},
    )


def test_the_documentation_lists_the_inputs() -> None:
    text = (DOCS / "continuous_integration.md").read_text(encoding="utf-8")
    rows = dict(re.findall(r"^\| `([a-z-]+)` \| (.+?) \|", text, re.MULTILINE))
    assert list(rows) == list(ACTION["inputs"])
    for name, known in ACTION["inputs"].items():
        assert rows[name] == f"`{known['default']}`" or not known["default"], name


@pytest.mark.nightly
def test_gitlab_checks_the_same_and_finds_junit(tmp_path: Path) -> None:
    shared, job = GITLAB[".drivegate"], GITLAB["gate"]
    (checks,) = job["script"]
    write_candidate("c", "mine", tmp_path / "mine", datetime.now(UTC).date(), "paper-5-phase")
    for name in ("DRIVEGATE", "REQUIREMENTS"):
        assert (tmp_path / "mine" / shared["variables"][name]).is_file()
    assert job["cache"]["key"]["files"] == [shared["variables"]["DRIVEGATE"]]
    # One worker, since the other processor has tests of its own. The first push must be green.
    gitlab_ran(tmp_path / "mine", f"{checks} --workers 1")
    report = tmp_path / "mine" / "drivegate-report"
    result = json.loads((report / "result.json").read_text(encoding="utf-8"))
    assert result["seed"] == int(SEED)
    waived = [check["id"] for check in result["checks"] if check["verdict"] == "waived"]
    assert waived == [waiver.check for waiver in read_waivers(report.with_name("waivers.toml"), ["mine"])]
    junit = ElementTree.parse(tmp_path / "mine" / job["artifacts"]["reports"]["junit"])
    assert junit.getroot().findall(".//testcase")
    assert job["artifacts"]["when"] == "always"


def test_the_image_is_given_all_that_the_package_is_made_of() -> None:
    text = (ROOT / "Dockerfile").read_text(encoding="utf-8")
    copied = {
        name for line in re.findall(r"^COPY (.+) /source\S*$", text, re.MULTILINE) for name in line.split()
    }
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    wheel = project["tool"]["hatch"]["build"]["targets"]["wheel"]
    needed = {path.split("/")[0] for path in wheel["packages"]} | {project["project"]["readme"]}
    assert copied == needed | {"pyproject.toml", "hatch_build.py", *project["project"]["license-files"]}
    assert all((ROOT / name).exists() for name in copied)
    assert "RUN python -m drivegate.gate.warm_up" in text, "the image has no compiled plant"


def test_a_real_result_keeps_to_the_published_schema(github: Job) -> None:
    schema = json.loads((DOCS / "schemas" / "result.schema.json").read_text(encoding="utf-8"))
    result = json.loads((github.report / "result.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(schema).validate(result)
    failed = [check for check in result["checks"] if check["counterexample"] is not None]
    assert failed, "the candidate fails"
    for check in failed:
        signals = result["traces"][check["recording"]["trace"]]
        assert len(signals["time_s"]) == len(signals["speed_rpm"]) > 100, f"{check['id']} has no signals"
        assert check["margins"] == sorted(check["margins"]), f"the margins of {check['id']} are out of order"
        assert check["margins"][0] < 0.0, f"{check['id']} fails"


def test_a_real_result_is_verified_by_a_later_job(github: Job, tmp_path: Path) -> None:
    def ended(*words: str) -> subprocess.CompletedProcess[str]:
        program = [sys.executable, "-c", "from drivegate.commands.command_line import main; main()"]
        return subprocess.run(
            [*program, *words], cwd=tmp_path, check=False, capture_output=True, text=True, timeout=120
        )

    result = str(github.report / "result.json")
    made = ended("report", result, "--format", "markdown", "--output", "again")
    assert made.returncode == 0, made.stderr
    verify = ("verify", "again/result.json")
    verified = ended(*verify)
    assert verified.returncode == 0, verified.stdout + verified.stderr
    assert "published: fail\nunchanged: the content fits its hash" in verified.stdout
    again = tmp_path / "again" / "result.json"
    text = again.read_text(encoding="utf-8")
    assert text.count('"verdict": "fail"') > 0
    again.write_text(text.replace('"verdict": "fail"', '"verdict": "pass"', 1), encoding="utf-8")
    assert ended(*verify).returncode == 1, "a verdict that was altered must not be verified"


def test_every_row_about_pull_requests_has_its_tests() -> None:
    page = (DOCS / "containment.md").read_text(encoding="utf-8")
    rows = page.partition("| a pull request |")[2].partition("\n\n")[0].splitlines()[2:]
    named = [re.search(r"\| `(\S+\.py)` \|$", row) for row in rows]
    assert [row for row, found in zip(rows, named, strict=True) if found is None] == rows[-1:]
    assert all((ROOT / "tests/harness" / found[1]).is_file() for found in named if found)


def test_the_hook_of_pre_commit_is_one_that_there_is() -> None:
    (hook,) = yaml.safe_load((ROOT / ".pre-commit-hooks.yaml").read_text(encoding="utf-8"))
    assert [used["id"] for used in HOOK["repos"][0]["hooks"]] == [hook["id"]]
    words = [*hook["entry"].split(), *hook["args"]]
    context = check_command.make_context("check", words[2:], resilient_parsing=True)
    assert (words[:2], context.params["effort"]) == (["drivegate", "check"], "quick")
