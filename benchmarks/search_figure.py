"""The comparison of searches as a figure and as tables."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from math import hypot, inf, sqrt
from pathlib import Path
from statistics import fmean, median, stdev
from typing import Any, Final, NamedTuple

from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_reports.page.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY,
    VERMILION,
    house_style,
    svg_document,
)
from search_methods import SHARD_ALLOWANCE
from search_trials import LEVELS, SEEDS, allowance, expected_draws
from weakened_faults import FAULTS
from weakening import WeakenedFault

TITLES: Final = {
    "random": "even drawing",
    "drawing": "Hypothesis, drawing",
    "climbing": "Hypothesis, target",
    "shard": "as a shard of the gate",
    "covariance": "CMA-ES",
    "bayesian": "Bayesian (TPE)",
    "alternating": "draw and step in turn",
    "simplex": "Nelder-Mead",
    "uniform": "psy-taliro, uniform",
    "annealing": "psy-taliro, annealing",
}
BLACK: Final = "#000000"
_PANELS: Final = 3
"""Panels of the figure next to each other."""
_LOOKS: Final = {
    "drawing": (GREY, "s"),
    "climbing": (ORANGE, "D"),
    "shard": (VERMILION, "P"),
    "covariance": (BLUE, "o"),
    "bayesian": (PURPLE, "^"),
    "alternating": (GREEN, "v"),
    "simplex": (SKY, "<"),
    "annealing": (BLACK, ">"),
}


def runs_to_failure(cells: dict[str, Any], fault: WeakenedFault, method: str, level: int) -> list[float]:
    """List the runs to the first counterexample by seed, infinite where none was found."""
    runs = []
    for seed in SEEDS:
        if fault.shape == "sudden":
            first = cells[f"{fault.name}/{method}/-1/{seed}"]["first"][level]
            runs.append(inf if first is None else float(first))
        else:
            cell = cells[f"{fault.name}/{method}/{level}/{seed}"]
            runs.append(float(cell["runs"]) if cell["found"] else inf)
    return runs


class Share(NamedTuple):
    """A share of levels and seeds, and twice its standard error over the seeds; None where it is known."""

    value: float
    error: float | None = None

    def __str__(self) -> str:
        return (
            f"{100.0 * self.value:.0f}"
            + ("" if self.error is None else f" ± {100.0 * self.error:.0f}")
            + " %"
        )


def found_share(cells: dict[str, Any], fault: WeakenedFault, method: str, within: int) -> Share:
    """Return the share of all levels and seeds in which a counterexample was found within some runs.

    Of drawing evenly this is what its share of failing points makes probable.
    """
    if method == "random":
        return Share(fmean(1.0 - (1.0 - 1.0 / expected_draws(level)) ** within for level in range(LEVELS)))
    if method == "climbing" and within <= SHARD_ALLOWANCE:
        # The target phase begins at half of the allowance, whatever that is.
        method = "climbing-briefly"
    by_level = [runs_to_failure(cells, fault, method, level) for level in range(LEVELS)]
    by_seed = [fmean(run <= within for run in runs) for runs in zip(*by_level, strict=True)]
    return Share(fmean(by_seed), 2.0 * stdev(by_seed) / sqrt(len(by_seed)))


def _mean(shares: Sequence[Share]) -> Share:
    """Return the mean share of several faults, with an error where each has one."""
    errors = [share.error for share in shares if share.error is not None]
    error = hypot(*errors) / len(shares) if len(errors) == len(shares) else None
    return Share(fmean(share.value for share in shares), error)


def compared(cells: dict[str, Any]) -> list[str]:
    """Return the methods whose trials were made, with even drawing, whose shares are known."""
    made = {key.split("/")[1] for key in cells if "/" in key}
    return [method for method in TITLES if method == "random" or method in made]


def levels_near_the_best(cells: dict[str, Any], fault: WeakenedFault) -> tuple[int, int]:
    """Count the levels at which a shard's median is at most 1.5 times that of each other method.

    The second number is that of the levels at which some method found the fault with half of its seeds.
    """
    medians = {
        method: [median(runs_to_failure(cells, fault, method, level)) for level in range(LEVELS)]
        for method in compared(cells)
        if method in _LOOKS
    }
    shard = medians.pop("shard")
    best = [min(runs) for runs in zip(*medians.values(), strict=True)]
    found = [pair for pair in zip(shard, best, strict=True) if min(pair) < inf]
    return sum(own <= 1.5 * other for own, other in found), len(found)


def tables(cells: dict[str, Any]) -> str:
    """Write what was found within the allowance, and within that of a shard of the gate."""
    methods, minutes = compared(cells), sum(cell["seconds"] for cell in cells.values()) / 60.0
    lines = [
        f"Made in {minutes:.0f} minutes of processor time. Counterexamples found, as a share of all levels and seeds, "
        f"± twice the standard error over the {len(SEEDS)} seeds. The last column counts the levels at which the "
        "shard's median is at most 1.5 times the best other one, of those at which a median was found.",
        "",
        f"| fault | check | kind | runs | {' | '.join(TITLES[method] for method in methods)} | levels |",
        f"|---|---|---|---:|{'---:|' * len(methods)}---:|",
    ]
    for fault in FAULTS:
        shares = (found_share(cells, fault, method, allowance(fault)) for method in methods)
        first = f"| {fault.name} | `{fault.check}` | {fault.shape} | {allowance(fault)} "
        near, levels = levels_near_the_best(cells, fault)
        lines.append(f"{first}| {' | '.join(map(str, shares))} | {near} of {levels} |")
    drives = dict.fromkeys(fault.cube.drive.name for fault in FAULTS)
    for shape, drive in product(("gradual", "sudden"), drives):
        chosen = [fault for fault in FAULTS if (fault.shape, fault.cube.drive.name) == (shape, drive)]
        for within in (None, SHARD_ALLOWANCE):
            means = (
                _mean([found_share(cells, fault, method, within or allowance(fault)) for fault in chosen])
                for method in methods
            )
            title = f"all {shape} ones of `{drive}`" + (f", first {within} runs" if within else "")
            lines.append(f"| *{title}* | | | | {' | '.join(map(str, means))} | |")
    return "\n".join(lines)


def write_figure(cells: dict[str, Any], file: Path) -> None:
    """Draw the runs to the first counterexample over how rare failures are, a panel for each fault."""
    from matplotlib.figure import Figure

    with house_style():
        rows = -(-len(FAULTS) // _PANELS)
        figure = Figure(figsize=(9.0, 2.6 * rows), layout="constrained")
        panels = figure.subplots(rows, _PANELS, sharex=True, sharey=True).ravel()
        for panel, fault in zip(panels, FAULTS, strict=False):
            _draw(panel, cells, fault)
        for panel in panels[len(FAULTS) :]:
            panel.set_visible(False)
        for panel in panels[len(FAULTS) - _PANELS : len(FAULTS)]:
            panel.tick_params(labelbottom=True)
        figure.supxlabel("runs that even drawing needs on average")
        figure.supylabel("runs needed")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=3, frameon=False, fontsize=9.0)
        write_atomically(file, svg_document(figure, "search-comparison"))


def _draw(panel: Any, cells: dict[str, Any], fault: WeakenedFault) -> None:
    draws = [expected_draws(level) for level in range(LEVELS)]
    most = allowance(fault)
    panel.set(xscale="log", yscale="log", ylim=(5.0, 1200.0), xlim=(30.0, 3.0e5))
    panel.set_title(f"{fault.name} ({fault.check}, {fault.shape})", fontsize=9.0)
    panel.plot(draws, draws, color=GREY, linestyle="--", linewidth=1.2, label=TITLES["random"])
    panel.axhline(most, color=GREY, linewidth=0.8, linestyle=":")
    looks = {method: look for method, look in _LOOKS.items() if method in compared(cells)}
    for place, (method, (colour, marker)) in enumerate(looks.items()):
        # Beside each other, since many lie at the allowance.
        shift = 10.0 ** (0.1 * (place - 0.5 * (len(looks) - 1)))
        middle = [median(runs_to_failure(cells, fault, method, level)) for level in range(LEVELS)]
        found = [(draw * shift, runs) for draw, runs in zip(draws, middle, strict=True) if runs <= most]
        missed = [draw * shift for draw, runs in zip(draws, middle, strict=True) if runs > most]
        style = {"color": colour, "marker": marker, "markersize": 4.5, "linestyle": "none"}
        panel.plot(*zip(*found or [(inf, inf)], strict=True), **style, label=TITLES[method])
        panel.plot(missed, [most] * len(missed), **style, markerfacecolor="none", alpha=0.8)
