"""Compilation of kernels and their cache, which is configured before numba is imported.

numba's own cache does not detect an edit in a function of another file, and cannot write in a read-only installation
without a home folder. Therefore the name of the cache folder is a key of the sources of this package, of the target,
and of the compiler's versions; `cache_folder` chooses its location. numba also looks up code by the path of its
source. Here a module's name replaces the path, so that one folder serves every installation of the same versions.
Folders that have not been used for a month are removed.

numba numbers the files of one function. Two processes that compile two functions of one factory at the same time, for
example the polynomials of `winding_current`, both write file 1, and each later loads the other's code. Therefore a file
is named after its contents here.
"""

from __future__ import annotations

import contextlib
import gc
import hashlib
import importlib.metadata
import io
import os
import pickle
import platform
import shutil
import sys
import time
from collections.abc import Callable, Iterable, Mapping
from functools import cache, cached_property
from pathlib import Path
from typing import Any, TypeVar, cast

from drivegate_models.compilation.cache_folder import (
    CACHE_VARIABLE,
    KERNELS_VARIABLE,
    KEY,
    NUMBA_VARIABLE,
    choose_folder,
)
from drivegate_models.compilation.cache_lock import SUFFIX, alone
from drivegate_models.compilation.kernel_files import (
    digests_in,
    enter_saved,
    remove_changed,
    trusted_content,
)
from drivegate_models.compilation.target import adopt_target, choose_target, requested_target
from drivegate_models.errors import InputError

# Each version of drivegate, of its compilers and each target leaves a folder of tens of megabytes.
_KEPT_SECONDS = 30 * 24 * 3600.0
_OWN_PACKAGES = ("drivegate_models", "drivegate", "drivegate_lab")
# These releases have the private interfaces that this module and `code_library` extend; a later one may have moved
# them. `pyproject.toml` states the same range.
_FIRST_NUMBA = (0, 62)
_NEXT_NUMBA = (0, 69)


@cache
def _digest_of_sources(folder: Path) -> str:
    digest = hashlib.sha256()
    for source in sorted(folder.rglob("*.py")):
        digest.update(source.relative_to(folder).as_posix().encode())
        digest.update(source.read_bytes())
    return digest.hexdigest()


def _digest_of_kernels() -> str:
    return _digest_of_sources(Path(__file__).resolve().parents[1])


def cache_key() -> str:
    """Return a key of the kernel sources, their target, and the compiler's versions, but not of their location."""
    digest = hashlib.sha256(_digest_of_kernels().encode())
    for package in ("numba", "numpy", "llvmlite"):
        digest.update(importlib.metadata.version(package).encode())
    digest.update(f"{sys.implementation.cache_tag}{platform.machine()}{requested_target()}".encode())
    return digest.hexdigest()[:16]


def choose_cache_folder() -> Path | None:
    """Return the folder for compiled kernels, or None if there is no safe folder that can be written."""
    return choose_folder(cache_key()).folder


def required_cache_folder() -> Path:
    """Return the folder for compiled kernels.

    Raises InputError if there is no safe folder that can be written.
    """
    choice = choose_folder(cache_key())
    if choice.folder is None:
        raise InputError(
            f"there is no folder for compiled code: {'; '.join(choice.refusals)}; name a folder of your own, which "
            f"nobody else can write, in the environment variable {CACHE_VARIABLE}"
        )
    return choice.folder


def refused_cache_folders() -> tuple[str, ...]:
    """Return the folders before the one for compiled kernels in the order, each with the reason why it is not used."""
    return choose_folder(cache_key()).refusals


def _configure() -> str | None:
    """Configure numba's cache folder, and return the folder of compiled kernels, if there is one."""
    for_reading = os.environ.get(KERNELS_VARIABLE)
    if for_reading:
        return for_reading
    folder = choose_cache_folder()
    if folder is None:
        os.environ.pop(NUMBA_VARIABLE, None)
        return None
    os.environ[NUMBA_VARIABLE] = str(folder)
    _prune(folder)
    return str(folder)


