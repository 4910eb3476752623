"""Compiled kernels that are kept between processes."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

import drivegate_models
from drivegate_models.compilation import kernels as compilation
from drivegate_models.errors import InputError
from drivegate_models.machine.winding_current import phi4


def test_every_kernel_is_kept_in_files_named_by_content() -> None:
    assert isinstance(phi4._cache, compilation._KernelCache)  # type: ignore[attr-defined]


def test_processes_that_compile_at_once_never_share_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def files() -> compilation._FilesNamedByContent:
        return compilation._FilesNamedByContent(str(tmp_path), "kernel", "stamp")

    first, second = ("signature", "processor", "one"), ("signature", "processor", "two")
    # Both processes read the index before either has written it.
    with monkeypatch.context() as patched:
        patched.setattr(compilation._FilesNamedByContent, "_load_index", lambda self: {})
        files().save(first, "code one")
        files().save(second, "code two")
    files().save(first, "code one")
    assert files().load(first) == "code one"
    assert files().load(second) == "code two"


_COMPILE = """
import sys
from drivegate_models.machine.winding_current import current_after
from drivegate_models.loop.step_recording import playing_step
step = playing_step()
current_after.compile("(float64, float64, float64, float64, float64)")
print(sum(current_after.stats.cache_misses.values()), sum(current_after.stats.cache_hits.values()))
print(step._cache_hits, int("numba.np.arraymath" in sys.modules))
"""


def _compiled_at(folder: Path, cache: Path) -> list[int]:
    """Compile a few functions of the package in a folder.

    Return misses and hits of a kernel, hits of a step, and 1 if numba imported what only a compilation needs.
    """
    surroundings = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    done = subprocess.run(
        [sys.executable, "-c", _COMPILE],
        cwd=folder,
        env={**surroundings, compilation.CACHE_VARIABLE: str(cache)},
        capture_output=True,
        text=True,
        check=True,
        timeout=300,
    )
    return [int(word) for word in done.stdout.split()]


@pytest.mark.nightly
def test_an_installation_at_another_place_compiles_nothing_again(tmp_path: Path) -> None:
    package = Path(drivegate_models.__file__).parent
    for name in ("one", "two"):
        shutil.copytree(package, tmp_path / name / package.name, ignore=shutil.ignore_patterns("__pycache__"))
    assert _compiled_at(tmp_path / "one", tmp_path / "cache") == [1, 0, 0, 1], "the first one has to compile"
    assert _compiled_at(tmp_path / "two", tmp_path / "cache") == [0, 1, 1, 0], (
        "the second one found nothing of what the first had compiled"
    )
    folders = [folder for folder in (tmp_path / "cache").iterdir() if folder.is_dir()]
    assert len(folders) == 1, f"the place of the sources is in the folder's name: {folders}"


@pytest.mark.nightly
def test_changed_sources_are_compiled_again(tmp_path: Path) -> None:
    package = Path(drivegate_models.__file__).parent
    shutil.copytree(package, tmp_path / "one" / package.name, ignore=shutil.ignore_patterns("__pycache__"))
    _compiled_at(tmp_path / "one", tmp_path / "cache")
    with (tmp_path / "one" / package.name / "machine" / "load.py").open("a", encoding="utf-8") as source:
        source.write("# Another version.\n")
    assert _compiled_at(tmp_path / "one", tmp_path / "cache") == [1, 0, 0, 1]


def test_code_outside_the_models_is_compiled_again_with_any_file_of_its_folder(tmp_path: Path) -> None:
    # Its functions call one another across the files of their folder, as those of the emulator do.
    stamps = []
    for text in ("ONE = 1", "ONE = 2", "ONE = 1"):
        (tmp_path / "beside.py").write_text(text, encoding="utf-8")
        compilation._digest_of_sources.cache_clear()
        located = compilation._LocatedByModule(compilation.cache_key, str(tmp_path / "own.py"))
        stamps.append(located.get_source_stamp())
    assert stamps[0] == stamps[2] != stamps[1]


_FACTORY = """
from drivegate_models.compilation.kernels import inlined, kernel
def times(factor):
    def product(x):
        return factor * x
    return inlined(product)
double, triple = times(2.0), times(3.0)
@kernel
def both(x):
    return double(x), triple(x)
