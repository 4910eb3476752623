"""The torque within control periods over one electrical period, and its spectrum."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from drivegate.results.sections import TorqueSection
from drivegate_cases.documents.wording import figure
from drivegate_reports.page.style import BLUE, DASHED, GREEN, GREY, SKY, label, label_ends, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TITLE: Final = "Torque ripple and its spectrum"
_TURN_DEG: Final = 360.0
_LEAST_PERCENT: Final = 1e-3
_HZ_PER_KHZ: Final = 1e3


def alternative(torque: TorqueSection) -> str:
    strongest = int(np.argmax(torque.amplitude_percent))
    return (
        f"Two panels. The torque stays between {min(torque.least_nm):.4g} and {max(torque.greatest_nm):.4g} N·m around "
        f"{torque.mean_nm:.4g} N·m, a ripple of {figure(torque.peak_to_peak_percent)} % of rated torque. The strongest "
        f"line of its spectrum is {figure(torque.amplitude_percent[strongest])} %, at "
        f"{torque.frequency_hz[strongest]:.5g} Hz."
    )


def caption(torque: TorqueSection) -> str:
    turns = "1 electrical period" if torque.turns == 1 else f"{torque.turns} electrical periods"
    return (
        f"Rated torque at {torque.speed_rpm:g} rpm: the recorded commands, given to the exact plant once more. Above, "
        f"least and greatest torque within control periods. Below, Fourier integrals over {turns} under a Hann window, "
        f"in per cent of rated torque; dashed: the carrier's {torque.carrier_frequency_hz:g} Hz and twice that."
    )


def draw(torque: TorqueSection) -> Figure:
    drawn, (band, lines) = new_figure(4.0, 2, fitted=False, apart=0.5)
    band.fill_between(
        torque.angle_deg, torque.least_nm, torque.greatest_nm, color=SKY, alpha=0.5, linewidth=0
    )
    band.plot(torque.angle_deg, torque.greatest_nm, color=BLUE, linewidth=0.9)
    band.plot(torque.angle_deg, torque.least_nm, color=BLUE, linewidth=0.9)
    band.plot([0.0, _TURN_DEG], [torque.mean_nm] * 2, color=GREEN, linewidth=1.2, linestyle=DASHED)
    band.set_xlim(0.0, 1.2 * _TURN_DEG)
    band.set_xticks(np.arange(0.0, _TURN_DEG + 1.0, 60.0))
    band.ticklabel_format(axis="y", useOffset=False)
    band.margins(y=0.1)
    band.set_xlabel("angle turned (el. deg)")
    band.set_ylabel("torque (N·m)")
    label_ends(
        band,
        1.012 * _TURN_DEG,
        ("greatest", torque.greatest_nm[-1], BLUE),
        ("mean", torque.mean_nm, GREEN),
        ("least", torque.least_nm[-1], BLUE),
    )
    frequency = np.array(torque.frequency_hz) / _HZ_PER_KHZ
    amplitude = np.maximum(torque.amplitude_percent, _LEAST_PERCENT)
    lines.vlines(frequency, _LEAST_PERCENT, amplitude, color=BLUE, linewidth=1.0)
    lines.set_yscale("log")
    lines.yaxis.set_major_formatter("{x:g}")
    lines.set_ylim(_LEAST_PERCENT, 4.0 * max(float(amplitude.max()), 0.1))
    lines.set_xlim(0.0, float(frequency[-1]))
    carrier = torque.carrier_frequency_hz / _HZ_PER_KHZ
    for multiple in (1.0, 2.0):
        lines.axvline(multiple * carrier, color=GREY, linewidth=0.8, linestyle=DASHED)
    strongest = int(np.argmax(torque.amplitude_percent))
    at, height = float(frequency[strongest]), 1.15 * float(amplitude[strongest])
    side = "left" if at < 0.1 * float(frequency[-1]) else "center"
    label(lines, at, height, f"{figure(torque.amplitude_percent[strongest])} %", BLUE, ha=side)
    lines.set_xlabel("frequency (kHz)")
    lines.set_ylabel("amplitude (%)")
    return drawn
