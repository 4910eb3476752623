"""The legend of a panel stands beside it."""

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from drivegate.output.figures import side_legend


def test_the_legend_hides_no_trace():
    figure = Figure(layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.subplots()
    axes.plot([0.0, 1.0], [0.0, 1.0], label="a trace")
    side_legend(axes)
    figure.draw_without_rendering()
    panel, legend = axes.get_window_extent(), axes.get_legend().get_window_extent()
    assert legend.x0 >= panel.x1, "the legend lies on the panel"
    assert legend.x1 <= figure.bbox.x1, "the legend leaves the figure"
