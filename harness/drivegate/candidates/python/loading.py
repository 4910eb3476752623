"""Loading a Python candidate: importing its module, finding its class, making an instance.

This runs the candidate's code, so it belongs into a worker process. A candidate that is refused raises
`InputError`; one whose own code fails raises `CandidateFault`.
"""

import hashlib
import importlib
import importlib.util
import inspect
import os
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

from drivegate.candidates.candidate import Candidate, Instrumented
from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import CandidateFault, exception_fault
from drivegate.candidates.native.numba_controller import NumbaController
from drivegate.candidates.python.bridge import PythonController
from drivegate.candidates.python.remarks import Remarks
from drivegate_cases.documents.wording import nearest, one_line, shown_path
from drivegate_models.errors import InputError

_METHODS = ("reset", "step")


def load_controller(candidate: Candidate) -> Controller:
    """Make a new instance of a Python candidate's class, or of its `NumbaController`.

    Its module is imported once a process.
    """
    remarks = _remarks_of(candidate.folder)
    if candidate.instrumented is not None:
        return _counted(candidate, candidate.instrumented, remarks)
    return _controller(candidate, lambda instance: PythonController(instance, remarks.lines))


@cache
def _remarks_of(folder: Path) -> Remarks:
    return Remarks(folder)


def _counted(candidate: Candidate, instrumented: Instrumented, remarks: Remarks) -> Controller:
    """Make an instance whose lines are traced, also while its module is imported."""
    from drivegate.candidates.python.coverage import CountedController, counter_of

    counter = counter_of(instrumented.folder, candidate.sources)
    counter.start()
    try:
        return _controller(candidate, lambda instance: CountedController(instance, counter, remarks.lines))
    finally:
        counter.stop()


def _controller(candidate: Candidate, bridge: Callable[[Any], Controller]) -> Controller:
    chosen = _chosen_by(candidate, _module_of(candidate))
    if isinstance(chosen, NumbaController):
        if candidate.instrumented is not None:
            raise InputError(
                "--coverage cannot look into functions that numba has compiled; leave it out for a NumbaController"
            )
        from drivegate.candidates.native.numba_loading import load_numba_controller

        return load_numba_controller(chosen, one_line(candidate.name))
    try:
        return bridge(chosen())
    except BaseException as error:
        raise CandidateFault(exception_fault(error, "loading")) from error


def _module_of(candidate: Candidate) -> ModuleType:
    source = candidate.entry.rpartition(":")[0]
    folder = str(candidate.folder)
    if folder not in sys.path:
        # In front, so that the candidate's own modules are found before installed ones of the same name.
        sys.path.insert(0, folder)
    try:
        return _imported_file(Path(source)) if source.endswith(".py") else importlib.import_module(source)
    except SyntaxError as error:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        raise InputError(
            f"{shown_path(error.filename or source)}, line {error.lineno or 1}: {one_line(error.msg)}; "
            f"the file must be Python that version {version} can read"
        ) from error
    except ImportError as error:
        raise InputError(
            f"the candidate '{one_line(candidate.specification)}' cannot be imported: "
            f"{one_line(str(error))}; what it imports must be installed or in its folder"
        ) from error
    except BaseException as error:
        raise CandidateFault(exception_fault(error, "loading")) from error


def _imported_file(file: Path) -> ModuleType:
    """Import under a name made from the whole path, so that a file may be called like any other module."""
    name = f"drivegate_candidate_{file.stem}_{hashlib.sha256(os.fsencode(file)).hexdigest()[:12]}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise ImportError(f"{shown_path(file)} is not a Python source file")
    module = importlib.util.module_from_spec(spec)
    # Before its code runs: dataclasses and pickle look their module up there.
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def _chosen_by(candidate: Candidate, module: ModuleType) -> type[object] | NumbaController:
    source, _, attribute = candidate.entry.rpartition(":")
    where = Path(source).name if source.endswith(".py") else source
    found: object = module
    for part in attribute.split("."):
        found = getattr(found, part, None)
    if isinstance(found, NumbaController):
        return found
    if not isinstance(found, type):
        raise InputError(_missing_class_sentence(where, attribute, found, module))
    for method in _METHODS:
        if not callable(getattr(found, method, None)):
            raise InputError(
                f"the class '{attribute}' in {one_line(where)} has no method '{method}'; "
                "a controller has reset(nameplate) and step(sense)"
            )
    return found


def _missing_class_sentence(where: str, attribute: str, found: object, module: ModuleType) -> str:
    if found is not None:
        return (
            f"'{attribute}' in {one_line(where)} is not a class; name a class with reset and step, or a "
            "drivegate.NumbaController"
        )
    classes = [value for value in vars(module).items() if inspect.isclass(value[1])]
    own = [name for name, value in classes if value.__module__ == module.__name__]
    closest = nearest(attribute, own)
    advice = f"the nearest class there is '{closest}'" if closest else "and no other class of its own"
    return f"there is no class '{attribute}' in {one_line(where)}, {advice}; name a class with reset and step"
