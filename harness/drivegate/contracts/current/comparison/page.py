"""The page of a comparison of controllers with an advance angle: its sections and what it says of the method."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from drivegate.contracts.comparison import CHECKS, POINTS, RANKING, TIMING, Document, Section
from drivegate.contracts.current.numbers import FEASIBLE
from drivegate.contracts.drawings import CycleCurves, DifferenceBars, RunCurves, SpeedCurves, SpeedLoadMap

MAPS: Final = (
    SpeedLoadMap(
        key="gap_current_percent",
        title="Optimality gap: Σ|i| above the least possible",
        caption=f"How far each candidate stays from the feasible angle of least Σ|i| for the same torque. {FEASIBLE}",
        scale="Σ|i| above least (%)",
    ),
    SpeedLoadMap(
        key="gap_power_w",
        title="Input power above the least possible",
        caption="What each candidate wastes compared with the angle of least input power for the same torque.",
        scale="input power above least (W)",
    ),
    SpeedLoadMap(
        key="ripple_percent",
        title="Torque ripple",
        caption="Peak to peak over mean, of the worst electrical period of the last second.",
        scale="torque ripple (%)",
    ),
    SpeedLoadMap(
        key="above_edge_deg",
        title="Angle above the feasible edge",
        caption=(
            "How far each candidate stays from the smallest angle that produces the torque: little is efficient, and "
            "less is lost."
        ),
        scale="angle above edge (el. deg)",
    ),
)
"""The maps over speed and torque."""
DIFFERENCES: Final = DifferenceBars(
    panels=(
        ("drawn", "input_power_w", "input power, drawn plants", "W"),
        ("drawn", "current_sum_a", "Σ|i|, drawn plants", "A"),
        ("drive cycle", "energy_wh_per_km", "energy, drive cycle", "Wh/km"),
    ),
    caption=(
        "Mean paired difference from {first} and its interval; to the right of zero is more. Open markers: no real "
        "difference. Only runs that both hold are paired."
    ),
)
"""Differences from the first candidate."""
OVER_SPEED: Final = SpeedCurves(
    title="Σ|i| and input power over speed",
    panels=(
        ("current_sum_a", "Σ|i| (A)", "least_current_sum_a"),
        ("gap_power_w", "power above least (W)", ""),
    ),
    caption=(
        "Left at {light} %, right at {heavy} % of rated power. The grey line is the least Σ|i| of any angle; input "
        "power is shown above the least of any angle. A point that is not held is left out."
    ),
)
"""Operating points over speed."""
AFTER_CHANGE: Final = RunCurves(
    most=2,
    panels=(
        ("speed_error_rpm", "speed error (rpm)"),
        ("advance_deg", "advance angle (el. deg)"),
        ("current_sum_a", "Σ|i| (A)"),
    ),
    caption=(
        "Largest speed error of each 50 ms, advance angle, and mean Σ|i| of each 50 ms, all candidates overlaid. The "
        "disturbance is at {change_s} s. The dotted lines are the {held_rpm} rpm within which a speed counts as held."
    ),
)
"""What follows a disturbance."""
_CYCLE: Final = CycleCurves(
    title="The drive cycle, with ideal sensors",
    caption=(
        "Top: the cycle in grey and every candidate's speed. Bottom: energy taken so far, less that of {first}. Who "
        "leaves the cycle saves energy that way; the table shows who follows."
    ),
)


def _method_of_differences(document: Document) -> Sequence[str]:
    return (str(document["method"]),)


def _words_of_cycle(document: Document) -> Sequence[str]:
    cycle, vehicle = document["cycle"], document["cycle"]["vehicle"]
    words = (
        f"{cycle['name']}: {cycle['description']} {cycle['duration_s']:g} s and {cycle['distance_km']:.3f} km. "
        f"Source: {cycle['source']}."
    ).replace("..", ".")
    return (
        words,
        "Driven by a vehicle of the drive's size, at 1.5 kW a light electric scooter with its rider: "
        f"{vehicle['mass_kg']:g} kg, wheels of {vehicle['wheel_radius_m']:g} m radius with a gear of "
        f"{vehicle['gear_ratio']:g}, rolling resistance {vehicle['rolling_resistance']:g}, drag area "
        f"{vehicle['drag_area_m2']:g} m². The speed reference is the cycle's speed through wheel and gear.",
        "Not modelled: the drive cannot brake, so nothing is regained; the driver's mechanical brake does what "
        "coasting does not, exactly as the cycle demands, and holds the vehicle at stops. Gear, tyre slip, wind, "
        "hills, battery losses and auxiliary loads are left out. Energy is the supply's, all losses of motor and "
        "bridge included.",
    )


SECTIONS: Final = (
    Section(name="where", title="Who wins where", table="regions"),
    RANKING,
    Section(
        name="differences",
        title="How sure the differences are",
        link="How sure",
        table="differences",
        drawings=(DIFFERENCES,),
        folded="All pairs, places and quantities",
        words=_method_of_differences,
    ),
    Section(
        name="points",
        title="By speed and load",
        link="Speed and load",
        table=POINTS,
        drawings=(OVER_SPEED, *MAPS),
        folded="Every operating point",
    ),
    Section(
        name="disturbances",
        title="Disturbances",
        table="disturbances",
        drawings=(AFTER_CHANGE,),
    ),
    CHECKS,
    Section(
        name="cycle",
        title="Energy over a drive cycle",
        link="Drive cycle",
        table="drive_cycle",
        drawings=(_CYCLE,),
        words=_words_of_cycle,
    ),
    TIMING,
)
"""The sections of the page."""


def method(document: Document) -> Sequence[str]:
    """Return how the comparison was made; documents of earlier versions do not state the sensors."""
    drive = document["drive"]
    return (
        "Every candidate runs the same plan with the same noise: operating points with ideal sensors, disturbances, "
        f"fixed points through {drive.get('sensors', 'the sensors of the drive')} with several seeds, plants drawn "
        "within ±20 % of inductance, half to twice the resistance, ±5 % of EMF and up to about 2 % of rated torque in "
        "friction, and the drive cycle.",
        "Input power is the net power from the supply, core and switching losses included. Σ|i| is the mean of the sum "
        "of the phase currents' magnitudes, which the paper's search lowers; the two are not the same.",
        "The best possible is an exhaustive search of exact steady states for the same mean torque, at angles that "
        "reach it at the current limit. A candidate may be a little below it: a smaller angle can still produce the "
        "torque at a smaller current, and a regulator that dithers averages two states.",
        f"A point is held where the speed stays within {drive.get('speed_tolerance_rpm', 5.0):g} rpm from the time to "
        "converge to its end. It has converged from when the speed is held and the angle near its last mean.",
    )


def shown_facts(document: Document) -> Sequence[tuple[str, str]]:
    """Return names and values about the comparison."""
    size = document["size"]
    return (
        ("operating points", str(len(size["speeds_rpm"]) * len(size["shares"]))),
        ("disturbances", str(size["disturbances"])),
        ("drawn plants", str(size["drawn"])),
    )
