"""Which contract a Python file is written for, read from what it imports without running it."""

from __future__ import annotations

import ast
from pathlib import Path
from typing import Final

from drivegate.candidates.contract import ContractName

_COMMANDS: Final[dict[str, ContractName]] = {"Command": "current", "DutyCommand": "duty"}


def imported_contract(file: Path) -> ContractName | None:
    """Tell the contract whose command a file imports from drivegate; None where it imports both or neither."""
    try:
        tree = ast.parse(file.read_bytes())
    except (OSError, SyntaxError, ValueError, RecursionError, MemoryError):
        # Loading tells what is wrong.
        return None
    imported = {
        name.name
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.module == "drivegate"
        for name in node.names
    }
    found = {contract for command, contract in _COMMANDS.items() if command in imported}
    return found.pop() if len(found) == 1 else None
