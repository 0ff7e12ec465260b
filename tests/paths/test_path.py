import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BSpline

from nospill.errors import ScenarioError
from nospill.paths.path import (
    ARC_TOLERANCE,
    MAX_INTERPOLATED,
    PRESETS,
    Path,
    circular_arc,
    path_from_bspline,
    preset_path,
    straight_line,
)
from nospill.paths.waypoint_paths import path_through_waypoints

GRID = np.linspace(0.0, 1.0, 1001)


def largest_jump(path: Path, order: int) -> float:
    """Jump of a derivative at the inner breaks, relative to its size."""
    if path.breaks.size == 2:
        return 0.0
    left = Path(path.breaks[:-1], path.coefficients[:, :-1])
    inner = path.breaks[1:-1]
    before = np.array(
        [Path(left.breaks[: i + 2], left.coefficients[:, : i + 1]).derivative(s, order)[0] for i, s in enumerate(inner)]
    )
    return float(np.max(np.abs(before - path.derivative(inner, order)))) / (
        1.0 + np.max(np.abs(path.derivative(GRID, order)))
    )


def test_arc_has_the_published_ends_length_and_speed():
    path = preset_path("arc", yaw=(0.0, np.pi))
    np.testing.assert_allclose(path.at(0.0)[0], (0.15411, -0.59940, 1.21951, 0.0), atol=5e-6)
    np.testing.assert_allclose(path.at(1.0)[0], (0.15414, 0.59938, 1.21953, np.pi), atol=5e-6)
    assert path.length == pytest.approx(1.8379, abs=5e-5)
    speed = np.linalg.norm(path.derivative([0.0, 0.5])[:, :3], axis=1)  # pyright: ignore[reportArgumentType]
    np.testing.assert_allclose(speed, (5.14, 1.29), atol=5e-3)
    assert path.breaks.size == 8 and path.coefficients.shape == (5, 7, 4)


def test_arc_equals_the_b_spline_of_its_published_knots():
    knots = np.concatenate((np.full(4, -0.001), np.linspace(0.0, 1.0, 8), np.full(4, 1.001)))
    reference = BSpline(knots, PRESETS["arc"](), 4)
    path = preset_path("arc")
    for order, tolerance in ((0, 1e-14), (1, 1e-12), (2, 1e-11), (3, 1e-9)):
        np.testing.assert_allclose(
            path.derivative(GRID[:-1], order)[:, :3], reference(GRID[:-1], order), atol=tolerance
        )


@pytest.mark.parametrize("name", PRESETS)
@pytest.mark.parametrize("yaw", [(0.0, np.pi), (0.0, 0.3, -0.2, 0.5, 0.1, 0.0, 1.0, 2.0)])
def test_presets_are_c3_read_only_and_start_at_their_first_control_point(name, yaw):
    path = preset_path(name, yaw=yaw, offset=(0.1, -0.2, 0.3))
    assert path.breaks[0] == 0.0 and path.breaks[-1] == 1.0 and np.all(np.diff(path.breaks) > 0)
    for order in range(4):
        assert largest_jump(path, order) < 1e-9
    np.testing.assert_allclose(path.at(np.linspace(0, 1, len(yaw)))[:, 3], yaw, atol=1e-12)
    if name != "arc":  # its knots lie outside, so it starts just inside its polygon
        np.testing.assert_allclose(path.at([0.0, 1.0])[:, :3], PRESETS[name]()[[0, -1]] + (0.1, -0.2, 0.3), atol=1e-12)  # pyright: ignore[reportArgumentType]
    for array in (path.breaks, path.coefficients):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_derivatives_agree_with_finite_differences():
    path = preset_path("pp", yaw=(0.0, 1.0, 0.5))
    s, step = np.linspace(0.053, 0.947, 37), 1e-5
    for order in (1, 2, 3):
        difference = (path.derivative(s + step, order - 1) - path.derivative(s - step, order - 1)) / (2 * step)
        np.testing.assert_allclose(path.derivative(s, order), difference, rtol=1e-6, atol=1e-5)
    assert np.all(path.derivative(s, 9) == 0.0)


