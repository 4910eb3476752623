"""Quantiles against values known from elsewhere."""

import math

import numpy as np

from drivegate.studies.campaign.statistics import CURVE_POINTS, curve_of, quantiles_of


def test_quantiles_are_margins_that_were_found_also_beside_infinite_ones():
    margins = np.array([-math.inf, -math.inf, *np.arange(98.0)])
    assert quantiles_of(margins) == (-math.inf, -math.inf, 2.0, 22.0, 47.0, 72.0, 92.0, 97.0)
    assert quantiles_of(np.empty(0)) == ()


def test_the_distribution_keeps_the_least_and_the_greatest_of_many_margins():
    margins = np.linspace(-1.0, 2.0, 12345)[::-1]
    curve = curve_of(margins)
    assert len(curve) == CURVE_POINTS
    assert (curve[0], curve[-1]) == (-1.0, 2.0)
    assert list(curve) == sorted(curve)
    assert curve_of(margins[:3]) == tuple(sorted(margins[:3])), "few are all kept"
