"""Nothing on the way to a verdict is computed by a library that rounds by the processor at hand.

Sums, products, quotients and square roots are rounded alike everywhere, and so is what follows from the bits of a
number. Powers, exponentials, logarithms and angles are not: C libraries and numpy have several of each.
"""

from __future__ import annotations

import ast
from pathlib import Path

import drivegate
import drivegate_cases
import drivegate_models

_INEXACT = frozenset(
    [
        "exp",
        "exp2",
        "expm1",
        "log",
        "log1p",
        "log2",
        "log10",
        "pow",
        "power",
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "atan2",
        "arcsin",
        "arccos",
        "arctan",
        "arctan2",
        "sinh",
        "cosh",
        "tanh",
        "asinh",
        "acosh",
        "atanh",
        "arcsinh",
        "arccosh",
        "arctanh",
        "cbrt",
        "erf",
        "erfc",
        "gamma",
        "lgamma",
        "sinc",
        "dot",
        "matmul",
        "einsum",
    ]
)
_LIBRARIES = frozenset({"math", "np", "numpy", "cmath", "scipy"})


def _folder(package) -> Path:  # type: ignore[no-untyped-def]
    return Path(package.__file__).parent


_HARNESS = [
    _folder(drivegate) / name
    for name in ("scenarios", "checks", "contracts", "drives", "gate", "containment")
]
_SOURCES = sorted(
    file
    for folder in (_folder(drivegate_models), _folder(drivegate_cases), *_HARNESS)
    for file in folder.rglob("*.py")
)


def _is_inexact(node: ast.AST, is_compiled: bool) -> bool:
    if isinstance(node, ast.ImportFrom):
        return node.module in _LIBRARIES and any(alias.name in _INEXACT for alias in node.names)
    if isinstance(node, ast.Attribute):
        return isinstance(node.value, ast.Name) and node.value.id in _LIBRARIES and node.attr in _INEXACT
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.MatMult):
        return True
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
        # Of whole numbers exact; in compiled code a whole exponent becomes products.
        whole_base = isinstance(node.left, ast.Constant) and isinstance(node.left.value, int)
        whole_exponent = isinstance(node.right, ast.Constant) and isinstance(node.right.value, int)
        return not (whole_base or (is_compiled and whole_exponent))
    return False


def test_no_source_on_the_way_to_a_verdict_calls_such_a_function() -> None:
    assert len(_SOURCES) > 100, "the sources have not been found"
    compiled = _folder(drivegate_models)
    found = [
        f"{file}:{node.lineno}"  # type: ignore[attr-defined]
        for file in _SOURCES
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if _is_inexact(node, file.is_relative_to(compiled))
    ]
    assert not found, f"write these with operations that every processor rounds alike: {', '.join(found)}"
