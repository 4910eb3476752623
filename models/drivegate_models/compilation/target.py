"""The instruction set for compiled kernels: a fixed one, not that of the present processor.

With a processor's own name the compiler would choose instructions, widths and so speeds by machine, and another
machine could not use cached kernels. Results do not depend on the target, because no operation is fused or
reordered. They state it nevertheless.
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
    # A library of many megabytes, which is only loaded for compilation.
    from llvmlite.binding import get_host_cpu_features

    features = get_host_cpu_features()
    return _V3 if all(features.get(name) for name in _V3_FEATURES) else baseline


def choose_target() -> None:
    """Request the stated target from numba before its import, unless the user has requested another one."""
    if not any(name in os.environ for name in VARIABLES):
        os.environ.update(zip(VARIABLES, (stated_target(), ""), strict=True))


def requested_target() -> str:
    """Return the target of kernels in this process and in every worker: its name and additional features."""
    choose_target()
    name, features = (os.environ.get(variable, "the processor's own") for variable in VARIABLES)
    return f"{name} with {features}" if features else name


def adopt_target(config: dict[str, Any]) -> None:
    """Pass the target to a numba that other code has already imported."""
    for name in VARIABLES:
        if name in os.environ:
            config[name.removeprefix("NUMBA_")] = os.environ[name]