def _prune(used: Path) -> None:
    """Update the time of use of a cache folder, and remove neighbouring folders that have not been used for long."""
    with contextlib.suppress(OSError):
        os.utime(used)
        oldest = time.time() - _KEPT_SECONDS
        for folder in used.parent.iterdir():
            if KEY.fullmatch(folder.name) and folder.stat().st_mtime < oldest:
                shutil.rmtree(folder, ignore_errors=True)
                folder.with_name(folder.name + SUFFIX).unlink(missing_ok=True)


def _require_known_numba(version: str) -> None:
    """Refuse another numba than those that drivegate extends, which would fail somewhere in its compiler."""
    major, minor = map(int, version.split(".")[:2])
    if not _FIRST_NUMBA <= (major, minor) < _NEXT_NUMBA:
        wanted = "numba>={}.{},<{}.{}".format(*_FIRST_NUMBA, *_NEXT_NUMBA)
        raise InputError(
            f"numba {version} is installed, but drivegate extends private parts of numba's compiler and requires "
            f"{wanted}; install it with pip install '{wanted}'"
        )


_require_known_numba(importlib.metadata.version("numba"))
choose_target()
_ONLY_READS = KERNELS_VARIABLE in os.environ
_FOLDER = _configure()
KEEPS_CACHE = _FOLDER is not None
"""True if compiled kernels are cached between processes."""
_STORED = Path(_FOLDER or os.devnull)

import numba  # noqa: E402  (target and cache folder must be known before numba is imported)
from numba.core import caching, sigutils  # noqa: E402
from numba.core.runtime import nrt  # noqa: E402

from drivegate_models.compilation.code_library import (  # noqa: E402  (imports numba)
    CALLED_FUNCTIONS,
    INNER_FUNCTIONS,
    keep_code_in_libraries,
)

# If other code imported numba first, numba has already read the variables.
adopt_target(vars(numba.config))
if KEEPS_CACHE:
    vars(numba.config)["CACHE_DIR"] = os.environ[NUMBA_VARIABLE]

_Function = TypeVar("_Function", bound=Callable[..., object])


class _LocatedByModule(caching.UserProvidedCacheLocator):
    """Location of the code of drivegate's own functions: by the name of their module, not by the path of its file."""

    @classmethod
    def from_function(cls, function: Any, file: str) -> Any:
        """Return a locator for drivegate's own functions only."""
        return super().from_function(function, file) if _is_own(function) else None

    def __init__(self, function: Any, file: str) -> None:
        super().__init__(function, file)
        self._module: str = function.__module__
        package = self._module.rpartition(".")[0]
        self._cache_path = str(Path(_FOLDER or vars(numba.config)["CACHE_DIR"]) / package)

    def ensure_cache_path(self) -> None:
        """Make the folder, unless this process only reads."""
        if not _ONLY_READS:
            super().ensure_cache_path()

    def get_source_stamp(self) -> Any:
        """Identify the source, and what it calls, by the content of its top folder and of all kernels."""
        # A kernel above this package calls those of neighbouring folders too, such as the faults of both contracts.
        depth = self._module.count(".")
        return _digest_of_kernels(), _digest_of_sources(Path(self._py_file).parents[max(depth - 2, 0)])


def _is_own(function: Any) -> bool:
    return function.__module__.partition(".")[0] in _OWN_PACKAGES


# This also applies to functions called by address, which numba's own decorator caches.
# numba takes the first locator that accepts a function, so this one comes first.
caching.CacheImpl._locator_classes.insert(0, _LocatedByModule)


