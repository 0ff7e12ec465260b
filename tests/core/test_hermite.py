"""Cubic Hermite interpolation: exact of cubics, values and slopes."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from nospill.core.hermite import cubic_hermite, cubic_hermite_slope


@given(arrays(float, (2, 4), elements=st.floats(-10, 10)), st.floats(0.01, 10), st.floats(0, 1))
def test_cubics_are_themselves(coefficients, width, u):
    """Two columns at once: value and slope of a cubic between its ends are its own."""
    cubics = [np.polynomial.Polynomial(own) for own in coefficients]
    values, slopes = (
        np.array([[one(x) for one in of] for x in (0.0, width)]) for of in (cubics, [one.deriv() for one in cubics])
    )
    size = 1.0 + np.max(np.abs(values)) + np.max(np.abs(slopes)) * max(width, 1.0)
    for found, wanted in (
        (cubic_hermite(u, width, values, slopes), [one(u * width) for one in cubics]),
        (cubic_hermite_slope(u, width, values, slopes), [one.deriv()(u * width) for one in cubics]),
    ):
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-9 * size / min(width, 1.0))
