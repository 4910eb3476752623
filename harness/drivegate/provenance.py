"""Where a result comes from: the versions of everything that computes it."""

from __future__ import annotations

import importlib.metadata
import platform
from typing import Any

from drivegate import __version__

_PACKAGES = ("numba", "numpy", "scipy", "hypothesis")


def provenance() -> dict[str, Any]:
    """Tell the versions of what computes a result.

    Returns
    -------
    dict
        Versions by name, Python's implementation and the processor's architecture.
    """
    return {
        "drivegate": __version__,
        "python": platform.python_version(),
        "machine": platform.machine(),
        "packages": {name: importlib.metadata.version(name) for name in _PACKAGES},
    }
