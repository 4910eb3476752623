"""The recipes for CI servers: their shell lines run, and what they leave is what the servers are configured to take."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey
from cryptography.hazmat.primitives.serialization import Encoding, NoEncryption, PrivateFormat, PublicFormat

DOCS = Path(__file__).parents[3] / "docs"
INSTALLS = 'python -m pip install "$DRIVEGATE"'
"""The one line that is not run: what it would install is what these tests run in."""


def recipes() -> list[dict[str, Any]]:
    text = (DOCS / "continuous_integration.md").read_text(encoding="utf-8")
    return [yaml.safe_load(block) for block in re.findall(r"```yaml\n(.*?)```", text, flags=re.DOTALL)]


GITHUB, GITLAB = recipes()


def run_lines(lines: list[str], folder: Path, variables: dict[str, str]) -> Iterator[str]:
    assert lines[0] == INSTALLS, "a recipe begins with the installation"
    environment = os.environ | variables | {"CANDIDATE": "published", "GITHUB_STEP_SUMMARY": "shown.md"}
    environment["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{environment['PATH']}"
    # The cache of this machine: the recipe's own would have everything compiled once more.
    environment.pop("DRIVEGATE_CACHE", None)
    if "DRIVEGATE_CACHE" in os.environ:
        environment["DRIVEGATE_CACHE"] = os.environ["DRIVEGATE_CACHE"]
    for line in lines[1:]:
        ended = subprocess.run(
            ["bash", "-e", "-c", line],
            check=False,
            cwd=folder,
            env=environment,
            capture_output=True,
            text=True,
            timeout=500,
        )
        failed = line.startswith("drivegate check")
        assert ended.returncode == (1 if failed else 0), f"{line}\n{ended.stderr}"
        yield line


@pytest.fixture(scope="module")
def github(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("github")
    lines = [step["run"] for step in GITHUB["jobs"]["gate"]["steps"] if "run" in step]
    # The candidate is one that fails: the later steps have to run all the same.
    assert len(list(run_lines(lines, folder, GITHUB["env"]))) == 2
    return folder


def test_github_shows_the_summary_and_keeps_the_report(github: Path) -> None:
    assert (github / "shown.md").read_text(encoding="utf-8").startswith("# published: fail")
    steps = GITHUB["jobs"]["gate"]["steps"]
    kept = next(step["with"]["path"] for step in steps if "upload-artifact" in step.get("uses", ""))
    assert (github / kept / "report.html").is_file()
    checked = next(
        place for place, step in enumerate(steps) if step.get("run", "").startswith("drivegate check")
    )
    assert all(step.get("if") == "always()" for step in steps[checked + 1 :]), "a failure hides its report"


def test_gitlab_has_the_same_lines_and_finds_junit(github: Path) -> None:
    lines = [step["run"] for step in GITHUB["jobs"]["gate"]["steps"] if "run" in step]
    assert GITLAB["gate"]["script"] == lines[:2]
    junit = ElementTree.parse(github / GITLAB["gate"]["artifacts"]["reports"]["junit"])
    assert junit.getroot().findall(".//failure"), "the failures are among the test cases"
    assert GITLAB["gate"]["artifacts"]["when"] == "always"


def test_a_real_result_keeps_to_the_published_schema(github: Path) -> None:
    schema = json.loads((DOCS / "schemas" / "result.schema.json").read_text(encoding="utf-8"))
    result = json.loads((github / "drivegate-report" / "result.json").read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(schema).validate(result)
    failed = [check for check in result["checks"] if check["counterexample"] is not None]
    assert failed, "the candidate fails"
    for check in failed:
        signals = result["traces"][check["recording"]["trace"]]
        assert len(signals["time_s"]) == len(signals["speed_rpm"]) > 100, f"{check['id']} has no signals"
        assert check["margins"] == sorted(check["margins"]), f"the margins of {check['id']} are out of order"
        assert check["margins"][0] < 0.0, f"{check['id']} fails"


def test_a_real_result_is_signed_by_a_later_job(github: Path, tmp_path: Path) -> None:
    key = Ed25519PrivateKey.generate()
    private = key.private_bytes(Encoding.PEM, PrivateFormat.PKCS8, NoEncryption())
    (tmp_path / "key.pem").write_bytes(private)
    public = key.public_key().public_bytes(Encoding.PEM, PublicFormat.SubjectPublicKeyInfo)
    (tmp_path / "public.pem").write_bytes(public)

    def ended(*words: str) -> subprocess.CompletedProcess[str]:
        program = [sys.executable, "-c", "from drivegate.commands.command_line import main; main()"]
        return subprocess.run(
            [*program, *words], cwd=tmp_path, check=False, capture_output=True, text=True, timeout=120
        )

    result = str(github / "drivegate-report" / "result.json")
    made = ended("report", result, "--sign", "key.pem", "--format", "markdown", "--output", "signed")
    assert made.returncode == 0, made.stderr
    verify = ("verify", "signed/result.json", "--key", "public.pem")
    verified = ended(*verify)
    assert verified.returncode == 0, verified.stdout + verified.stderr
    assert "published: fail\nvalid: unchanged, and signed by the expected key" in verified.stdout
    signed = tmp_path / "signed" / "result.json"
    text = signed.read_text(encoding="utf-8")
    assert text.count('"verdict": "fail"') > 0
    signed.write_text(text.replace('"verdict": "fail"', '"verdict": "pass"', 1), encoding="utf-8")
    assert ended(*verify).returncode == 1, "a verdict that was altered must not be verified"
