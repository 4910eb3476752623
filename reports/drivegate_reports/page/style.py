"""The house style of figures, and a figure with its words as a page places it."""

from __future__ import annotations

import gc
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from io import StringIO
from math import inf
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Okabe and Ito, "Color Universal Design": distinguishable with any colour vision.
BLUE: Final = "#0072B2"
VERMILION: Final = "#D55E00"
GREEN: Final = "#009E73"
SKY: Final = "#56B4E9"
ORANGE: Final = "#E69F00"
PURPLE: Final = "#CC79A7"
GREY: Final = "#8A8F98"

DASHED: Final = (0, (4, 3))
DOTTED: Final = (0, (1, 2))

_INK: Final = {
    BLUE: "#00598C",
    VERMILION: "#A34700",
    GREEN: "#00664B",
    SKY: "#1F6E9E",
    ORANGE: "#8A5F00",
    PURPLE: "#8F3F6B",
    GREY: "#565B63",
}
_TEXT = "#22262E"
_GRID = "#E3E6EA"

WIDTH_INCH: Final = 6.8
LEFT: Final = 0.1
RIGHT: Final = 0.995
"""Where panels begin and end, over the width of a figure, if their texts leave room (1)."""
_ROOM_INCH: Final = 0.05
_MOST_ROUNDS: Final = 4

_HOUSE: Final[dict[str, Any]] = {
    "font.family": "sans-serif",
    "font.sans-serif": ["DejaVu Sans", "Verdana", "Arial", "sans-serif"],
    "font.size": 9.5,
    "text.color": _TEXT,
    "axes.labelcolor": _TEXT,
    "axes.edgecolor": "#9AA0A8",
    "axes.labelsize": 9.5,
    "axes.titlesize": 9.5,
    "axes.titlelocation": "left",
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "grid.color": _GRID,
    "grid.linewidth": 0.8,
    "xtick.color": "#565B63",
    "ytick.color": "#565B63",
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "lines.linewidth": 1.8,
    "lines.solid_capstyle": "round",
    "figure.facecolor": "white",
    "savefig.facecolor": "white",
    "path.simplify": True,
    "path.simplify_threshold": 0.2,
}

_NAMED_HERE = re.compile(r'\bid="([^"]+)"')
_REFERRED_TO = re.compile(r'(?:xlink:)?href="#([^"]+)"|url\(#([^)]+)\)')
_NAMESPACE = re.compile(r'\s+xmlns(?::\w+)?="[^"]*"')


@contextmanager
def house_style() -> Iterator[None]:
    """Draw in the house style, whatever the user's own settings are."""
    import matplotlib

    # Figures consist of cycles; each search for them would go through all that was loaded before.
    gc.freeze()
    try:
        with matplotlib.rc_context():
            matplotlib.rcdefaults()
            # Their keys are typed as literals in some versions of matplotlib only.
            parameters: Any = matplotlib.rcParams
            parameters.update(_HOUSE)
            yield
    finally:
        gc.unfreeze()


def new_figure(
    height: float,
    rows: int,
    ratios: tuple[float, ...] | None = None,
    *,
    fitted: bool = True,
    apart: float = 0.42,
) -> tuple[Figure, list[Axes]]:
    """Make a figure of stacked panels; to be called in `house_style`."""
    from matplotlib.figure import Figure as NewFigure

    figure = NewFigure(figsize=(WIDTH_INCH, height), layout="constrained" if fitted else None)
    if not fitted:
        figure.subplots_adjust(
            left=LEFT, right=RIGHT, top=1.0 - 0.3 / height, bottom=0.5 / height, hspace=apart
        )
    panels = figure.subplots(rows, 1, squeeze=False, height_ratios=ratios)
    return figure, list(panels[:, 0])


def new_grid(height: float, rows: int, columns: int) -> Figure:
    """Make a figure of panels beside and below each other, with an axis of its own each; in `house_style`."""
    from matplotlib.figure import Figure as NewFigure

    figure = NewFigure(figsize=(WIDTH_INCH, height), layout="constrained")
    figure.subplots(rows, columns)
    return figure


def leave_room_for_labels(panel: Axes, end: float, begin: float = 0.0, share: float = 1.2) -> None:
    """Leave room behind the end of the data, where its lines are labelled and the axis has no ticks."""
    panel.set_xlim(begin, begin + share * (end - begin))
    panel.set_xticks([tick for tick in panel.get_xticks() if begin <= tick <= 1.001 * end])


def ink(colour: str) -> str:
    """Return the darker shade of a colour in which text is readable on white."""
    return _INK[colour]


