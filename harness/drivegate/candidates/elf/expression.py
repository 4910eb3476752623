"""Arithmetic in a manifest, such as ``2048 + 12.4 * phase_currents[0]``, as steps for a stack of numbers.

The text is parsed by Python, and everything but arithmetic is refused; nothing of it is evaluated as Python.
"""

from __future__ import annotations

import ast
import keyword
import re
from collections.abc import Iterator
from typing import Final, NamedTuple

from drivegate_cases.documents.wording import short_line
from drivegate_models.errors import InputError

LONGEST: Final = 500
"""Greatest length of an expression."""
# The compiled step has this many words for it in its state (`processor.WORDS`).
DEEPEST: Final = 32
"""Greatest number of values on the stack."""

_OPERATORS: Final[dict[type[ast.operator], str]] = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Mod: "%",
    ast.BitAnd: "&",
    ast.BitOr: "|",
    ast.BitXor: "^",
    ast.LShift: "<<",
    ast.RShift: ">>",
}
_OF_SIGN: Final[dict[type[ast.unaryop], str]] = {ast.USub: "negated", ast.Invert: "~"}
_NAME: Final = re.compile(r"(?<!\w)[^\W\d]\w*")
_MARK: Final = "__name"
_SCOPE: Final = "__scope_of_"
_OF_ONE: Final = ("abs", "floor", "round")
_OF_MANY: Final = ("min", "max")
_ALLOWED: Final = f"numbers, names, + - * / % & | ^ ~ << >>, {', '.join((*_OF_MANY, *_OF_ONE))}"


class Place(NamedTuple):
    """A variable, or a part of one, as it is written: ``TIM1.CCR1`` or ``TIM_TypeDef(0x4001_0000).CCR1``."""

    root: str
    """Name of a variable, in C++ with its namespace; of a type where there is an address."""
    address: int | None
    """Where a value of that type is."""
    path: tuple[str | int, ...]
    """Names of fields and numbers of elements, from the outside in."""

    @property
    def text(self) -> str:
        """Write it as in a manifest."""
        if self.address is None:
            root = self.root
        else:
            # In halves it is not taken for an address of this machine, which reports leave out.
            root = f"{self.root}(0x{self.address >> 16:04X}_{self.address & 0xFFFF:04X})"
        return root + "".join(f"[{part}]" if isinstance(part, int) else f".{part}" for part in self.path)


Step = float | Place | str
"""A number or a place, which is put on the stack, or an operation on what is on top of it."""


def parsed(text: str) -> tuple[Step, ...]:
    steps = tuple(_steps(_tree(text)))
    depth = deepest = 0
    for step in steps:
        is_operation = isinstance(step, str)
        depth += 0 if step in (*_OF_ONE, *_OF_SIGN.values()) else -1 if is_operation else 1
        deepest = max(deepest, depth)
    if deepest > DEEPEST:
        raise InputError(f"'{short_line(text)}' is nested too deeply; write it with fewer parentheses")
    return steps


def parsed_place(text: str) -> Place:
    """Parse a variable or a part of one."""
    steps = tuple(_steps(_tree(text)))
    if len(steps) != 1 or not isinstance(steps[0], Place):
        raise InputError(
            f"'{short_line(text)}' is no variable; write one such as 'ADC_Value[0]' or 'TIM1.CCR1'"
        )
    return steps[0]


def _tree(text: str) -> ast.expr:
    try:
        if len(text) > LONGEST:
            raise ValueError(f"it has more than {LONGEST} characters")
        # What is a word of Python, such as a variable `in`, is renamed.
        marked = _NAME.sub(lambda name: name[0] + _MARK * keyword.iskeyword(name[0]), text.strip())
        # As in C, a field behind a pointer may be written so.
        marked = marked.replace("->", ".").replace("::", _SCOPE)
        return ast.parse(marked, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        reason = error.msg if isinstance(error, SyntaxError) else str(error)
        raise InputError(f"'{short_line(text)}' is no expression: {short_line(reason)}") from error


def _steps(node: ast.expr) -> Iterator[Step]:
    """List the steps of an expression, operands first."""
    place = _place(node)
    if place is not None:
        yield place
    elif (
        isinstance(node, ast.Constant)
        and isinstance(node.value, int | float)
        and not isinstance(node.value, bool)
    ):
        yield _number(node.value)
    elif isinstance(node, ast.BinOp) and type(node.op) in _OPERATORS:
        yield from _steps(node.left)
        yield from _steps(node.right)
        yield _OPERATORS[type(node.op)]
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.UAdd | ast.Invert):
        yield from _steps(node.operand)
        if type(node.op) in _OF_SIGN:
            yield _OF_SIGN[type(node.op)]
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and not node.keywords:
        yield from _call(node, node.func.id)
    else:
        raise InputError(f"'{short_line(ast.unparse(node))}' is not allowed; an expression has {_ALLOWED}")


def _number(value: float) -> float:
    try:
        return float(value)
    except OverflowError as error:
        raise InputError(f"'{short_line(str(value))}' is too large for a number") from error


def _whole(node: ast.expr) -> int | None:
    """Return the whole number, not negative, that a node is; None where it is none."""
    if isinstance(node, ast.Constant) and isinstance(node.value, int) and not isinstance(node.value, bool):
        return node.value
    return None


def _call(node: ast.Call, name: str) -> Iterator[Step]:
    count = len(node.args)
    if not ((name in _OF_ONE and count == 1) or (name in _OF_MANY and count >= 2)):
        raise InputError(
            f"'{short_line(ast.unparse(node))}' is no call of a known function; there are {_ALLOWED}"
        )
    for number, argument in enumerate(node.args):
        yield from _steps(argument)
        if number or count == 1:
            yield name


def _place(node: ast.expr) -> Place | None:
    """Return the place that a node names; None where it names none."""
    if isinstance(node, ast.Name):
        return Place(_written(node.id), None, ())
    if isinstance(node, ast.Attribute):
        outer, part = _place(node.value), _written(node.attr)
        return None if outer is None else outer._replace(path=(*outer.path, part))
    if isinstance(node, ast.Subscript):
        outer, number = _place(node.value), _whole(node.slice)
        return None if outer is None or number is None else outer._replace(path=(*outer.path, number))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and len(node.args) == 1:
        name, address = node.func.id, _whole(node.args[0])
        if name not in _OF_ONE and address is not None and address < 2**32:
            return Place(_written(name), address, ())
    return None


def _written(name: str) -> str:
    """Return a name as it was before it was made one of Python."""
    return name.replace(_MARK, "").replace(_SCOPE, "::")
