"""The registry of kinds: every row has its folder, and only what is needed of it is imported."""

import inspect
import subprocess
import sys
from importlib import import_module
from itertools import chain

import pytest

from drivegate.candidates.kinds import KINDS, Kind
from drivegate.candidates.manifest import Manifest

HEAVY = ("numba", "numpy", "pydantic", "fmpy")


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_the_folder_of_a_kind_has_what_its_row_promises(kind: Kind) -> None:
    resolution, loading = (
        import_module(f"drivegate.candidates.{kind.folder}.{name}") for name in ("resolution", "loading")
    )
    assert [*inspect.signature(resolution.from_manifest).parameters] == [
        "manifest",
        "specification",
        "reach",
    ]
    assert [*inspect.signature(loading.load_controller).parameters] == ["candidate"]
    assert hasattr(loading, "compile_own_code") == kind.compiles_own_code
    if kind.ways or kind.prefixes or kind.suffixes:
        assert [*inspect.signature(resolution.from_text).parameters] == ["specification"]


def test_no_two_kinds_claim_the_same_strings_and_a_manifest_has_every_key() -> None:
    prefixes = [*chain.from_iterable(kind.prefixes for kind in KINDS.values())]
    suffixes = [*chain.from_iterable(kind.suffixes for kind in KINDS.values())]
    keys = {*chain.from_iterable(kind.manifest_keys for kind in KINDS.values())}
    for claimed in (prefixes, suffixes):
        assert len(set(claimed)) == len(claimed)
    assert not [
        pair
        for pair in zip(sorted(prefixes), sorted(prefixes)[1:], strict=False)
        if pair[1].startswith(pair[0])
    ]
    assert keys <= set(Manifest.model_fields)


@pytest.mark.parametrize(
    ("text", "folder"), [("reference", "builtin"), ("exec:true", "program"), ("json:JSONDecoder", "python")]
)
def test_resolving_imports_the_code_of_one_kind_and_nothing_heavy(text: str, folder: str) -> None:
    program = (
        "import sys\n"
        "from drivegate.candidates.resolution import resolve_candidate\n"
        f"resolve_candidate({text!r})\n"
        "print(*(name for name in sys.modules if name.startswith('drivegate.candidates.')))\n"
        f"assert not set({HEAVY}) & set(sys.modules), sys.modules\n"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    resolving = {name.split(".")[2] for name in ended.stdout.split() if name.endswith(".resolution")}
    assert resolving == {folder, "resolution"}
    assert not [name for name in ended.stdout.split() if name.endswith(".loading")]
