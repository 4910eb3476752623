"""Loading a native candidate's library, which runs code of it: this belongs into a worker process."""

import ctypes
import os
from functools import cache
from pathlib import Path
from typing import Any, Final

from drivegate.candidates.candidate import Candidate, Instrumented, NativeBuild
from drivegate.candidates.contract import HEADERS, ContractName
from drivegate.candidates.controller import Controller
from drivegate.candidates.fault import bounded_line
from drivegate.candidates.native.controller import (
    RESETS,
    STEPS,
    GlobalState,
    NativeController,
    same_arithmetic,
)
from drivegate.candidates.native.exact_memory import ExactMemory
from drivegate.candidates.native.two_builds import STEP_BOTH, WRITE_COUNTERS, TwoBuilds
from drivegate_cases.documents.wording import one_line
from drivegate_models.contract.current.records import ABI_MAJOR, ABI_MINOR
from drivegate_models.errors import HarnessFault, InputError

LARGEST_STATE: Final = 64 * 2**20
"""Greatest size of a candidate's state (bytes)."""

COMMON: Final = ("drivegate_abi_version", "drivegate_state_size")
"""Functions that a compiled controller of any contract has."""

_VERSIONS_IN_ONE: Final = 1000


def load_controller(candidate: Candidate) -> Controller:
    """Make a new instance of a native candidate; its library is loaded once a process.

    A candidate whose state is in globals has one instance in a process, which is returned again. Each of its resets
    begins with the values that the globals have after loading.
    """
    if not isinstance(candidate.details, NativeBuild):
        raise HarnessFault(f"the candidate {candidate.name} of kind {candidate.kind} was not built")
    name = one_line(candidate.name)
    plain = _loaded_controller(candidate.details.library, name)
    if candidate.instrumented is None or candidate.instrumented.library is None:
        return plain
    return _two_builds(plain, candidate.instrumented, name)


def _loaded_controller(library: Path, name: str, *, is_exact: bool = False) -> NativeController:
    """Load a library once a process, and make an instance; one that is exact has no byte to spare at its state."""
    functions, contract = _loaded(library, name)
    with same_arithmetic():
        version, size = functions.drivegate_abi_version(), functions.drivegate_state_size()
    require_version(version, name)
    if not 0 <= size <= LARGEST_STATE:
        raise InputError(
            f"{name}: drivegate_state_size returned {size}, but must return the size of the state in bytes, "
            f"0 to {LARGEST_STATE}"
        )
    if size:
        return _new_instance(functions, contract, size, state=ExactMemory(size) if is_exact else None)
    return _single_instance(library, name, functions, contract)


def _two_builds(plain: NativeController, instrumented: Instrumented, name: str) -> TwoBuilds:
    library = instrumented.library
    assert library is not None, "only a candidate with a second build has two"
    # libgcov puts the path at which an object was compiled below this folder.
    os.environ["GCOV_PREFIX"] = str(instrumented.folder)
    second = _loaded_controller(library, name, is_exact=True)
    other = None if instrumented.reference is None else _loaded_controller(instrumented.reference, name)
    functions = (
        _loaded(library, name)[0] if instrumented.stepper is None else ctypes.CDLL(str(instrumented.stepper))
    )
    step = ctypes.cast(getattr(functions, STEP_BOTH), ctypes.c_void_p).value or 0
    return TwoBuilds(plain, second, other, step, instrumented, getattr(functions, WRITE_COUNTERS, None))


def require_version(version: int, name: str) -> None:
    """Refuse a controller that was built for another major version of the contract."""
    major, minor = divmod(version, _VERSIONS_IN_ONE)
    if major != ABI_MAJOR:
        raise InputError(
            f"{name} was built for version {major}.{minor} of the contract, but this drivegate has version "
            f"{ABI_MAJOR}.{ABI_MINOR}; compile it again with the drivegate.h of `drivegate include-dir`"
        )


@cache
def _single_instance(library: Path, name: str, functions: Any, contract: ContractName) -> NativeController:
    variables = GlobalState(library)
    if variables.size > LARGEST_STATE:
        raise InputError(
            f"{name} has {variables.size} bytes of global variables, but a state may have at most {LARGEST_STATE}"
        )
    return _new_instance(functions, contract, 0, variables)


def _new_instance(
    functions: Any,
    contract: ContractName,
    size: int,
    variables: GlobalState | None = None,
    state: ExactMemory | None = None,
) -> NativeController:
    step_address = ctypes.cast(getattr(functions, STEPS[contract]), ctypes.c_void_p).value or 0
    return NativeController(
        step_address, getattr(functions, RESETS[contract]), size, contract, variables, state
    )


@cache
def _loaded(library: Path, name: str) -> tuple[Any, ContractName]:
    try:
        with same_arithmetic():
            functions = ctypes.CDLL(str(library))
    except OSError as error:
        reason = bounded_line(str(error).removeprefix(f"{library}: "))
        raise InputError(
            f"{name} cannot be loaded: {reason}; link all that it calls, and compile it for this machine"
        ) from error
    contract = _contract_of(functions, name)
    required = (*COMMON, RESETS[contract], STEPS[contract])
    missing = [function for function in required if not hasattr(functions, function)]
    if missing:
        # Without any step function, the contract is not known either.
        other = f", or those of {HEADERS['duty']} for duty ratios" if STEPS[contract] in missing else ""
        raise InputError(
            f"{name} does not export {', '.join(missing)}; a controller exports the functions that "
            f"{HEADERS[contract]} declares{other}"
        )
    functions.drivegate_abi_version.restype = ctypes.c_int64
    functions.drivegate_state_size.restype = ctypes.c_int64
    reset = getattr(functions, RESETS[contract])
    reset.argtypes, reset.restype = (ctypes.c_void_p, ctypes.c_void_p), ctypes.c_int
    return functions, contract


def _contract_of(functions: Any, name: str) -> ContractName:
    """Return which of the two steps a library exports; one with neither is taken for a controller of currents."""
    if not hasattr(functions, STEPS["duty"]):
        return "current"
    if hasattr(functions, STEPS["current"]):
        raise InputError(
            f"{name} exports both {STEPS['current']} and {STEPS['duty']}; export the pair of one contract, that of "
            "drivegate.h or that of drivegate_duty.h"
        )
    return "duty"
