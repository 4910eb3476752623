"""Libraries that a candidate's own project builds, by the commands of its manifest."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from drivegate.candidates.candidate import Candidate, NativeBuild
from drivegate.candidates.kinds import load_controller
from drivegate.candidates.native.build_commands import BUILD, ProjectBuild, built_artefact
from drivegate.candidates.resolution import resolve_candidate
from drivegate.containment.judge import Judge
from drivegate.containment.messages import Job, JudgedCandidate
from drivegate.isolation.layers import available_layers, roots_named
from drivegate_models.errors import InputError

SCRIPT = """set -e
test ! -e notes.txt
mkdir out
cc -shared -fPIC -I"$(drivegate include-dir)" -o out/mine.so mine.c -lm
"""


@pytest.fixture
def project(tmp_path: Path, controller_source: Callable[..., str]) -> Callable[..., Path]:
    """Write a project, with a manifest of the given keys."""

    def make(**keys: object) -> Path:
        folder = tmp_path / "project"
        folder.mkdir()
        (folder / "mine.c").write_text(controller_source(), encoding="utf-8")
        (folder / "build.sh").write_text(SCRIPT, encoding="utf-8")
        (folder / "notes.txt").write_text("of no concern", encoding="utf-8")
        usual = {
            "schema": 1,
            "name": "mine",
            "kind": "so",
            "entry": "out/mine.so",
            "build": ["sh build.sh"],
            "sources": ["mine.c", "build.sh"],
        }
        manifest = folder / "candidate.toml"
        lines = [f"{key} = {json.dumps(value)}" for key, value in (usual | keys).items() if value is not None]
        manifest.write_text("\n".join(lines), encoding="utf-8")
        return manifest

    return make


def library_of(candidate: Candidate) -> Path:
    assert isinstance(candidate.details, NativeBuild)
    return candidate.details.library


def state_size(loaded: JudgedCandidate, _: None) -> int:
    return int(loaded.controller().state_size)


def test_a_library_is_built_from_its_sources_alone_and_again_only_when_they_change(
    project: Callable[..., Path],
) -> None:
    manifest = project()
    before = {path: path.stat().st_mtime_ns for path in manifest.parent.rglob("*")}
    first = resolve_candidate(str(manifest))
    assert {path: path.stat().st_mtime_ns for path in manifest.parent.rglob("*")} == before
    built = library_of(first).stat().st_mtime_ns
    with Judge(first) as judge:
        assert judge.once(Job(state_size, None)) == 16
    again = resolve_candidate(str(manifest))
    assert (library_of(again), again.content_hash) == (library_of(first), first.content_hash)
    assert library_of(again).stat().st_mtime_ns == built
    source = manifest.with_name("mine.c")
    source.write_text(source.read_text().replace("int64_t steps;", "int64_t steps, more;"), encoding="utf-8")
    changed = resolve_candidate(str(manifest))
    assert changed.content_hash != first.content_hash
    assert load_controller(changed).state_size == 24  # type: ignore[attr-defined]


def test_sources_outside_of_the_folder_lie_where_the_project_expects_them(
    project: Callable[..., Path],
) -> None:
    manifest = project(
        build=["cp ../common/mine.c .", "sh build.sh"], sources=["build.sh", "../common/mine.c"]
    )
    common = manifest.parents[1] / "common"
    common.mkdir()
    manifest.with_name("mine.c").rename(common / "mine.c")
    with roots_named([str(common)]):
        assert load_controller(resolve_candidate(str(manifest))).state_size == 16  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        (
            {"build": ["sh -c 'echo first; echo mine.c:7: no semicolon >&2; exit 3'"]},
            r"candidate.toml: the build command 'sh -c .*' ended with status 3: first \| mine.c:7: no semicolon; its "
            r"output is in .*\.txt; a build has the files of 'sources', no network and 600 s",
        ),
        ({"build": ["sh build.sh"], "sources": ["build.sh"]}, r"ended with status 1: .*mine.c"),
        ({"build": ["cargoo build"]}, r"needs the program 'cargoo', which is missing; install it"),
        ({"build": ["true"]}, r"the commands of 'build' made no file 'out/mine.so'; name in 'entry'"),
        (
            {"build": ["mkdir out", "ln -s /bin/true out/mine.so"]},
            r"the commands of 'build' made no file 'out/mine.so'",
        ),
        ({"build": ["sh 'build.sh"]}, r"which is no command line: No closing quotation"),
        ({"entry": "../mine.so"}, r"'../mine.so', which leads out of the manifest's folder"),
        ({"sources": None}, r"the key 'build' needs 'sources'"),
        (
            {"kind": "c", "entry": "a.c"},
            r"the key 'build' is for the kinds 'so', 'elf' and 'fmu', but the kind is",
        ),
    ],
)
def test_what_cannot_be_built_is_one_sentence(
    project: Callable[..., Path], keys: dict[str, object], sentence: str
) -> None:
    with pytest.raises(InputError, match=sentence):
        resolve_candidate(str(project(**keys)))


def test_of_a_long_output_the_last_lines_are_shown(project: Callable[..., Path]) -> None:
    noise = "i=0; while [ $i -lt 9000 ]; do echo a line of some length $i; i=$((i+1)); done; exit 1"
    with pytest.raises(InputError, match=r"length 8998 \| a line of some length 8999; its output"):
        resolve_candidate(str(project(build=[f"sh -c '{noise}'"])))


def test_a_build_is_isolated(project: Callable[..., Path], tmp_path: Path) -> None:
    assert available_layers(), "this machine isolates nothing"
    secret = tmp_path / "secret"
    secret.write_text("of others", encoding="utf-8")
    with pytest.raises(InputError, match=r"ended with status 1: cat: .*secret"):
        resolve_candidate(str(project(build=[f"cat {secret}"])))


def test_a_build_ends_in_time(project: Callable[..., Path]) -> None:
    folder = project().parent
    bounds = replace(BUILD, seconds=0.5)
    endless = ProjectBuild("mine.toml", folder, ("sleep 60",), (folder / "mine.c",), "out/mine.so", bounds)
    with pytest.raises(InputError, match=r"'sleep 60' did not come to an end; a build has .* and 0.5 s"):
        built_artefact(endless)
