"""A process of the harness or of a candidate, with its keeper and a short environment without secrets."""

import os
import signal
import subprocess
import time
from collections.abc import Mapping
from contextlib import suppress
from enum import StrEnum
from pathlib import Path
from types import MappingProxyType
from typing import Final

import psutil

from drivegate.candidates.command_path import command_path
from drivegate.containment.keeper_process import KeeperProcess, NewKeeper
from drivegate.containment.templates import TEMPLATES, KeeperOrder, Preparation
from drivegate.containment.temporary_folder import TemporaryFolder
from drivegate.isolation.layers import Layer, Places, python_command, written_order
from drivegate_models.compilation.cache_folder import CACHE_VARIABLE, KERNELS_VARIABLE, NUMBA_VARIABLE
from drivegate_models.compilation.kernels import choose_cache_folder

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
# Longer than the keeper itself takes at most to kill everything, so that only a stopped or stuck one is killed.
_KEEPER_PATIENCE = 20.0
# A judge that ends waits for its candidate's process first (2 s at most, in `candidate_handle`).
_PATIENCE = 3.0
_BLOCK = 4096
_STANDARD_ERROR = 2


def worker_environment(inherited: Mapping[str, str], temporary: Path, kernels: Path | None) -> dict[str, str]:
    """Choose the environment of a candidate's process, which reads compiled kernels from a folder."""
    return {
        **_lasting_environment(inherited, kernels),
        # Code that the candidate itself compiles goes with its process.
        NUMBA_VARIABLE: str(temporary / "numba"),
        **dict.fromkeys(TEMPORARY_VARIABLES, str(temporary)),
    }


def _lasting_environment(inherited: Mapping[str, str], kernels: Path | None) -> dict[str, str]:
    """Choose what the environments of several candidates' processes have in common."""
    further = {name.strip() for name in inherited.get(PASS_VARIABLE, "").split(",")}
    passed = {
        name: value
        for name, value in inherited.items()
        if name in PASSED or name in further or name.startswith(PASSED_PREFIXES)
    }
    return {
        # The order of a set of strings depends on it, so a candidate would differ from process to process (`DET-1`).
        "PYTHONHASHSEED": "0",
        **passed,
        "PATH": command_path(inherited),
        # A template imports numba before there is a temporary folder. Each copy sets its own in the end.
        NUMBA_VARIABLE: os.devnull,
        **({} if kernels is None else {KERNELS_VARIABLE: str(kernels)}),
    }


def _environment_of_imports(inherited: Mapping[str, str]) -> dict[str, str]:
    """Choose what of a judge's environment its imports read, as far as it is set already."""
    return {
        name: value
        for name, value in inherited.items()
        if name in PASSED or name in (CACHE_VARIABLE, KERNELS_VARIABLE) or name.startswith(PASSED_PREFIXES)
    }


def prepare_judges(preparation: Preparation, *, is_one_of_many: bool) -> None:
    """Prepare the judges that are started as copies from now on."""
    if choose_cache_folder() is not None:
        inherited = _environment_of_imports(os.environ)
        TEMPLATES.prepare(Role.JUDGE, inherited, preparation, is_one_of_many=is_one_of_many)


class Role(StrEnum):
    JUDGE = "judge"
    CANDIDATE = "candidate"