def signed(value: float, digits: int) -> str:
    text = f"{value:+.{digits}f}"
    return text[1:] if float(text) == 0.0 else text.replace("-", "−")


def label(panel: Axes, x: float, y: float, text: str, colour: str, **options: Any) -> None:
    """Write a label beside what it names, in the colour of that."""
    panel.text(x, y, text, color=ink(colour), **{"fontsize": 9.0, **options})


def label_ends(panel: Axes, x: float, *lines: tuple[str, float, str]) -> None:
    """Label lines at their ends, apart from each other where the ends are close."""
    low, high = panel.get_ylim()
    gap = 0.17 * (high - low)
    ordered = sorted(lines, key=lambda line: line[1])
    # Up from the lowest, then down again where that leads out of the panel.
    places: list[float] = []
    for _, value, _ in ordered:
        places.append(max(value, places[-1] + gap if places else -inf))
    ceiling = high
    for number in reversed(range(len(places))):
        places[number] = min(places[number], ceiling)
        ceiling = places[number] - gap
    # The lines of the grid go on to the right, and would strike the words out.
    ground = {"facecolor": "white", "edgecolor": "none", "pad": 0.8}
    for (text, _, colour), at in zip(ordered, places, strict=True):
        label(panel, x, at, text, colour, va="center", fontsize=8.5, bbox=ground)


def keep_inside(figure: Figure) -> None:
    """Make panels narrower until no text leaves the figure; one with a layout of its own takes care of that itself."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    if figure.get_layout_engine() is not None:
        return
    canvas: Any = FigureCanvasAgg(figure)
    renderer = canvas.get_renderer()
    width = figure.get_figwidth()
    for _ in range(_MOST_ROUNDS):
        ends = [(box.x0 / figure.dpi, box.x1 / figure.dpi) for box in _text_boxes(figure, renderer)]
        before = _ROOM_INCH - min((begin for begin, _ in ends), default=width)
        beyond = max((end for _, end in ends), default=0.0) - (width - _ROOM_INCH)
        if before <= 0.0 and beyond <= 0.0:
            return
        places = figure.subplotpars
        # Words begin inside of the panel, so that its end has to move by more than they are too long.
        right = places.right - 1.4 * max(beyond, 0.0) / width
        figure.subplots_adjust(left=places.left + max(before, 0.0) / width, right=right)


def _text_boxes(figure: Figure, renderer: Any) -> Iterator[Any]:
    """Go through the places of all texts: those of the axes, and those beside lines."""
    for panel in figure.axes:
        for axis in (panel.xaxis, panel.yaxis):
            box = axis.get_tightbbox(renderer)
            if box is not None:
                yield box
        for text in (*panel.texts, panel.title):
            if text.get_text() and text.get_visible():
                yield text.get_window_extent(renderer)


def svg_document(figure: Figure, name: str, *, letters_as_shapes: bool = True) -> str:
    """Write a figure as an SVG file of its own."""
    import matplotlib

    keep_inside(figure)
    stream = StringIO()
    fonttype = "path" if letters_as_shapes else "none"
    with matplotlib.rc_context({"svg.hashsalt": name, "svg.fonttype": fonttype}):
        figure.savefig(
            stream, format="svg", metadata={"Date": None, "Creator": None, "Format": None, "Type": None}
        )
    # Some versions end lines with blanks.
    return "\n".join(line.rstrip() for line in stream.getvalue().splitlines()) + "\n"


def inline_svg(figure: Figure, name: str) -> str:
    """Write a figure as an element for a page that holds several figures."""
    text = svg_document(figure, name, letters_as_shapes=False)
    text = text[text.index("<svg") :]
    text = _NAMED_HERE.sub(lambda match: f'id="{name}-{match[1]}"', text)
    text = _REFERRED_TO.sub(
        lambda match: f'href="#{name}-{match[1]}"' if match[1] else f"url(#{name}-{match[2]})", text
    )
    opening, rest = text.split(">", 1)
    opening = _NAMESPACE.sub("", opening)
    opening = re.sub(r'\s(?:width|height)="[^"]*"', "", opening)
    return f'{opening} aria-hidden="true" focusable="false">{rest}'.strip()


@dataclass(frozen=True)
class PageFigure:
    """A figure with its words."""

    name: str
    """Unique in the page."""
    title: str
    svg: str
    alternative: str
    caption: str
    """What it shows and under which conditions."""


def page_figure(
    name: str, title: str, draw: Callable[[], Figure], alternative: str, caption: str
) -> PageFigure:
    with house_style():
        svg = inline_svg(draw(), name)
    return PageFigure(name, title, svg, alternative, caption)
