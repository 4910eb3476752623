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

from drivegate.results.waivers import read_waivers
from drivegate.studies.new import write_candidate
from drivegate_models.compilation.kernels import cache_key

ROOT = Path(__file__).parents[3]
DOCS = ROOT / "docs"
INSTALLS = re.compile(r'python -m pip install "\$(DRIVEGATE|INSTALL)"')
"""What begins the one line that is not run: what it would install is what these tests run in."""
CANDIDATE = "published"
"""One that fails: the later steps have to run all the same."""
FOCUS = "--workers 1 --only CPW-1 --stop-at-first"
"""A required check that it fails, in few runs; the other checks take the same way through the recipe."""
OWN_TEST = "def test_nothing():\n    pass\n"


def recipes() -> list[dict[str, Any]]:
    text = (DOCS / "continuous_integration.md").read_text(encoding="utf-8")
    return [yaml.safe_load(block) for block in re.findall(r"```yaml\n(.*?)```", text, flags=re.DOTALL)]


GITHUB, GITLAB = recipes()
ACTION = yaml.safe_load((ROOT / "action.yml").read_text(encoding="utf-8"))


def ran(line: str, folder: Path, variables: dict[str, str]) -> subprocess.CompletedProcess[str]:
    environment = os.environ | variables
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
    outputs: dict[str, str]
    codes: dict[str, int]


@pytest.fixture(scope="module")
def github(tmp_path_factory: pytest.TempPathFactory) -> Job:
    """The shell steps of the action as a runner would take them, for a candidate that fails."""
    folder = tmp_path_factory.mktemp("github")
    (folder / "test_controller.py").write_text(OWN_TEST, encoding="utf-8")
    given = GITHUB["jobs"]["gate"]["steps"][-1]["with"] | {
        "candidate": CANDIDATE,
        "waivers": "",
        "build": "touch built",
        "tests": "test_controller.py",
    }
    assert set(given) <= set(ACTION["inputs"]), "the workflow gives what the action does not take"
    inputs = {name: str(known["default"]) for name, known in ACTION["inputs"].items()} | given
    values = {f"inputs.{name}": value for name, value in inputs.items()}
    values |= {"runner.temp": str(folder / "temp"), "runner.os": "Linux", "github.action_path": str(ROOT)}
    values["github.event.repository.default_branch"] = "main"
    # Everything is compiled here already.
    values["steps.earlier.outputs.cache-hit"] = "true"
    files = {f"GITHUB_{name}": str(folder / name) for name in ("OUTPUT", "ENV", "STEP_SUMMARY")}
    codes: dict[str, int] = {}
    for step in ACTION["runs"]["steps"]:
        if "run" not in step or INSTALLS.match(step["run"]):
            continue
        if any(codes.values()) and "always()" not in step.get("if", ""):
            continue
        if not eval(filled_condition(step.get("if", "True"), values)):
            continue
        variables = {name: filled(text, values) for name, text in step.get("env", {}).items()}
        focus = f" {FOCUS}" if step["name"] == "Check the controller" else ""
        ended = ran(step["run"] + focus, folder, variables | files)
        codes[step["name"]] = ended.returncode
        (folder / f"{step['name']}.out").write_text(ended.stdout + ended.stderr, encoding="utf-8")
    outputs = dict(
        line.split("=", 1) for line in (folder / "OUTPUT").read_text(encoding="utf-8").splitlines()
    )
    return Job(folder, outputs, codes)


def filled_condition(text: str, values: dict[str, str]) -> str:
    text = text.replace("always()", "True").replace("&&", "and")
    return re.sub(r"(inputs|runner|steps)(\.[a-z-]+)+", lambda found: repr(values[found[0]]), text)


def test_only_the_gate_fails_and_every_other_step_runs(github: Job) -> None:
    shell = [
        step["name"]
        for step in ACTION["runs"]["steps"]
        if "run" in step and not INSTALLS.match(step["run"]) and "cache-hit" not in step.get("if", "")
    ]
    stated = {name: (github.folder / f"{name}.out").read_text(encoding="utf-8") for name in github.codes}
    assert list(github.codes) == shell
    assert github.codes == {name: int(name == "Check the controller") for name in shell}, stated
    assert (github.folder / "built").exists()


