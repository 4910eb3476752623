"""What a program of an installation needs next to itself, without what else its user keeps there."""

import os
from pathlib import Path
from typing import Final

_PARTS: Final = (
    "bin",
    "shims",
    "include",
    "lib",
    "lib32",
    "lib64",
    "libexec",
    "plugins",
    "toolchains",
    "versions",
    "version",
)
"""Parts of an installation in a folder that has other files too; those in ``share`` may be anybody's."""


def installation_of(program: Path) -> list[Path]:
    """Return a program, or the folder above its ``bin`` with its libraries or with what a version manager starts.

    In a home folder, and in hidden ones there such as ``.local`` and ``.cargo``, keys and tokens lie next to ``bin``.
    """
    folder = program.parent
    prefix = folder.parent
    # The folder above /bin is the whole file system, which is no installation.
    if folder.name not in ("bin", "shims") or prefix == Path(folder.anchor):
        return [program]
    is_shared = any(
        home.is_relative_to(prefix) or (prefix.parent == home and prefix.name.startswith("."))
        for home in _homes()
    )
    return [prefix / part for part in _PARTS] if is_shared else [prefix]


def _homes() -> tuple[Path, ...]:
    # Of a user without a home folder, the name stays.
    home = Path(os.path.expanduser("~"))  # noqa: PTH111  (that of pathlib raises an error there)
    return home, home.resolve()
