"""The comparison of searches as a figure and as tables."""

from __future__ import annotations

from math import inf
from pathlib import Path
from statistics import fmean, median
from typing import Any, Final

from drivegate_cases.documents.atomic_write import write_atomically
from drivegate_reports.page.style import (
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    VERMILION,
    house_style,
    svg_document,
)
from search_methods import SHARD_ALLOWANCE
from search_trials import LEVELS, allowance, expected_draws, seeds
from weakened_faults import FAULTS, WeakenedFault

BEGIN: Final = "<!-- search tables: begin -->"
END: Final = "<!-- search tables: end -->"
TITLES: Final = {
    "random": "even drawing",
    "drawing": "Hypothesis, drawing",
    "climbing": "Hypothesis, target",
    "shard": "as a shard of the gate",
    "covariance": "CMA-ES",
    "bayesian": "Bayesian (TPE)",
    "alternating": "draw and step in turn",
}
_LOOKS: Final = {
    "drawing": (GREY, "s"),
    "climbing": (ORANGE, "D"),
    "shard": (VERMILION, "P"),
    "covariance": (BLUE, "o"),
    "bayesian": (PURPLE, "^"),
    "alternating": (GREEN, "v"),
}


def runs_to_failure(cells: dict[str, Any], fault: WeakenedFault, method: str, level: int) -> list[float]:
    """List the runs to the first counterexample by seed, infinite where none was found."""
    runs = []
    for seed in seeds(fault):
        if fault.shape == "sudden":
            first = cells[f"{fault.name}/{method}/-1/{seed}"]["first"][level]
            runs.append(inf if first is None else float(first))
        else:
            cell = cells[f"{fault.name}/{method}/{level}/{seed}"]
            runs.append(float(cell["runs"]) if cell["found"] else inf)
    return runs


def found_share(cells: dict[str, Any], fault: WeakenedFault, method: str, within: int) -> float:
    """Return the share of all levels and seeds in which a counterexample was found within some runs.

    Of drawing evenly this is what its share of failing points makes probable.
    """
    if method == "random":
        return fmean(1.0 - (1.0 - 1.0 / expected_draws(level)) ** within for level in range(LEVELS))
    if method == "climbing" and within <= SHARD_ALLOWANCE:
        # The target phase begins at half of the allowance, whatever that is.
        method = "climbing-briefly"
    runs = [run for level in range(LEVELS) for run in runs_to_failure(cells, fault, method, level)]
    return fmean(run <= within for run in runs)


def tables(document: dict[str, Any]) -> str:
    """Write what was found within the allowance, and within that of a shard of the gate."""
    cells = document["cells"]
    lines = [
        f"Made in {document['processor_seconds'] / 60.0:.0f} minutes of processor time. Counterexamples found, "
        "as a share of all levels and seeds:",
        "",
        f"| fault | check | kind | runs | seeds | {' | '.join(TITLES.values())} |",
        f"|---|---|---|---:|---:|{'---:|' * len(TITLES)}",
    ]
    for fault in FAULTS:
        shares = (found_share(cells, fault, method, allowance(fault)) for method in TITLES)
        figures = " | ".join(f"{100.0 * share:.0f} %" for share in shares)
        lines.append(
            f"| {fault.name} | `{fault.check}` | {fault.shape} | {allowance(fault)} | {len(seeds(fault))} | {figures} |"
        )
    for title, shape, within in (
        ("all gradual ones", "gradual", None),
        (f"all gradual ones, first {SHARD_ALLOWANCE} runs", "gradual", SHARD_ALLOWANCE),
        ("all sudden ones", "sudden", None),
        (f"all sudden ones, first {SHARD_ALLOWANCE} runs", "sudden", SHARD_ALLOWANCE),
    ):
        chosen = [fault for fault in FAULTS if fault.shape == shape]
        shares = (
            fmean(found_share(cells, fault, method, within or allowance(fault)) for fault in chosen)
            for method in TITLES
        )
        lines.append(f"| *{title}* | | | | | {' | '.join(f'{100.0 * share:.0f} %' for share in shares)} |")
    return "\n".join(lines)


def write_tables(document: dict[str, Any], page: Path) -> None:
    """Write the tables between their two marks in a page."""
    before, rest = page.read_text(encoding="utf-8").split(BEGIN)
    after = rest.split(END)[1]
    write_atomically(page, f"{before}{BEGIN}\n\n{tables(document)}\n\n{END}{after}")


def write_figure(document: dict[str, Any], file: Path) -> None:
    """Draw the runs to the first counterexample over how rare failures are, a panel for each fault."""
    from matplotlib.figure import Figure

    with house_style():
        figure = Figure(figsize=(6.8, 9.4), layout="constrained")
        panels = figure.subplots((len(FAULTS) + 1) // 2, 2, sharex=True, sharey=True).ravel()
        for panel, fault in zip(panels, FAULTS, strict=False):
            _draw(panel, document["cells"], fault)
        for panel in panels[-2:]:
            panel.set_xlabel("runs that even drawing needs on average")
        for panel in panels[::2]:
            panel.set_ylabel("runs needed")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=3, frameon=False, fontsize=9.0)
        write_atomically(file, svg_document(figure, "search-comparison"))


def _draw(panel: Any, cells: dict[str, Any], fault: WeakenedFault) -> None:
    draws = [expected_draws(level) for level in range(LEVELS)]
    most = allowance(fault)
    panel.set(xscale="log", yscale="log", ylim=(5.0, 1200.0), xlim=(60.0, 1.9e5))
    panel.set_title(f"{fault.name} ({fault.check}, {fault.shape})", fontsize=9.0)
    panel.plot(draws, draws, color=GREY, linestyle="--", linewidth=1.2, label=TITLES["random"])
    panel.axhline(most, color=GREY, linewidth=0.8, linestyle=":")
    for place, (method, (colour, marker)) in enumerate(_LOOKS.items()):
        # Beside each other, since many lie at the allowance.
        shift = 10.0 ** (0.04 * (place - 2.5))
        middle = [median(runs_to_failure(cells, fault, method, level)) for level in range(LEVELS)]
        found = [(draw * shift, runs) for draw, runs in zip(draws, middle, strict=True) if runs <= most]
        missed = [draw * shift for draw, runs in zip(draws, middle, strict=True) if runs > most]
        style = {"color": colour, "marker": marker, "markersize": 4.5, "linestyle": "none"}
        panel.plot(*zip(*found or [(inf, inf)], strict=True), **style, label=TITLES[method])
        panel.plot(missed, [most] * len(missed), **style, markerfacecolor="none", alpha=0.8)