@settings(max_examples=60, deadline=None)
@given(st.integers(3, 7), st.integers(0, 8), st.booleans(), st.integers(0, 10_000))
def test_any_b_spline_equals_scipy(degree, extra, wide, seed):
    random = np.random.default_rng(seed)
    count = degree + 1 + extra
    knots = np.sort(random.uniform(-2.0, 3.0, count + degree + 1))
    if wide:
        low, inner, high = (random.uniform(0, 1, size) for size in (degree + 1, extra, degree + 1))
        knots = np.sort(np.concatenate((-low, inner, 1 + high)))
    control = random.normal(size=(count, 3))
    path = path_from_bspline(control, degree, knots=knots, yaw=(0.2, 0.2))
    begin, end = knots[degree], knots[-degree - 1]
    own = GRID if begin <= 0 and end >= 1 else begin + GRID * (end - begin)
    np.testing.assert_allclose(path.at(GRID)[:, :3], BSpline(knots, control, degree)(own), atol=1e-9)


def test_default_knots_are_clamped_and_uniform():
    control = np.random.default_rng(1).normal(size=(7, 3))
    path = path_from_bspline(control, 3, yaw=(0, 0))
    np.testing.assert_allclose(path.breaks, np.linspace(0, 1, 5), atol=1e-15)
    np.testing.assert_allclose(path.at([0.0, 1.0])[:, :3], control[[0, -1]], atol=1e-14)  # pyright: ignore[reportArgumentType]
    assert largest_jump(path, 2) < 1e-12


@settings(max_examples=40, deadline=None)
@given(st.integers(2, 40), st.integers(0, 10_000))
def test_waypoints_are_met_at_their_chord_length(count, seed):
    points = np.cumsum(np.random.default_rng(seed).uniform(0.05, 0.2, (count, 3)), axis=0)
    path = path_through_waypoints(points, yaw=(0.0, 1.0), smoothing=0.0)
    chords = np.linalg.norm(np.diff(points, axis=0), axis=1)
    s = np.concatenate(([0.0], np.cumsum(chords))) / chords.sum()
    np.testing.assert_allclose(path.at(s)[:, :3], points, atol=1e-9)
    for order in range(4):
        assert largest_jump(path, order) < 1e-6
    assert path.length >= chords.sum() * (1 - 1e-9)


def test_waypoints_on_a_line_give_the_line():
    points = np.linspace((0.0, 0.0, 1.0), (1.0, 2.0, 1.0), 9)
    np.testing.assert_allclose(
        path_through_waypoints(points).at(GRID), straight_line(points[0], points[-1]).at(GRID), atol=1e-12
    )


@settings(max_examples=40, deadline=None)
@given(st.floats(0.02, 6.2), st.floats(0.05, 3.0), st.integers(0, 10_000))
def test_arc_stays_on_its_circle_at_constant_speed(angle, radius, seed):
    frame = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    phases = np.array((0.0, 0.4, 1.0)) * angle
    points = 0.3 + radius * (np.cos(phases)[:, None] * frame[0] + np.sin(phases)[:, None] * frame[1])
    path = circular_arc(*points, yaw=(0.0, 1.0))
    exact = 0.3 + radius * (np.cos(angle * GRID)[:, None] * frame[0] + np.sin(angle * GRID)[:, None] * frame[1])
    # Three nearby points fix their circle only as well as rounding allows.
    np.testing.assert_allclose(path.at(GRID)[:, :3], exact, atol=ARC_TOLERANCE + 1e-12 / angle**2)
    assert path.length == pytest.approx(radius * angle, rel=1e-5)
    assert largest_jump(path, 4) < 1e-6
    second = np.linalg.norm(path.derivative(GRID, 2)[:, :3], axis=1)
    np.testing.assert_allclose(second, radius * angle**2, rtol=0.02)


def test_line_and_a_turn_on_the_spot():
    line = straight_line((0, 0, 0), (3, 0, 4), yaw=(0, 1))
    assert line.length == pytest.approx(5.0, abs=1e-14)
    np.testing.assert_allclose(line.at(0.25)[0], (0.75, 0, 1, 0.25))
    turn = straight_line((1, 1, 1), (1, 1, 1), yaw=(0, 1))
    assert turn.length == 0.0


POINTS = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [2, 1, 0], [2, 2, 1]]
SIX = [*POINTS, [3, 2, 1]]


