"""Splines against SciPy's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline, make_interp_spline

from nospill.core.piecewise import bspline_pieces, design_matrix, interpolating_spline
from tests.waiting import run_python


@settings(deadline=None)
@given(
    st.sampled_from([(degree, count) for degree in (1, 3, 5) for count in (degree + 1, degree + 2, degree + 3, 40)])
    | st.sampled_from([(2, 3), (4, 5)]),
    st.integers(0, 2**31),
    st.floats(-1e3, 1e3),
)
def test_interpolating_splines_equal_scipys(shape, seed, origin):
    degree, count = shape
    random = np.random.default_rng(seed)
    x = origin + np.cumsum(random.uniform(0.5, 1.5, count))
    values = random.normal(size=(count, 2))
    ours, theirs = interpolating_spline(x, values, degree), make_interp_spline(x, values, k=degree)
    places = np.concatenate([x, random.uniform(x[0], x[-1], 50)])
    for order in range(min(degree, 4)):
        expected = theirs(places, order)
        np.testing.assert_allclose(ours(places, order), expected, atol=1e-9 * np.abs(expected).max())


def test_many_samples_at_an_even_rate():
    x = np.arange(5000) / 500.0
    values = np.cumsum(np.random.default_rng(0).normal(size=(5000, 6)), axis=0)
    ours, theirs = interpolating_spline(x, values, 5), make_interp_spline(x, values, k=5)
    places = np.linspace(0.0, x[-1], 7001)
    for order in range(3):
        expected = theirs(places, order)
        np.testing.assert_allclose(ours(places, order), expected, atol=1e-12 * np.abs(expected).max())


@pytest.mark.parametrize("x", [[0.0, 1.0, 1.0, 2.0, 3.0, 4.0, 5.0], [0.0, 2.0, 1.0, 3.0, 4.0, 5.0], [0.0, 1.0]])
def test_places_that_make_no_spline_are_refused(x):
    with pytest.raises(ValueError, match="spline of degree 5"):
        interpolating_spline(np.array(x), np.zeros((len(x), 1)), 5)


@pytest.mark.slow
def test_a_plan_does_without_scipy(tmp_path: Path):
    """Loading it takes a third of a second of every run of the command."""
    code = (
        "import sys; from nospill import load, load_plan, plan\n"
        "found = plan(load('matrix-rigid')); found.save(sys.argv[1])\n"
        "assert load_plan(sys.argv[1]).certificate.ok\n"
        "print([name for name in sys.modules if name.split('.')[0] == 'scipy'])"
    )
    done = run_python("-c", code, str(tmp_path / "out"), check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("degree", [3, 5])
def test_the_matrix_of_all_splines_is_that_of_scipy(degree: int) -> None:
    knots = np.concatenate([np.zeros(degree + 1), [0.2, 0.5, 0.55, 0.9], np.ones(degree + 1)])
    x = np.linspace(0.0, 1.0, 41)
    expected = BSpline.design_matrix(x, knots, degree).toarray()
    np.testing.assert_allclose(design_matrix(x, knots, degree), expected, atol=1e-14)


@settings(deadline=None)
@given(
    st.integers(3, 5), st.lists(st.integers(1, 2), max_size=6), st.integers(1, 8), st.booleans(), st.integers(0, 2**31)
)
def test_pieces_of_b_splines_equal_scipys(degree, inside, outside, clamped, seed):
    """Knots are repeated inside as often as two derivatives allow, and outside [0, 1] beyond the degree."""
    random = np.random.default_rng(seed)
    beside = 0.0 if clamped else random.uniform(0.05, 0.3)
    steps = np.cumsum(random.uniform(0.1, 1.0, len(inside) + 1))
    inner = np.repeat(steps[:-1] / steps[-1], [min(count, degree - 2) for count in inside])
    ends = np.arange(degree + outside + 1)[::-1] // 2 * beside
    knots = np.concatenate([-ends, inner, 1.0 + ends[::-1]])
    points = random.normal(size=(len(knots) - degree - 1, 3))
    pieces, theirs = bspline_pieces(points, degree, knots), BSpline(knots, points, degree)
    places = random.uniform(0.0, 1.0, 50)
    for order in range(degree):
        expected = theirs(places, order)
        np.testing.assert_allclose(pieces(places, order), expected, atol=1e-9 * max(np.abs(expected).max(), 1.0))


@pytest.mark.parametrize("order", range(4))
def test_each_column_at_places_of_its_own(order: int) -> None:
    random = np.random.default_rng(order)
    spline = interpolating_spline(np.linspace(0.0, 1.0, 12), random.normal(size=(12, 3)), 5)
    places = random.uniform(-0.1, 1.1, (50, 3))
    own = np.column_stack([spline(places[:, column], order)[:, column] for column in range(3)])
    assert np.array_equal(spline.by_columns(places, order), own)
