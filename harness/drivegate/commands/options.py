"""Options that several commands share, and the types of their values."""

from __future__ import annotations

from collections.abc import Callable
from math import inf, isfinite
from typing import TYPE_CHECKING, Any, TypeVar

import click

from drivegate_cases.wording import shown

if TYPE_CHECKING:
    from drivegate_cases.motor import Motor

_Function = TypeVar("_Function", bound=Callable[..., Any])

json_option = click.option(
    "--json", "as_json", is_flag=True, expose_value=False, help="Print one JSON document, errors too."
)
"""The flag that the command line has read before; here it is only accepted and described."""


class Number(click.ParamType):
    """A finite number within limits.

    Parameters
    ----------
    lowest, highest : float
        The limits.
    above : bool
        Whether the number must be above `lowest`, not at it.
    """

    name = "number"

    def __init__(self, lowest: float, highest: float = inf, *, above: bool = False) -> None:
        self._lowest, self._highest, self._above = lowest, highest, above

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Read a number.

        Parameters
        ----------
        value : object
            What stands on the command line.
        param : click.Parameter or None
            The option.
        ctx : click.Context or None
            The command's context.

        Returns
        -------
        float
            The number.
        """
        try:
            number = float(value)
        except ValueError:
            number = inf
        below = number <= self._lowest if self._above else number < self._lowest
        if not isfinite(number) or below or number > self._highest:
            self.fail(f"it is {shown(value)}, but must be a number {self._range()}", param, ctx)
        return number

    def _range(self) -> str:
        lower = f"above {self._lowest:g}" if self._above else f"from {self._lowest:g}"
        if not isfinite(self._highest):
            return lower if self._above else f"{lower} upward"
        return f"{lower} {'and up ' if self._above else ''}to {self._highest:g}"


def motor_options(function: _Function) -> _Function:
    """Add the options that name a motor and set single values of it.

    Parameters
    ----------
    function : callable
        A command's function; receives `motor` and `settings`.

    Returns
    -------
    callable
        The function with the options.
    """
    function = click.option(
        "--set",
        "settings",
        metavar="KEY=VALUE",
        multiple=True,
        help="Set one key of the motor; may be given again.",
    )(function)
    return click.option(
        "--motor", metavar="NAME|FILE", help="A motor that comes along, or a TOML or JSON file of one."
    )(function)


def chosen_motor(name: str | None, settings: tuple[str, ...], default: Callable[[], Motor]) -> Motor:
    """Find the motor that the options ask for.

    Parameters
    ----------
    name : str or None
        Name or path, if given.
    settings : tuple of str
        Settings, each as ``KEY=VALUE``.
    default : callable
        Gives the motor when no other is named.

    Returns
    -------
    Motor
        The motor.

    Raises
    ------
    InputError
        When it does not exist or is not valid.
    """
    from drivegate_cases.motor import load_motor

    motor = default() if name is None else load_motor(name)
    return motor.with_overrides(settings)