"""
_FIRST_OF_A_PROCESS = """
import itertools
from numba.core.bytecode import FunctionIdentity
from drivegate_models.factory import both, double, triple
FunctionIdentity._unique_ids = itertools.count(1_000_000)
"""


def _printed(tmp_path: Path, command: str) -> str:
    """Return what a command prints in a process with its own cache in a folder, where it also finds modules."""
    surroundings = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    done = subprocess.run(
        [sys.executable, "-c", command],
        cwd=tmp_path,
        env={**surroundings, compilation.CACHE_VARIABLE: str(tmp_path / "cache")},
        capture_output=True,
        text=True,
        check=True,
        timeout=120,
    )
    return done.stdout.strip()


@pytest.mark.nightly
def test_functions_of_one_factory_stay_apart_whichever_process_compiled_them(tmp_path: Path) -> None:
    package = shutil.copytree(
        Path(drivegate_models.__file__).parent,
        tmp_path / "drivegate_models",
        ignore=shutil.ignore_patterns("__pycache__"),
    )
    (package / "factory.py").write_text(_FACTORY, encoding="utf-8")
    # numba numbers the functions that a process compiles, and each of these is the first one of its process.
    printed = [
        _printed(tmp_path, _FIRST_OF_A_PROCESS + use)
        for use in ("double(1.0)", "triple(1.0)", "print(both(1.0))")
    ]
    assert printed[-1] == "(2.0, 3.0)", "one function was linked in place of the other"


def test_of_two_processes_one_compiles_a_function_and_the_other_waits_for_it(tmp_path: Path) -> None:
    (tmp_path / "constants.py").write_text(_CONSTANTS, encoding="utf-8")
    missed = "print(three(1.0), sum(three.stats.cache_misses.values()))"
    with ThreadPoolExecutor() as together:
        printed = together.map(
            lambda _: _printed(tmp_path, f"from constants import three; {missed}"), range(2)
        )
    assert sorted(printed) == ["6.0 0", "6.0 1"]


_WITHOUT_A_FOLDER = """
from drivegate_models.compilation import cache_folder
cache_folder._parents = lambda: iter(())
from constants import three
print(three(1.0))
"""


def test_without_a_folder_for_compiled_code_nothing_is_written(tmp_path: Path) -> None:
    (tmp_path / "constants.py").write_text(_CONSTANTS, encoding="utf-8")
    assert _printed(tmp_path, _WITHOUT_A_FOLDER) == "6.0"
    assert {path.name for path in tmp_path.iterdir()} <= {"constants.py", "__pycache__"}


def test_folders_that_nothing_has_used_for_long_go(tmp_path: Path) -> None:
    used, recent, old, foreign = (tmp_path / name for name in ("a" * 16, "b" * 16, "c" * 16, "my-results"))
    for folder in (used, recent, old, foreign):
        folder.mkdir()
        (folder / "file").touch()
    for folder in (used, old, foreign):
        os.utime(folder, (0.0, 0.0))
    compilation._prune(used)
    assert {folder.name for folder in tmp_path.iterdir()} == {used.name, recent.name, foreign.name}


def test_the_cache_folder_holds_where_numba_was_imported_before(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv(compilation.CACHE_VARIABLE, str(tmp_path))
    command = "import numba; from drivegate_models.machine.winding_current import phi4; print(phi4._cache.cache_path)"
    done = subprocess.run(
        [sys.executable, "-c", command], capture_output=True, text=True, check=True, timeout=120
    )
    assert Path(done.stdout.strip()).is_relative_to(tmp_path), done.stdout


_CONSTANTS = """
from drivegate_models.compilation.kernels import inlined, kernel, unallocating
@inlined
def scaled(number, x):
    return number * x
@kernel
def three(x):
    return scaled(1, x) + scaled(2, x) + scaled(3, x)
"""


_OTHER_CALLER = """
from constants import scaled
from drivegate_models.compilation.kernels import kernel
@kernel
def four(x):
    return scaled(4, x)
"""


@pytest.mark.nightly
def test_a_function_is_compiled_once_for_all_constants_and_callable_all_the_same(tmp_path: Path) -> None:
    """numba would compile it for each constant, and with the arguments of a Python call taken apart."""
    (tmp_path / "constants.py").write_text(_CONSTANTS, encoding="utf-8")
    shown = "print(three(1.0), scaled.signatures, scaled(4, 0.5))"
    assert _printed(tmp_path, f"from constants import scaled, three; {shown}") == "6.0 [(int64, float64)] 2.0"


@pytest.mark.nightly
@pytest.mark.parametrize("decorator", ["inlined", "unallocating"])
def test_an_inner_function_has_machine_code_in_its_callers_alone(tmp_path: Path, decorator: str) -> None:
    """Another process takes its code from the cache, for a caller that is compiled there."""
    constants = _CONSTANTS.replace("@inlined", f"@{decorator}")
    (tmp_path / "constants.py").write_text(constants, encoding="utf-8")
    (tmp_path / "other.py").write_text(_OTHER_CALLER, encoding="utf-8")
    shown = "print(three(1.0), [each.library.get_pointer_to_function(each.fndesc.llvm_func_name) for each in compiled])"
    command = (
        f"from constants import scaled, three; three(2.0); compiled = scaled.overloads.values(); {shown}"
    )
    assert _printed(tmp_path, command) == "6.0 [0]", "address of its machine code"
    command = "from other import four, scaled; print(four(0.5), sum(scaled.stats.cache_hits.values()))"
    assert _printed(tmp_path, command) == "2.0 1", "value and hits of the cache"


_OF_A_USER = """
import drivegate_models.compilation.kernels
import numba
@numba.vectorize(["float64(float64)"])
def twice(x):
    return 2.0 * x
