"""Reading behind an address from compiled code."""

from typing import Any

import numba
import numpy as np

from drivegate_models.compilation.calling import double_at


@numba.njit
def total_behind(address: int, count: int) -> float:
    total = 0.0
    for index in range(count):
        total += double_at(address, index)
    return total


def test_the_doubles_behind_an_address_are_read_in_their_order() -> None:
    values = np.array([1.5, -2.25, 4.0])
    address: Any = np.uintp(values.ctypes.data)
    assert [total_behind(address, count) for count in (1, 2, 3)] == [1.5, -0.75, 3.25]
