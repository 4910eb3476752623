"""The builder of the examples, which makes FMUs from controllers in C."""

import importlib.util
from collections.abc import Callable
from pathlib import Path

import pytest

BUILDER = Path(__file__).parents[3] / "harness/drivegate/templates/new/fmu/fmi/build_fmu.py"


@pytest.fixture(scope="session")
def build_fmu() -> Callable[..., Path]:
    """Build an FMU from C files."""
    spec = importlib.util.spec_from_file_location("build_fmu", BUILDER)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    made: Callable[..., Path] = module.build_fmu
    return made
