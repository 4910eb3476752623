"""A build hook that puts compiled kernels into a wheel, for the interpreters in DRIVEGATE_WHEEL_KERNELS."""

from __future__ import annotations

import json
import os
import platform
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

VARIABLE = "DRIVEGATE_WHEEL_KERNELS"
"""Environment variable with one Python interpreter or several, separated by spaces."""
COMPILERS = ("numba", "llvmlite", "numpy")
"""Packages whose versions compiled kernels depend on; the wheel requires those that its kernels were compiled with."""
_COMPILE = f"""
import importlib.metadata, json, sys
from drivegate.drives.kinds import DRIVE_KINDS
from drivegate.contracts.catalogue import contract_named
from drivegate.gate.warm_up import compile_for_first_check
compile_for_first_check()
checks = [(contract_named(kind.contract).usual_candidate, kind.default_drive) for kind in DRIVE_KINDS.values()]
versions = {{name: importlib.metadata.version(name) for name in {COMPILERS!r}}}
print(json.dumps({{"python": "%d.%d" % sys.version_info[:2], "versions": versions, "checks": checks}}))
"""
_LIST = """
import sys
from pathlib import Path
from drivegate_models.compilation.kernel_files import list_digests
for place in Path(sys.argv[1]).iterdir():
    if place.is_dir():
        list_digests(place)
    else:
        # The file of the locks.
        place.unlink()
"""


class KernelHook(BuildHookInterface[Any]):
    """Compile kernels with each interpreter, in an environment with the plain wheel."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Add kernels and their requirements to a wheel, if the variable is set."""
        interpreters = os.environ.get(VARIABLE, "").split()
        if not interpreters or self.target_name != "wheel" or version == "editable":
            return
        if not sys.platform.startswith("linux") or platform.machine() != "x86_64":
            raise SystemExit(f"{VARIABLE} is for Linux on x86-64; unset it to build the plain wheel")
        # Removed when the build's process ends.
        self._scratch = tempfile.TemporaryDirectory(prefix="drivegate-kernels-")
        kernels = Path(self._scratch.name, "kernels")
        for number, interpreter in enumerate(interpreters):
            made = _compile(interpreter, Path(self.root), Path(self._scratch.name, str(number)), kernels)
            build_data["dependencies"] += [
                f"{name}=={exact}; python_version == '{made['python']}'"
                for name, exact in made["versions"].items()
            ]
        build_data["force_include"][str(kernels)] = "drivegate_models/compiled"
        build_data["pure_python"] = False
        # Kernels are object code that calls nothing of the C library that a newer one could lack.
        build_data["tag"] = "py3-none-manylinux_2_17_x86_64"


def _compile(interpreter: str, root: Path, environment: Path, kernels: Path) -> dict[str, Any]:
    """Compile kernels with an interpreter, and return its version and those of the compilers."""
    # pip tells its build processes by variables, which the new environment must not see.
    dropped = (VARIABLE, "PIP_BUILD_TRACKER", "PYTHONPATH", "NUMBA_CACHE_DIR")
    plain = {name: value for name, value in os.environ.items() if name not in dropped}
    subprocess.run([interpreter, "-m", "venv", str(environment)], check=True, env=plain)
    python = str(environment / "bin" / "python")
    subprocess.run([python, "-m", "pip", "install", "--quiet", str(root)], check=True, env=plain)
    caching = plain | {"DRIVEGATE_CACHE": str(kernels)}
    printed = subprocess.run(
        [python, "-c", _COMPILE], check=True, env=caching, stdout=subprocess.PIPE, text=True, cwd=environment
    ).stdout
    made: dict[str, Any] = json.loads(printed.splitlines()[-1])
    for candidate, drive in made["checks"]:
        # Pages use kernels of their own.
        words = ("check", candidate, "--drive", drive, "--effort", "quick", "--quiet")
        subprocess.run([python, "-m", "drivegate", *words], check=True, env=caching, cwd=environment)
    subprocess.run([python, "-c", _LIST, str(kernels)], check=True, env=plain, cwd=environment)
    return made
