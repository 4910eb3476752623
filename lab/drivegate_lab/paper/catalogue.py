"""The figures of the paper that physics can give, in the paper's order."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from drivegate_lab.paper.figures import (
    cycle_waveforms,
    initial_angle,
    input_current,
    instantaneous_torque,
    phase_currents,
    ripple_over_speed,
    search_trajectory,
    speed_limit,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper as the models give it."""

    name: str
    """Name of its files."""
    label: str
    """What the paper calls it."""
    module: str
    """Name of its module in `drivegate_lab.paper.figures`, by which facts refer to it."""
    facts: tuple[str, ...]
    """Facts that it bears on."""
    title: str
    """Its title."""
    compute: Callable[[], Any]
    """Computes its data, once."""
    draw: Callable[[Any], Figure]
    """Draws the data, in the house style."""
    alternative: Callable[[Any], str]
    caption: Callable[[Any], str]
    """Describe the data in words: for who cannot see it, and below the figure."""


def _of(
    name: str, label: str, facts: tuple[str, ...], module: Any, compute: Callable[[], Any]
) -> PaperFigure:
    return PaperFigure(
        name=name,
        label=label,
        module=module.__name__.rpartition(".")[2],
        facts=facts,
        title=module.TITLE,
        compute=compute,
        draw=module.draw,
        alternative=module.alternative,
        caption=module.caption,
    )


@cache
def _both_currents() -> tuple[phase_currents.PhaseCurrents, ...]:
    return tuple(map(phase_currents.phase_currents, phase_currents.POINTS))


FIGURES: Final = (
    _of("waveforms", "Fig. 1", ("Fig. 1",), cycle_waveforms, cycle_waveforms.cycle_waveforms),
    _of("initial-angle", "Fig. 3", ("P5",), initial_angle, initial_angle.initial_angles),
    _of("search", "Fig. 5", ("P6", "P11"), search_trajectory, search_trajectory.search_trajectory),
    _of("torque", "Fig. 6", ("P8",), instantaneous_torque, instantaneous_torque.torque_cycle),
    _of("ripple", "Ripple over speed", ("P8",), ripple_over_speed, ripple_over_speed.ripple_over_speed),
    _of("saving", "Fig. 7", ("P4", "P12"), input_current, input_current.input_current_sweep),
    _of("currents", "Figs. 9 and 10", ("P7",), phase_currents, _both_currents),
    _of("speed-limit", "Speed limit", ("P10",), speed_limit, speed_limit.speed_limit),
)
"""Figs. 2, 4 and 8 are diagrams of the controller and of its hardware."""
