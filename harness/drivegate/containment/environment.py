"""The environment variables that a candidate's process gets: a short list, so that no secret of a CI job is in it."""

from collections.abc import Mapping
from pathlib import Path
from typing import Final

from drivegate_models.compilation.cache_folder import KERNELS_VARIABLE, NUMBA_VARIABLE

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
PASS_VARIABLE: Final = "DRIVEGATE_PASS"
"""Environment variable with further names to pass on, separated by commas."""
TEMPORARY_VARIABLES: Final = ("TMPDIR", "TMP", "TEMP")
"""Variables that name the folder for temporary files."""


def worker_environment(inherited: Mapping[str, str], temporary: Path, kernels: Path | None) -> dict[str, str]:
    """Choose the environment of a candidate's process, which reads compiled kernels from a folder."""
    further = {name.strip() for name in inherited.get(PASS_VARIABLE, "").split(",")}
    passed = {
        name: value
        for name, value in inherited.items()
        if name in PASSED or name in further or name.startswith(PASSED_PREFIXES)
    }
    return {
        "PYTHONHASHSEED": "0",
        **passed,
        # Code that the candidate itself compiles goes with its process.
        NUMBA_VARIABLE: str(temporary / "numba"),
        **({} if kernels is None else {KERNELS_VARIABLE: str(kernels)}),
        **dict.fromkeys(TEMPORARY_VARIABLES, str(temporary)),
    }
