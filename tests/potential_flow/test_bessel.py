"""Bessel functions without scipy, against scipy's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import jnp_zeros, jv, jvp

from nospill.potential_flow.bessel import bessel, bessel_slope, slope_root, slope_roots


@pytest.mark.parametrize("order", [0, 1, 2, 7, 15])
def test_functions_and_roots_are_scipys(order: int) -> None:
    x = np.linspace(0.0, 40.0, 201)
    np.testing.assert_allclose(bessel(order, x), jv(order, x), atol=1e-14)
    np.testing.assert_allclose(bessel_slope(order, x), jvp(order, x), atol=1e-14)
    roots = jnp_zeros(order, 24)
    np.testing.assert_allclose([slope_root(order, number) for number in range(1, 13)], roots[:12], rtol=1e-13)
    np.testing.assert_allclose(slope_roots(order, 25.0), roots[roots <= 25.0], rtol=1e-13)
