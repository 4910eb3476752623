"""Drawing from a seed alone, whatever else is on the machine or in the process."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from tempfile import TemporaryDirectory
from typing import Any
from unittest import mock

from hypothesis import configuration
from hypothesis.internal.conjecture import providers


@contextmanager
def from_the_seed_alone() -> Iterator[None]:
    """Let Hypothesis take nothing from its surroundings, and leave nothing in them.

    It draws numbers that stand in the sources of modules outside of site-packages: in a candidate's own, and in
    drivegate's where it runs from a checkout. So the same seed would draw other scenarios for other candidates, and
    in other places. Its notes would go into somebody's working folder.
    """
    none: Any = getattr(providers, "Constants", None)
    # A test that draws by itself goes on in this process, and keeps its notes where it had them.
    home = getattr(configuration, "__hypothesis_home_directory", None)
    with ExitStack() as restored:
        folder = restored.enter_context(TemporaryDirectory(prefix="drivegate"))
        restored.callback(configuration.set_hypothesis_home_dir, home)
        configuration.set_hypothesis_home_dir(folder)
        # Versions before 6.131 take no numbers from sources.
        if none is not None:
            restored.enter_context(mock.patch.object(providers, "_get_local_constants", none))
            # What was permitted before may hold such numbers still.
            providers.CONSTANTS_CACHE.cache.clear()
        yield
