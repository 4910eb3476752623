"""The keeper of a process: a small process between it and the harness, which lets nothing outlive it.

The keeper starts the worker, then waits until the harness closes the keeper's standard input, which also happens
when the harness is killed. Then it kills the worker and every process that came from it, and removes their
temporary folder. On Linux it adopts processes whose own parents have ended (`PR_SET_CHILD_SUBREAPER`), also those
that made a session of their own, so it has killed all of them when it has no child left.

It imports little, so that it is small and starts at once.
"""

import atexit
import gc
import os
import shutil
import signal
import stat
import sys
from contextlib import suppress
from importlib import import_module
from pathlib import Path

from drivegate.isolation.descendants import adopt_orphans, kill_descendants
from drivegate.isolation.layers import Layer, isolate, read_order
from drivegate.isolation.namespaces import enter_process_namespace
from drivegate.isolation.system_calls import die_first

_BLOCK = 4096


def keep(role: str, isolation: str, temporary: str, *descriptors: str) -> None:
    """Start a worker process, and see to it that nothing of it is left once standard input ends.

    In the keeper this does not return; in the worker it returns when its parent has hung up. The keeper reports
    on its standard output the worker's process id, and at the end its exit status, negative for a signal.
    """
    # Before the worker exists, so that the keeper adopts every orphan of it.
    adopt_orphans()
    layers, places = read_order(isolation)
    # The new table of processes holds only what is forked from now on: the worker. The keeper stays outside, where it
    # survives the end of the table and reports the status.
    if Layer.NAMESPACES in layers:
        enter_process_namespace()
    keeper = os.getpid()
    worker = os.fork()
    if worker == 0:
        # A process group for the worker, so that one signal kills all that has not left it.
        os.setsid()
        die_first()
        isolate(layers, places)
        _become_worker(role, temporary, [int(descriptor) for descriptor in descriptors], keeper)
        return
    status = None
    try:
        # The judge notices the end of the worker by a closed connection, which the keeper must not hold open.
        for descriptor in descriptors:
            os.close(int(descriptor))
        _report(worker)
        while os.read(sys.stdin.fileno(), _BLOCK):
            continue
    finally:
        # Whatever fails here, the folder has to go and the status has to be reported.
        with suppress(BaseException):
            status = kill_descendants(worker)
        with suppress(BaseException):
            _remove(Path(temporary))
        _report(-signal.SIGKILL if status is None else status)
        # Exit handlers of imported modules take time, and have nothing to clean up here.
        os._exit(0)


def _become_worker(role: str, temporary: str, descriptors: list[int], keeper: int) -> None:
    """Leave the keeper's streams: nothing to read, and what is printed goes to the harness."""
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    os.close(nothing)
    os.dup2(2, 1)
    # At the end, the interpreter searches all that was imported for garbage. That took a good part of the processor
    # time of a short process.
    atexit.register(gc.freeze)
    import_role(role)
    if role == "candidate":
        from drivegate.containment.serving import serve

        connection, progress = descriptors
        serve(connection, progress, keeper)
    else:
        from drivegate.containment.judge_process import judge_jobs

        judge_jobs(descriptors[0], temporary, keeper)


def import_role(role: str, *modules: str) -> None:
    """Import what a worker needs, unless it is a copy of a template that has done so, and further modules.

    A keeper that is not a copy does without.
    """
    # What is imported is left out of every search for garbage: there is none in it, and the search takes long.
    gc.disable()
    of_role = "serving" if role == "candidate" else "judge_process"
    for module in (f"drivegate.containment.{of_role}", *modules):
        import_module(module)
    gc.freeze()
    gc.enable()


def _report(number: int) -> None:
    with suppress(OSError):
        os.write(1, f"{number}\n".encode())


def _remove(folder: Path) -> None:
    """Remove a folder, also one in which the worker has taken the right to do so from its owner."""
    shutil.rmtree(folder, ignore_errors=True)
    for inside, names, _ in os.walk(folder):
        for place in (Path(inside, name) for name in names):
            if not place.is_symlink():
                with suppress(OSError):
                    place.chmod(stat.S_IRWXU)
    shutil.rmtree(folder, ignore_errors=True)
