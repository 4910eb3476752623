"""Where a campaign's tasks are done: processes on this machine, or an existing dask cluster, through joblib."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import BrokenExecutor
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Any, Final, TypeVar

from drivegate.containment.machine_memory import lack_of_memory, usual_workers
from drivegate.isolation.layers import ISOLATION_VARIABLE, Isolation
from drivegate.isolation.system_calls import end_with_parent
from drivegate_cases.documents.wording import one_line
from drivegate_models.errors import InputError

# Attempts in a row that bring not one result; further ones would end in the same way.
_ATTEMPTS: Final = 3
_CONNECTION_SECONDS: Final = 10.0

ItemT = TypeVar("ItemT")
ResultT = TypeVar("ResultT")


@dataclass(frozen=True)
class Backend:
    name: str = "local"
    """``local`` or ``dask``."""
    workers: int | None = None
    """Number of local processes; None for one a processor."""
    scheduler: str | None = None
    """Address of the scheduler of a dask cluster."""

    def require(self) -> None:
        """Refuse a backend that is not installed."""
        if self.name == "dask" and (find_spec("distributed") is None or find_spec("dask") is None):
            raise InputError(
                "--backend dask needs the packages dask and distributed, which are not installed; "
                "pip install dask distributed"
            )


def done_by(
    backend: Backend, task: Callable[[bytes, ItemT], ResultT], package: bytes, items: Sequence[ItemT]
) -> Iterator[tuple[ItemT, ResultT]]:
    """Do tasks side by side and yield their results as they come.

    Local processes that die are replaced, and what they were doing is done again; on a cluster its scheduler sees to
    that. Only a few tasks wait at a time, whatever their number.
    """
    from joblib import Parallel, cpu_count, delayed
    from joblib.externals.loky import get_reusable_executor

    left = dict.fromkeys(items)
    failures = 0
    while left:
        progressed = False
        with ExitStack() as stack:
            jobs = backend.workers or min(cpu_count(), usual_workers())
            if backend.name == "dask":
                stack.enter_context(_cluster(backend))
                jobs = -1
            else:
                # Ended here, since joblib would keep them for minutes in case that more is to be done.
                stack.callback(
                    lambda: get_reusable_executor(reuse=True).shutdown(wait=True, kill_workers=True)
                )
            # One task a batch: a result is stored as soon as it is there, and a killed worker costs no other one.
            parallel = Parallel(n_jobs=jobs, batch_size=1, return_as="generator_unordered")
            # Whoever kills the campaign means its workers too, which joblib would leave waiting for minutes.
            parent = None if backend.name == "dask" else os.getpid()
            # A cluster's workers have environments of their own.
            isolation = os.environ.get(ISOLATION_VARIABLE, Isolation.AUTO)
            results = parallel(delayed(_kept)(task, package, item, parent, isolation) for item in list(left))
            try:
                for item, result in results:
                    del left[item]
                    progressed = True
                    yield item, result
            except BrokenExecutor as error:
                failures = 1 if progressed else failures + 1
                if failures == _ATTEMPTS:
                    raise lack_of_memory(
                        f"worker processes were killed {failures} times in a row, perhaps for want of memory"
                    ) from error


def _kept(
    task: Callable[[bytes, ItemT], ResultT],
    package: bytes,
    item: ItemT,
    parent: int | None,
    isolation: str,
) -> tuple[ItemT, ResultT]:
    # A single worker is the parent itself.
    if os.getpid() != parent:
        os.environ[ISOLATION_VARIABLE] = isolation
        if parent is not None:
            end_with_parent(parent)
    return item, task(package, item)


@contextmanager
def _cluster(backend: Backend) -> Iterator[None]:
    from distributed import Client
    from joblib import parallel_config

    connect: Any = Client
    try:
        client = connect(backend.scheduler, timeout=_CONNECTION_SECONDS, set_as_default=False)
    except (OSError, TimeoutError, ValueError) as error:
        raise InputError(
            f"no dask scheduler answers at {one_line(str(backend.scheduler))}: {one_line(str(error))}; "
            "name the address that dask scheduler prints, such as tcp://127.0.0.1:8786"
        ) from error
    with client, parallel_config(backend="dask", client=client):
        try:
            yield
        except TimeoutError as error:
            raise InputError(
                f"the dask cluster at {one_line(str(backend.scheduler))} has no workers; start some"
            ) from error
