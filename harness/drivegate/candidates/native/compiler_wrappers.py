"""Caches and distributors in front of a compiler, such as ccache: what they would start, without them.

They write into the home folder, or talk to a server, and isolation leaves a compiler neither.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Final

WRAPPERS: Final = frozenset(("ccache", "sccache", "distcc", "icecc", "buildcache", "colorgcc"))
"""Names of the programs."""


# What a script calls is not seen from outside.
_DISABLED: Final = MappingProxyType({"CCACHE_DISABLE": "1", "ICECC": "disable", "DISTCC_HOSTS": "localhost"})


def private_caches(scratch: Path) -> dict[str, str]:
    """Return variables for a compiler that is a script: its wrapper does nothing, and its cache is in a folder."""
    return {
        **_DISABLED,
        "XDG_CACHE_HOME": str(scratch),
        "CCACHE_DIR": str(scratch),
        "DISTCC_DIR": str(scratch),
    }


def without_wrapper(words: Sequence[str]) -> tuple[str, ...]:
    """Return the compiler's own command: of ``ccache gcc``, or of a ``cc`` that is a link to a wrapper.

    A wrapper of which no compiler is found stays.
    """
    for place, word in enumerate(words[1:], 1):
        # A wrapper's own settings, such as `ccache debug=true gcc`, may come before the compiler.
        if _is_wrapper(words[0]) and Path(words[0]).name in WRAPPERS and "=" not in word:
            return without_wrapper(words[place:])
    program = words[0]
    if _is_wrapper(program) and Path(program).name not in WRAPPERS:
        name = Path(program).name
        folders = os.environ.get("PATH", os.defpath).split(os.pathsep)
        others = (found for folder in folders if (found := shutil.which(name, path=folder)))
        program = next((found for found in others if not _is_wrapper(found)), program)
    return (program, *words[1:])


def _is_wrapper(program: str) -> bool:
    found = shutil.which(program)
    return found is not None and Path(found).resolve().name in WRAPPERS
