"""The environment variables that a candidate's process gets: a short list, so that no secret of a CI job is in it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

PASSED: Final = frozenset(
    {
        "PATH",
        "HOME",
        "USER",
        "LOGNAME",
        "SHELL",
        "LANG",
        "LANGUAGE",
        "TZ",
        "CC",
        "LD_LIBRARY_PATH",
        "DYLD_LIBRARY_PATH",
        "PYTHONPATH",
        "PYTHONHOME",
        "PYTHONHASHSEED",
        "PYTHONUTF8",
        "PYTHONIOENCODING",
        "VIRTUAL_ENV",
        "CONDA_PREFIX",
        "MPLCONFIGDIR",
    }
)
"""Names of variables that are passed on."""
PASSED_PREFIXES: Final = ("LC_", "NUMBA_", "OMP_", "OPENBLAS_", "MKL_", "JOBLIB_")
"""Beginnings of names that are passed on: the language, and what decides how numbers are computed."""
FOLDERS: Final = ("DRIVEGATE_CACHE", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME")
"""Variables that are passed on and name folders; made absolute, since a process starts in another folder."""
PASS_VARIABLE: Final = "DRIVEGATE_PASS"
"""Environment variable with further names to pass on, separated by commas."""
TEMPORARY_VARIABLES: Final = ("TMPDIR", "TMP", "TEMP")
"""Variables that name the folder for temporary files."""


def worker_environment(inherited: Mapping[str, str], temporary: Path) -> dict[str, str]:
    """Choose the environment of a candidate's process."""
    further = {name.strip() for name in inherited.get(PASS_VARIABLE, "").split(",")}
    passed = {
        name: value
        for name, value in inherited.items()
        if name in PASSED or name in further or name.startswith(PASSED_PREFIXES)
    }
    folders = {name: str(Path(inherited[name]).absolute()) for name in FOLDERS if inherited.get(name)}
    return {
        "PYTHONHASHSEED": "0",
        **passed,
        **folders,
        **dict.fromkeys(TEMPORARY_VARIABLES, str(temporary)),
    }