print(twice(1.5))
"""


@pytest.mark.nightly
def test_functions_of_others_have_machine_code_as_numba_gives_it(tmp_path: Path) -> None:
    assert _printed(tmp_path, _OF_A_USER) == "3.0"


_CALLED = """
from drivegate_models.compilation.kernels import called, kernel
@called
@kernel
def once(x):
    for _ in range(3):
        x = x * 0.5 + 1.0
    return x
@kernel
def caller(x):
    return once(x) + 0.5
@kernel
def other_caller(x):
    return once(x) - 0.5
def copies(function):
    modules = [each.library._get_module_for_linking() for each in function.overloads.values()]
    return [each.name for one in modules for each in one.functions if "once" in each.name and not each.is_declaration]
"""


@pytest.mark.nightly
def test_a_function_that_is_called_by_its_symbol_is_compiled_once(tmp_path: Path) -> None:
    """The cache keeps its code with each caller, whichever process compiled it, and also on its own for new callers."""
    (tmp_path / "sizes.py").write_text(_CALLED, encoding="utf-8")
    shown = "print(caller(1.0), copies(caller), sum(caller.stats.cache_hits.values()))"
    assert _printed(tmp_path, f"from sizes import *; {shown}") == "2.375 [] 0"
    assert _printed(tmp_path, f"from sizes import *; {shown}; print(once.signatures)") == "2.375 [] 1\n[]"
    shown = "print(other_caller(1.0), copies(other_caller), sum(once.stats.cache_hits.values()))"
    assert _printed(tmp_path, f"from sizes import *; {shown}") == "1.375 [] 1"


_LOST_CALL = """
from drivegate_models.compilation.kernels import called, kernel, unallocating
@unallocating
def larger(x, y):
    return max(x, y) + max(y, x)
@unallocating
def caller_of_larger(x):
    return larger(x, x + x) + 0.5
DECORATORS
def without_call(x):
    length = 0.0
    if x > 3.0:
        length = 0.0
    if length > 0.0:
        x = LOST
    return caller_of_larger(x)
@kernel
def outer(x):
    return without_call(x)
"""


_CALLER_OF_LOST = """
from drivegate_models.compilation.kernels import kernel
from lost import without_call
@kernel
def caller(x):
    return without_call(x) + 1.0
"""


@pytest.mark.parametrize(
    ("decorators", "lost"),
    [
        ("@called @unallocating", "larger(x, x * x)"),
        pytest.param("@called @unallocating", "max(x, x * x)", marks=pytest.mark.nightly),
        pytest.param("@unallocating", "larger(x, x * x)", marks=pytest.mark.nightly),
        pytest.param("@kernel", "larger(x, x * x)", marks=pytest.mark.nightly),
    ],
)
def test_a_function_whose_only_call_the_optimiser_removes_is_linked_for_its_other_callers(
    tmp_path: Path, decorators: str, lost: str
) -> None:
    """The compiler finds out that `length` is never above 0 after numba has listed what the call needs."""
    source = _LOST_CALL.replace("LOST", lost).replace("DECORATORS", decorators.replace(" ", "\n"))
    (tmp_path / "lost.py").write_text(source, encoding="utf-8")
    (tmp_path / "other.py").write_text(_CALLER_OF_LOST, encoding="utf-8")
    assert _printed(tmp_path, "from lost import outer; print(outer(1.0))") == "4.5"
    # Another process takes the code from the cache.
    assert _printed(tmp_path, "from other import caller; print(caller(1.0))") == "5.5"


@pytest.mark.parametrize("version", ["0.61.2", "0.69.0", "0.69.0rc1", "1.0.0"])
def test_another_numba_is_refused_in_one_sentence(version: str) -> None:
    with pytest.raises(
        InputError, match=rf"^numba {version} is installed, but .* requires numba>=0\.62,<0\.69; "
    ):
        compilation._require_known_numba(version)


def test_the_package_requires_the_numba_that_the_compilation_extends() -> None:
    project = Path(__file__).parents[3] / "pyproject.toml"
    required = tomllib.loads(project.read_text(encoding="utf-8"))["project"]["dependencies"]
    first, following = (
        ".".join(map(str, each)) for each in (compilation._FIRST_NUMBA, compilation._NEXT_NUMBA)
    )
    assert f"numba>={first},<{following}" in required
