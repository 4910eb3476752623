"""The instruction set that kernels are compiled for, and operations that it may not fuse."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

from drivegate_models.compilation import target
from drivegate_models.compilation.kernels import cache_key, inlined, kernel, unallocating

_V3 = dict.fromkeys(
    ["avx", "avx2", "bmi", "bmi2", "cx16", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sse4.2", "avx512f"],
    True,
)


@pytest.mark.parametrize(
    ("machine", "features", "stated"),
    [
        ("x86_64", _V3, "x86-64-v3"),
        ("AMD64", _V3, "x86-64-v3"),
        ("x86_64", {**_V3, "fma": False}, "x86-64"),
        ("x86_64", {}, "x86-64"),
        ("aarch64", {"neon": True}, "generic"),
    ],
)
def test_the_target_is_one_of_few(
    monkeypatch: pytest.MonkeyPatch, machine: str, features: dict[str, bool], stated: str
) -> None:
    monkeypatch.setattr(target.platform, "machine", lambda: machine)
    monkeypatch.setattr("llvmlite.binding.get_host_cpu_features", lambda: features)
    assert target.stated_target() == stated


def _compiled_for(first: str, **asked: str) -> str:
    """Tell what a process compiles for that imports something before drivegate, with some variables set."""
    command = (
        f"{first}; from drivegate_models.compilation import kernels; from numba.core.registry import cpu_target; "
        "print(*cpu_target.target_context.codegen().magic_tuple()[1:3])"
    )
    surroundings = {name: value for name, value in os.environ.items() if name not in target.VARIABLES}
    done = subprocess.run(
        [sys.executable, "-c", command],
        env=surroundings | asked,
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    return done.stdout.strip()


@pytest.mark.parametrize("first", ["import sys", "import numba"])
def test_a_process_compiles_for_the_stated_target(first: str) -> None:
    assert _compiled_for(first) == target.stated_target()


def test_a_target_of_the_users_own_is_kept() -> None:
    assert _compiled_for("import sys", NUMBA_CPU_NAME="generic") == "generic"


def test_each_target_has_a_cache_folder_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    keys = set()
    for name in ("x86-64", "x86-64-v3"):
        monkeypatch.setenv("NUMBA_CPU_NAME", name)
        keys.add(cache_key())
    assert len(keys) == 2, "the marker of one target would stand for kernels of another"


@pytest.mark.kernel
@pytest.mark.parametrize("decorator", [kernel, unallocating, inlined])
def test_a_product_is_rounded_before_it_is_added(decorator) -> None:  # type: ignore[no-untyped-def]
    # (1 + e)(1 - e) is 1 - e**2, which a product of its own rounds to 1.
    difference = decorator(_product_less_one)(1.0 + 2.0**-30, 1.0 - 2.0**-30)
    assert difference == 0.0, f"product and sum were rounded at once, which leaves {difference!r}"


def _product_less_one(a: float, b: float) -> float:
    return a * b - 1.0
