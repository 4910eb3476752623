"""Closed loops and draws give the same bits for every instruction set and every variant of the libraries."""

from concurrent.futures import ThreadPoolExecutor

import pytest

from one_verdict import here, restrictions


@pytest.mark.nightly
def test_restricted_targets_give_the_same_bits():
    # The processor's own instructions, and the fewest that any has.
    targets = {name: given for name, given in restrictions().items() if name in ("as it is", "x86-64")}
    with ThreadPoolExecutor(2) as pool:
        digests = dict(zip(targets, pool.map(lambda given: here(0, given), targets.values()), strict=True))
    assert len(set(digests.values())) == 1, f"the digests of observed numbers differ: {digests}"