class KeptProcess:
    """One process, from its start to when nothing of it is left.

    A candidate's gets few environment variables, and its output goes to a descriptor; a judge's is the harness's own.
    `variables` are added for a candidate, which also writes into `writable`. One that is started afresh is never a copy
    of a template. If it `is_one_of_many`, others follow for certain. A copy has imported `modules`.

    `keeper`: its keeper, which ends by itself only if it was killed.
    """

    def __init__(
        self,
        role: Role,
        folder: Path | None,
        descriptors: tuple[int, ...],
        *,
        output: int | None = None,
        layers: tuple[Layer, ...] = (),
        readable: tuple[str, ...] = (),
        writable: tuple[str, ...] = (),
        variables: Mapping[str, str] = MappingProxyType({}),
        afresh: bool = False,
        modules: tuple[str, ...] = (),
        is_one_of_many: bool = False,
    ) -> None:
        self._owner = os.getpid()
        self._temporary = TemporaryFolder()
        self._reported = b""
        temporary = str(self._temporary.path)
        kernels = choose_cache_folder()
        environment: Mapping[str, str] = os.environ
        lasting = _environment_of_imports(os.environ)
        if role is Role.CANDIDATE:
            environment = {**worker_environment(os.environ, self._temporary.path, kernels), **variables}
            lasting = {**_lasting_environment(os.environ, kernels), **variables}
            readable = readable if kernels is None else (*readable, str(kernels))
        order = written_order(layers, Places(readable, (temporary, *writable)))
        words: tuple[str, ...] = (role.value, order, temporary)
        folder = folder if folder is not None and folder.is_dir() else None
        # Only this process has the end for writing, which closes however it ends. That ends the keeper.
        reader, self._held = os.pipe()
        self._reports, writer = os.pipe()
        try:
            keeper: KeeperProcess | None = None
            if not afresh and kernels is not None:
                streams = (reader, writer, _STANDARD_ERROR if output is None else output)
                wanted = KeeperOrder(words, (*streams, *descriptors), environment, modules)
                keeper = TEMPLATES.keeper(wanted, folder, lasting, is_one_of_many=is_one_of_many)
            if keeper is None:
                words = (*words, *map(str, descriptors))
                process = subprocess.Popen(
                    python_command("drivegate.containment.keeper", "keep", *words),
                    stdin=reader,
                    stdout=writer,
                    stderr=output,
                    pass_fds=descriptors,
                    # Ctrl-C in a terminal reaches the harness alone, which ends its processes in order.
                    start_new_session=True,
                    cwd=folder,
                    env=environment,
                )
                keeper = NewKeeper(process)
            self.keeper = keeper
        except BaseException:
            os.close(self._held)
            os.close(self._reports)
            self._temporary.remove()
            raise
        finally:
            os.close(reader)
            os.close(writer)
        os.set_blocking(self._reports, False)

    @property
    def process_id(self) -> int | None:
        """Process id of the worker, which stays its own until `end`; None until the worker has been started."""
        if b"\n" not in self._reported:
            self._listen()
        return int(self._reported.split()[0]) if b"\n" in self._reported else None

    def is_stopped(self) -> bool:
        """Return True if the worker or its keeper is stopped, by a signal or by a debugger."""
        stopped = (psutil.STATUS_STOPPED, psutil.STATUS_TRACING_STOP)
        with suppress(psutil.NoSuchProcess):
            numbers = (self.process_id, self.keeper.pid)
            return any(psutil.Process(number).status() in stopped for number in numbers if number is not None)
        return False

    def processor_seconds(self) -> float:
        """Measure the processor time of the worker; 0 until it has been started, and where it is gone."""
        number = self.process_id
        if number is not None:
            with suppress(psutil.NoSuchProcess):
                times = psutil.Process(number).cpu_times()
                return float(times.user + times.system)
        return 0.0

    def wait_for_worker(self) -> None:
        until = time.monotonic() + _PATIENCE
        number = self.process_id
        while number is not None and time.monotonic() < until:
            try:
                if psutil.Process(number).status() == psutil.STATUS_ZOMBIE:
                    return
            except psutil.NoSuchProcess:
                return
            time.sleep(0.005)

    def exit_status(self) -> int:
        """Return how the worker ended, once `end` has been called."""
        numbers = self._reported.split()
        # A worker whose keeper was killed is killed by the system.
        return int(numbers[1]) if len(numbers) > 1 else -signal.SIGKILL

    def end(self) -> None:
        """Kill the worker and all that came from it; in another process than the one that started it, do nothing."""
        if os.getpid() != self._owner or self._held < 0:
            return
        os.close(self._held)
        self._held = -1
        # A candidate may have stopped the keeper, once or again and again.
        self.keeper.send(signal.SIGCONT)
        if not self.keeper.ends_within(_KEEPER_PATIENCE):
            self._kill_descendants()
            self.keeper.send(signal.SIGKILL)
            self.keeper.ends_within(_KEEPER_PATIENCE)
        self._listen()
        os.close(self._reports)
        self._reports = -1
        self._temporary.remove()

    def _kill_descendants(self) -> None:
        """Kill what a keeper that does not answer keeps; all of it is below the keeper as long as that lives."""
        with suppress(psutil.NoSuchProcess):
            keeper = psutil.Process(self.keeper.pid)
            # A process may start another one while it is killed.
            while kept := [
                each for each in keeper.children(recursive=True) if each.status() != psutil.STATUS_ZOMBIE
            ]:
                for each in kept:
                    with suppress(psutil.NoSuchProcess):
                        each.kill()

    def _listen(self) -> None:
        with suppress(BlockingIOError):
            while self._reports >= 0 and (block := os.read(self._reports, _BLOCK)):
                self._reported += block