class _FilesNamedByContent(caching.IndexDataCacheFile):
    """The files of one function, each named after its signature, processor and closure.

    numba executes what it unpickles. So where `trust_only` lists files, others are as if they were not there.
    """

    def save(self, key: Any, data: Any) -> None:
        """Save compiled code, and enter it in the index, unless this process only reads."""
        digest = hashlib.sha256(repr(key).encode()).digest()
        name = self._data_name(int.from_bytes(digest[:8]))
        # A process that only reads may compile for itself what is missing, but need not store it.
        with contextlib.suppress(OSError) if _ONLY_READS else contextlib.nullcontext():
            self._save_data(name, data)
            self._save_index({**self._load_index(), key: name})
            enter_saved(_STORED, (self._data_path(name), self._index_path))

    def _load_index(self) -> Any:
        content = trusted_content(_STORED, self._index_path)
        if content is None:
            return {}
        stream = io.BytesIO(content)
        if pickle.load(stream) != self._version:
            return {}
        stamp, entries = pickle.load(stream)
        return entries if stamp == self._source_stamp else {}

    def _load_data(self, name: str) -> Any:
        content = trusted_content(_STORED, self._data_path(name))
        if content is None:
            raise FileNotFoundError(name)
        return pickle.loads(content)


vars(caching)["IndexDataCacheFile"] = _FilesNamedByContent


def kernel_digests() -> dict[str, bytes]:
    """Return a digest of the content of each file of compiled kernels, by its path in their folder."""
    return digests_in(_STORED)


def remove_changed_kernels(known: Iterable[Mapping[str, bytes]]) -> int:
    """Remove the compiled kernels that are not as they are known, and return how many those are."""
    return remove_changed(_STORED, known)


def _load_overload(self: Any, signature: Any, target_context: Any) -> Any:
    """Load compiled code without numba's libraries, which only a compilation needs and which take long to import."""
    if _is_own(self._py_func):
        nrt.rtsys.initialize(target_context)
    else:
        target_context.refresh()
    with self._guard_against_spurious_io_errors():
        return self._load_overload(signature, target_context)


# This also applies to functions called by address, which numba's own decorator caches.
caching.Cache.load_overload = _load_overload  # type: ignore[method-assign]


class _KernelCache(caching.FunctionCache):
    """numba's cache of a function's compiled code, safe with several processes that compile at once.

    It is completed when it is first used. Most kernels of a process are part of another one's compiled code.
    """

    def __init__(self, function: Callable[..., object], purpose: str) -> None:
        self._py_func = function
        self._purpose = purpose

    def __getattr__(self, name: str) -> Any:
        if name not in ("_name", "_impl", "_cache_path", "_cache_file", "_enabled"):
            raise AttributeError(name)
        super().__init__(self._py_func)
        self._cache_file = _FilesNamedByContent(
            cache_path=self._cache_path,
            filename_base=self._impl.filename_base + self._purpose,
            source_stamp=self._impl.locator.get_source_stamp(),
        )
        return getattr(self, name)

    def _index_key(self, signature: Any, codegen: Any) -> Any:
        """Distinguish functions of one factory by their closure, and kernels in it by their code.

        numba pickles a kernel with a different identity in each process, so it would never be found again.
        """
        return signature, codegen.magic_tuple(), _fingerprint(self._py_func)


def _fingerprint(function: Callable[..., object]) -> str:
    """Return a digest of a function's code and of the constants and kernels in its closure."""
    digest = hashlib.sha256(f"{function.__module__}.{function.__qualname__}".encode())
    digest.update(function.__code__.co_code)
    for cell in function.__closure__ or ():
        held = cell.cell_contents
        kernel_held = getattr(held, "py_func", None)
        part = _fingerprint(kernel_held) if kernel_held is not None else repr(held)
        digest.update(part.encode())
    return digest.hexdigest()


def _ignore_constants(dispatcher: Any) -> None:
    """Compile a function once for a type of argument, not once for each constant that a caller passes."""
    template_of = dispatcher.get_call_template

    def get_call_template(args: Any, kws: Any) -> Any:
        plain = tuple(numba.types.unliteral(arg) for arg in args)
        return template_of(plain, {name: numba.types.unliteral(kind) for name, kind in kws.items()})

    dispatcher.get_call_template = get_call_template


keep_code_in_libraries()


