"""Builds the controller before the tests, so that they never see an old one."""

import subprocess
from pathlib import Path


def pytest_configure():
    """Build the library that the manifest names."""
    subprocess.run(["cargo", "build", "--release", "--quiet"], cwd=Path(__file__).parent, check=True)