def test_failures_are_annotated_and_the_summary_is_shown(github: Job) -> None:
    shown = (github.folder / "STEP_SUMMARY").read_text(encoding="utf-8")
    assert shown.startswith("# published: fail")
    printed = (github.folder / "Annotate what failed, and show the summary.out").read_text(encoding="utf-8")
    result = json.loads((github.folder / "drivegate-report" / "result.json").read_text(encoding="utf-8"))
    failed = {
        check["id"]
        for check in result["checks"]
        if (check["level"], check["verdict"]) == ("required", "fail")
    }
    assert set(re.findall(r"^::error title=published (\S+) fail::.", printed, re.MULTILINE)) == failed
    assert failed, "the candidate fails"


def test_report_and_junit_are_kept_whatever_comes(github: Job) -> None:
    kept = ACTION["runs"]["steps"][-1]
    assert "upload-artifact" in kept["uses"]
    assert kept["if"] == "always()", "a failure hides its report"
    folder = github.folder / filled(
        kept["with"]["path"], {"inputs.report": ACTION["inputs"]["report"]["default"]}
    )
    assert (folder / "report.html").is_file()
    assert ElementTree.parse(folder / "junit.xml").getroot().findall(".//failure")
    assert ElementTree.parse(folder / "pytest.xml").getroot().find("testsuite").get("tests") == "1"  # type: ignore[union-attr]


def caching_steps(name: str) -> list[dict[str, Any]]:
    """The steps that restore and save the folder which the step of that name states."""
    return [
        step for step in ACTION["runs"]["steps"] if f"steps.{name}.outputs.folder" in str(step.get("with"))
    ]


def test_kernels_are_kept_under_a_key_of_what_they_are(github: Job) -> None:
    cached = caching_steps("kernels")
    assert github.outputs["key"] == cache_key()
    assert github.outputs["folder"] in (github.folder / "ENV").read_text(encoding="utf-8")
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
    done = ran(commands[0], ROOT, {})
    assert done.returncode == 0, done.stderr


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
    for name in ("candidate", "install", "waivers"):
        assert (tmp_path / "mine" / given["with"][name]).is_file(), f"'{name}' names what is not there"


def test_no_input_gets_into_a_script_but_as_a_variable() -> None:
    for step in ACTION["runs"]["steps"]:
        assert "${{" not in step.get("run", ""), f"{step['name']} pastes an expression into a shell"
        assert "run" not in step or step["shell"] == "bash", "a composite action must name the shell"


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
    step = next(step for step in ACTION["runs"]["steps"] if step.get("name") == "Check the controller")
    variables = {"EFFORT": given, "MAIN": "main", "GITHUB_REF_NAME": branch, "WAIVERS": ""}
    shown = ran(f'drivegate() {{ echo "$4"; }}; {step["run"]}', tmp_path, variables)
    assert shown.stdout.strip() == drawn
    rules = GITLAB["gate"]["rules"]
    assert (GITLAB["gate"]["variables"], rules[0]["variables"]) == (
        {"EFFORT": "quick"},
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
    (installs,), (checks,) = shared["before_script"], job["script"]
    assert INSTALLS.fullmatch(installs)
    write_candidate("c", "mine", tmp_path / "mine", datetime.now(UTC).date(), "paper-5-phase")
    assert (tmp_path / "mine" / shared["variables"]["DRIVEGATE"]).is_file()
    assert job["cache"]["key"]["files"] == [shared["variables"]["DRIVEGATE"]]
    # One worker, since the other processor has tests of its own.
    ended = ran(f"{checks} --workers 1", tmp_path / "mine", shared["variables"] | job["variables"])
    assert ended.returncode == 0, f"the first push must be green: {ended.stdout}{ended.stderr}"
    report = tmp_path / "mine" / "drivegate-report"
    result = json.loads((report / "result.json").read_text(encoding="utf-8"))
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
    result = json.loads((github.folder / "drivegate-report" / "result.json").read_text(encoding="utf-8"))
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

    result = str(github.folder / "drivegate-report" / "result.json")
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