class _Kernel(numba.core.dispatcher.Dispatcher):
    """A function of drivegate's own, which one process compiles while others that need it wait for it."""

    def compile(self, sig: Any) -> Any:
        """Compile the function for a signature, or load what is stored."""
        arguments, _ = sigutils.normalize_signature(sig)
        if arguments in self.overloads:
            # Every call in a kernel and every run asks for this.
            return super().compile(sig)
        collections = gc.get_threshold()
        gc.set_threshold(*_RARE_COLLECTIONS)
        try:
            with alone(f"{_fingerprint(self.py_func)}{arguments}", None if _ONLY_READS else _FOLDER):
                return super().compile(sig)
        finally:
            gc.set_threshold(*collections)


# The compiler makes many objects that stay. To search them for garbage as often as usual takes a twelfth of its time.
_RARE_COLLECTIONS = (50_000, 50, 1000)


class _Inner(_Kernel):
    """A function that kernels call, compiled without a way in from Python.

    Taking the arguments of a whole drive apart is more code than most functions have themselves. Where one of them is
    called from Python all the same, as tests do, it is compiled once more for that.
    """

    def __call__(self, *args: Any) -> Any:
        return self.from_python(*args)

    @cached_property
    def from_python(self) -> Any:
        """The same function with a way in from Python."""
        options = {name: value for name, value in self.targetoptions.items() if name != "nopython"}
        options |= {"no_cpython_wrapper": False, "forceinline": False}
        return _dispatcher(self.py_func, "-python", **options)


def _dispatcher(function: Callable[..., object], purpose: str, **options: Any) -> Any:
    """Return numba's dispatcher of a function; the files of its code have the purpose in their names."""
    # Nothing calls a kernel by its address in C, but for controllers, which are compiled as that.
    dispatcher = numba.njit(**{"error_model": "numpy", "no_cfunc_wrapper": True, **options})(function)
    if not vars(numba.config)["DISABLE_JIT"]:
        _ignore_constants(dispatcher)
        if KEEPS_CACHE:
            dispatcher._cache = _KernelCache(function, purpose)
            dispatcher.__class__ = _Kernel
    return dispatcher


def _compiled(
    function: _Function, *, forceinline: bool = False, has_way_in: bool = True, **options: Any
) -> _Function:
    if function.__closure__:
        # numba names code by the function and a number that it increments in each process. Two functions of one
        # factory, compiled by two processes, may have the same name, and one would be linked instead of the other.
        function.__qualname__ += f".{_fingerprint(function)[:16]}"
    # State `forceinline` for every function. Otherwise a function compiled for an inlined caller is inlined as well,
    # with everything that it calls, at every call.
    dispatcher = _dispatcher(
        function, "", forceinline=forceinline, no_cpython_wrapper=not has_way_in, **options
    )
    if not has_way_in and not vars(numba.config)["DISABLE_JIT"]:
        INNER_FUNCTIONS.add(function.__qualname__)
        dispatcher.__class__ = _Inner
    return cast(_Function, dispatcher)


def kernel(function: _Function) -> _Function:
    """Compile `function` in nopython mode, cached. Every operation is rounded separately, and none is reordered."""
    return _compiled(function)


def unallocating(function: _Function) -> _Function:
    """Compile a function that creates no arrays like `kernel`, but without reference counting.

    Counting costs more than the arithmetic if a function with many arrays is called in a loop. The compiler refuses a
    function that creates an array. Machine code that Python can call is produced when Python calls it.
    """
    return _compiled(function, has_way_in=False, _nrt=False)


def inlined(function: _Function) -> _Function:
    """Compile a function like `unallocating`, and inline it into its callers, as for all functions of a controller."""
    return _compiled(function, forceinline=True, _nrt=False, has_way_in=False)


def called(function: _Function) -> _Function:
    """Let all callers of a kernel call it by its symbol, rather than contain a copy of it.

    It pays for thousands of instructions that several kernels call, of which each copy costs up to a second of
    compilation. In a loop that is the only caller, a copy is up to 3 % faster.
    """
    CALLED_FUNCTIONS.add(function.__qualname__)
    return function
