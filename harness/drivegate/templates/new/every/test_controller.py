"""The gate as tests: one for each check. `pytest -v` lists them, `pytest -k PWR-1` runs one."""

from drivegate import conformance_tests


@conformance_tests("candidate.toml", effort="quick", waivers="waivers.toml")
def test_conformance(conformance):
    """Pass, fail or skip, as one check came out."""
    conformance.verify()