def test_a_double_knot_is_allowed_where_the_curve_stays_c2():
    path = path_from_bspline([*SIX, [4, 2, 1]], 4, knots=[0] * 5 + [0.4] * 2 + [1] * 5)
    assert path.breaks.size == 3 and largest_jump(path, 2) < 1e-12 < largest_jump(path, 3)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: path_from_bspline(POINTS, 2), "second derivative jumps .* raise the degree or remove"),
        (lambda: path_from_bspline(SIX, 3, knots=[0] * 4 + [0.5] * 2 + [1] * 4), "0.5: its second derivative jumps"),
        (
            lambda: path_from_bspline([*SIX, [6, 3, 1], [7, 3, 1]], 4, knots=[0] * 5 + [0.4] * 3 + [1] * 5),
            "knot 0.4: its",
        ),
        (lambda: path_from_bspline(POINTS, 5), "degree = 5: 5 control points allow an integer from 1 to 4"),
        (lambda: path_from_bspline(POINTS, 0), "degree = 0"),
        (lambda: path_from_bspline(POINTS, 3.5), "degree = 3.5"),  # type: ignore[arg-type]
        (lambda: path_from_bspline(POINTS, 4, knots=[0, 1]), "2 given; 5 control points of degree 4 need 10 knots"),
        (lambda: path_from_bspline(POINTS, 4, knots=[0] * 4 + [1, 0.5] + [1] * 4), "knot 6 = 0.5 is below"),
        (lambda: path_from_bspline(POINTS, 4, knots=[0.5] * 10), "is empty"),
        (lambda: path_from_bspline([[0, 0], [1, 1]], 1), "control_points: shape"),
        (lambda: path_from_bspline([[0, 0, 0], [1, 1]], 1), "control_points: not an array of numbers"),
        (lambda: path_from_bspline([[0, 0, 10**400], [1, 1, 1]], 1), "control_points: .* too large"),
        (lambda: path_from_bspline([[0, 0, float("nan")], [1, 1, 1]], 1), "not a finite number"),
        (lambda: path_from_bspline([[0, 0, 1e9], [1, 1, 1]], 1), "contains 1e\\+09; at most 1e6"),
        (lambda: path_from_bspline([], 3), "control_points: shape"),
        (lambda: path_from_bspline([[1, 1, 1]] * 5, 4), "neither moves nor turns"),
        (lambda: straight_line((0, 0, 0), (0, 0, 0)), "neither moves nor turns"),
        (lambda: straight_line((0, 0), (0, 0, 1)), "start: shape"),
        (lambda: straight_line((0, 0, 0), (0, 0, 1), yaw=(1.0,)), "yaw: shape"),
        (lambda: straight_line((0, 0, 0), (0, 0, 1), yaw=(1.0, float("inf"))), "yaw: .* not a finite"),
        (lambda: straight_line((0, 0, 0), (0, 0, 1), yaw=np.zeros(MAX_INTERPOLATED + 1)), "yaw: 501 values"),
        (lambda: circular_arc((0, 0, 0), (1, 1, 1), (2, 2, 2)), "on one line"),
        (lambda: circular_arc((0, 0, 0), (1, 1, 1), (0, 0, 0)), "coincide"),
        (lambda: circular_arc((0, 0, 0), (0, 0, 0), (1, 0, 0)), "coincide"),
        (lambda: circular_arc((0, 0, 0), (1, 0, 0), (1, 0, 0)), "coincide"),
        (lambda: circular_arc((0, 0, 0), (1, 0, 0), "abc"), "end: not an array"),  # pyright: ignore[reportArgumentType]
        (lambda: path_through_waypoints([[0, 0, 0]]), "waypoints: shape"),
        (lambda: path_through_waypoints(np.arange(60003.0).reshape(-1, 3)), "20001 points, at most 20000"),
        (lambda: preset_path("loop"), "preset 'loop' is unknown; choose one of arc, ark, pp, sl, sl3d"),
        (lambda: preset_path("arc", offset=(1, 2)), "offset: shape"),
    ],
)
def test_paths_that_are_refused(make, message):
    with pytest.raises(ScenarioError, match=message) as caught:
        make()
    assert "\n" not in str(caught.value)
