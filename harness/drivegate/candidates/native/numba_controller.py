"""What an author writes to have a controller compiled by numba; nothing heavy is imported for it."""

from collections.abc import Callable
from dataclasses import KW_ONLY, dataclass
from typing import Any

from drivegate.candidates.contract import ContractName


@dataclass(frozen=True, eq=False)
class NumbaController:
    """A controller made of two functions that numba compiles when a worker process loads it.

    Either both are plain Python functions: ``reset(state, nameplate)`` and ``step(state, sense, command)``, where
    all arguments are records with the fields of the contract, the state's fields are those of its dtype, and `step`
    writes its answer into `command`. Functions that they call are compiled with ``numba.njit``. Or both are
    ``numba.cfunc`` of the types of `drivegate_reset` and `drivegate_step` in ``drivegate.h``, or of those in
    ``drivegate_duty.h``.

    Parameters
    ----------
    state : dtype
        A numpy dtype with named fields, or what makes one. With a ``numba.cfunc`` it may be the size in bytes.
    reset : callable
        Prepares for a run and forgets all earlier ones. The state is zeroed once, before the first.
    step : callable
        Answers for one control period.
    contract : {"current", "duty"}
        What it answers with: a current reference and an advance angle, or duty ratios. Then the records are those of
        ``drivegate_duty.h``, and `step` writes ``command.first_duty``, ``second_duty`` and ``third_duty``.

    Examples
    --------
    >>> import numpy as np
    >>> from drivegate import NumbaController
    >>> def reset(state, nameplate):
    ...     state.limit = nameplate.current_limit
    >>> def step(state, sense, command):
    ...     command.current_reference = state.limit if sense.speed < sense.speed_reference else 0.0
    ...     command.advance_angle = 0.0
    >>> controller = NumbaController(np.dtype([("limit", np.float64)]), reset=reset, step=step)
    """

    state: Any
    _: KW_ONLY
    reset: Callable[..., Any]
    step: Callable[..., Any]
    contract: ContractName = "current"
