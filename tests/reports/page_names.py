"""Names of the pages that are written, the laboratory's among them where it is installed."""

from importlib.util import find_spec

PAGE_NAMES = (
    *("conformance", "duty", "comparison", "ratios", "drives", "campaign"),
    *(("reproduction",) if find_spec("drivegate_lab") else ()),
)
