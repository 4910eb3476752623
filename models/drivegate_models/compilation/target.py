"""The instruction set that kernels are compiled for: one that is stated, not that of the processor at hand.

A processor's own name would let the compiler choose instructions, widths and so speeds by machine, and would make
kept kernels of one machine useless on the next. Results do not depend on the target, since no operation is fused
with another or reordered; a result tells it all the same.
"""

from __future__ import annotations

import os
import platform
from typing import Any, Final

VARIABLES: Final = ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")
"""numba's environment variables for name and further features of the target."""

_V3: Final = "x86-64-v3"
_V3_FEATURES: Final = frozenset(
    ["avx", "avx2", "bmi", "bmi2", "cx16", "f16c", "fma", "lzcnt", "movbe", "popcnt", "sse4.2"]
)
_BASELINES: Final = {"x86_64": "x86-64", "amd64": "x86-64"}


def stated_target() -> str:
    """Return LLVM's name of the target for a machine like this one."""
    baseline = _BASELINES.get(platform.machine().lower())
    if baseline is None:
        return "generic"
    # A library of many megabytes, which only who compiles has to load.
    from llvmlite.binding import get_host_cpu_features

    features = get_host_cpu_features()
    return _V3 if all(features.get(name) for name in _V3_FEATURES) else baseline


def choose_target() -> None:
    """Ask numba for the stated target where the user has asked for none, before it is imported."""
    if not any(name in os.environ for name in VARIABLES):
        os.environ.update(zip(VARIABLES, (stated_target(), ""), strict=True))


def requested_target() -> str:
    """Return what kernels are compiled for here and in every worker: the target's name, and features beside it."""
    choose_target()
    name, features = (os.environ.get(variable, "the processor's own") for variable in VARIABLES)
    return f"{name} with {features}" if features else name


def adopt_target(config: dict[str, Any]) -> None:
    """Pass the target on to a numba that something else has imported before."""
    for name in VARIABLES:
        if name in os.environ:
            config[name.removeprefix("NUMBA_")] = os.environ[name]
