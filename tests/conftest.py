"""What every test finds around it, alone or beside others, in a terminal or behind a script."""

import gc
import os
import signal
from collections.abc import Iterator

import pytest
from hypothesis import settings

# The first example of a test may have to compile.
settings.register_profile("tests", deadline=None)
settings.load_profile("tests")


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_auto_num_workers() -> int:
    """Take one worker more than there are processors: tests wait for processes and hangs a fifth of the time."""
    return (os.cpu_count() or 1) + 1


def pytest_sessionstart(session: pytest.Session) -> None:
    """Compile the kernels once before workers start, each of which would compile them for itself."""
    if not getattr(session.config.option, "numprocesses", None) or "NUMBA_DISABLE_JIT" in os.environ:
        return
    from drivegate.drives.kinds import DRIVE_KINDS
    from drivegate.gate.warm_up import compile_missing
    from drivegate_cases.drive.drive_document import load_drive

    compile_missing(load_drive(kind.default_drive) for kind in DRIVE_KINDS.values())


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[object]:
    """Search for no garbage among modules and tests: not while they grow, which took a quarter of it, nor later."""
    gc.disable()
    collected = yield
    gc.collect()
    gc.freeze()
    gc.enable()
    return collected


@pytest.fixture(autouse=True, scope="session")
def unattended() -> Iterator[None]:
    """Take away a terminal's width, which pytest-xdist passes to its workers, and answer Ctrl-C.

    A shell that starts the tests in the background has them ignore Ctrl-C, and all that they start with them.
    """
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    with pytest.MonkeyPatch.context() as patched:
        patched.delenv("COLUMNS", raising=False)
        if "PYTEST_XDIST_WORKER" in os.environ:
            # The other processors have workers of their own, and each process of a check takes a second to start.
            patched.setattr(os, "cpu_count", lambda: 1)
        if ignored:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        yield
        if ignored:
            signal.signal(signal.SIGINT, signal.SIG_IGN)


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pages with empty figures, since to draw them takes longer than all else; a few tests draw them."""
    empty = '<svg xmlns="http://www.w3.org/2000/svg" width="1" height="1"></svg>'
    monkeypatch.setattr("drivegate_reports.page.style.svg_document", lambda *_, **__: empty)
    monkeypatch.setattr("drivegate_reports.comparison.figures._settled", lambda figure: figure)
