"""What every test finds around it, alone or beside others, in a terminal or behind a script."""

import signal
from collections.abc import Iterator

import pytest


@pytest.fixture(autouse=True, scope="session")
def unattended() -> Iterator[None]:
    """Take away a terminal's width, which pytest-xdist tells its workers, and answer Ctrl-C.

    A shell that starts the tests in the background has them ignore Ctrl-C, and all that they start with them.
    """
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    with pytest.MonkeyPatch.context() as patched:
        patched.delenv("COLUMNS", raising=False)
        if ignored:
            signal.signal(signal.SIGINT, signal.default_int_handler)
        yield
        if ignored:
            signal.signal(signal.SIGINT, signal.SIG_IGN)
