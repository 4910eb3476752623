"""Which contract a compiled library serves, told without loading it, which would run its code."""

from __future__ import annotations

import mmap
import re
from pathlib import Path
from typing import Final

from drivegate.candidates.contract import ContractName

# A name in a table of symbols ends with a zero byte and begins behind one, on macOS with an underscore.
_NAMES: Final[dict[ContractName, re.Pattern[bytes]]] = {
    "current": re.compile(rb"[\0_]drivegate_step\0"),
    "duty": re.compile(rb"[\0_]drivegate_duty_step\0"),
}


def contract_served(library: Path) -> ContractName | None:
    """Tell the contract whose step a library names; None where it names both or neither, which loading tells."""
    if library.stat().st_size == 0:
        return None
    with library.open("rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as content:
        served = [contract for contract, name in _NAMES.items() if name.search(content)]
    return served[0] if len(served) == 1 else None
