"""The residual after the end: exact supremum against brute force, the smooth bound against the supremum."""

import casadi as ca
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from nospill.laws.slosh.residual import residual_bound

OMEGA = 22.58237

components = st.floats(-1.0, 1.0).map(lambda value: 0.0 if abs(value) < 1e-6 else value)
pairs = st.tuples(components, components)
dampings = st.one_of(st.just(0.0), st.floats(1e-4, 0.02), st.floats(0.02, 0.9))


def residual_supremum(
    displacement: np.ndarray, velocity: np.ndarray, *, frequency: float, damping: np.ndarray | float
) -> np.ndarray:
    """The exact largest |q(t)| for t >= 0 of a free mode, (...) for states (..., k).

    |q|^2 = exp(-2 s t) (a + b cos u + c sin u) with u = 2 omega_d t. Its derivative vanishes where p cos u + r sin u =
    s a, p = c omega_d - s b, r = -(b omega_d + s c); the function decays from one period of u to the next, so that the
    start and these two points of the first period are the only candidates.
    """
    zeta = np.asarray(damping)
    decay, damped = zeta * frequency, frequency * np.sqrt(1 - zeta**2)
    quadrature = (velocity + decay[..., None] * displacement) / damped[..., None]
    first, second = np.sum(displacement**2, axis=-1), np.sum(quadrature**2, axis=-1)
    a, b, c = (first + second) / 2, (first - second) / 2, np.sum(displacement * quadrature, axis=-1)
    p, r = c * damped - decay * b, -(b * damped + decay * c)
    m = np.hypot(p, r)
    # Where m < s a, or m = 0 on an undamped circle, |q| never rises above its start and the candidates do no harm.
    reach = np.clip(np.divide(decay * a, m, out=np.ones_like(a * m), where=m > 0), 0.0, 1.0)
    largest = first
    for sign in (-1.0, 1.0):
        u = np.mod(np.arctan2(r, p) + sign * np.arccos(reach), 2 * np.pi)
        square = np.exp(-decay / damped * u) * (a + b * np.cos(u) + c * np.sin(u))
        largest = np.maximum(largest, square)
    return np.sqrt(largest)


def free_motion(displacement: np.ndarray, velocity: np.ndarray, t: np.ndarray, damping: float) -> np.ndarray:
    """|q(t)| by the matrix exponential, in complex numbers."""
    roots = OMEGA * (-damping + 1j * np.sqrt(1 - damping**2) * np.array((1.0, -1.0)))
    first = (velocity - roots[1] * displacement) / (roots[0] - roots[1])
    q = np.outer(np.exp(roots[0] * t), first) + np.outer(np.exp(roots[1] * t), displacement - first)
    return np.linalg.norm(q.real, axis=1)  # pyright: ignore[reportAttributeAccessIssue]


def brute_force(displacement: np.ndarray, velocity: np.ndarray, damping: float) -> float:
    """Fine grid over one period of |q|^2, then once more around its best point."""
    period = np.pi / (OMEGA * np.sqrt(1 - damping**2))
    t = np.linspace(0.0, 1.01 * period, 4001)
    best = t[np.argmax(free_motion(displacement, velocity, t, damping))]
    t = np.clip(np.linspace(best - t[1], best + t[1], 4001), 0.0, None)
    return float(np.max(free_motion(displacement, velocity, t, damping)))


@given(pairs, pairs, dampings, st.sampled_from([1, 2]))
def test_supremum_against_brute_force(displacement, velocity, damping, coordinates):
    q, qd = np.array(displacement[:coordinates]), OMEGA * np.array(velocity[:coordinates])
    exact = residual_supremum(q, qd, frequency=OMEGA, damping=damping)
    assert exact.shape == ()
    assert float(exact) == pytest.approx(brute_force(q, qd, damping), rel=2e-7, abs=1e-12)


def test_supremum_is_vectorised():
    random = np.random.default_rng(3)
    q, qd = random.normal(size=(5, 4, 2)), OMEGA * random.normal(size=(5, 4, 2))
    damping = random.uniform(0.0, 0.1, 4)
    together = residual_supremum(q, qd, frequency=OMEGA, damping=damping)
    assert together.shape == (5, 4)
    for index in np.ndindex(5, 4):
        alone = residual_supremum(q[index], qd[index], frequency=OMEGA, damping=damping[index[1]])
        assert together[index] == pytest.approx(float(alone), rel=1e-14)


def test_special_states():
    zeta = 0.0067

    def supremum(q, qd, damping=zeta):
        return float(residual_supremum(np.array(q), np.array(qd), frequency=OMEGA, damping=damping))

    assert supremum((0.0, 0.0), (0.0, 0.0)) == 0.0
    assert supremum((0.0,), (0.0,)) == 0.0
    assert supremum((0.002, 0.0), (0.0, 0.0)) == pytest.approx(0.002, rel=1e-12)
    # An undamped circle stays on it; a damped one starts at its largest.
    assert supremum((0.002, 0.0), (0.0, 0.002 * OMEGA), 0.0) == pytest.approx(0.002, rel=1e-12)
    assert supremum((0.002, 0.0), (0.0, 0.002 * OMEGA)) == pytest.approx(0.002, rel=1e-9)
    # From the middle outwards: v/omega exp(-zeta acos(zeta)/sqrt(1 - zeta^2)).
    root = np.sqrt(1 - zeta**2)
    assert supremum((0.0,), (0.05,)) == pytest.approx(0.05 / OMEGA * np.exp(-zeta * np.arccos(zeta) / root), rel=1e-12)


@given(pairs, pairs, dampings, st.floats(0.0, 2 * np.pi), st.floats(0.01, 100.0))
def test_supremum_turns_and_scales_with_the_state(displacement, velocity, damping, angle, factor):
    q, qd = np.array(displacement), OMEGA * np.array(velocity)
    turn = np.array(((np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle))))
    plain = residual_supremum(q, qd, frequency=OMEGA, damping=damping)
    turned = residual_supremum(factor * turn @ q, factor * turn @ qd, frequency=OMEGA, damping=damping)
    assert float(turned) == pytest.approx(factor * float(plain), rel=1e-9, abs=1e-12)


def bound_function(coordinates: int) -> ca.Function:
    q, qd = ca.SX.sym("q", coordinates), ca.SX.sym("qd", coordinates)
    numbers = ca.SX.sym("numbers", 3)
    bound = residual_bound(q, qd, frequency=numbers[0], damping=numbers[1], smoothing=numbers[2])
    return ca.Function("bound", [q, qd, numbers], [bound])


def bounds(q: np.ndarray, qd: np.ndarray, damping: np.ndarray | float, smoothing: float) -> np.ndarray:
    numbers = np.vstack([np.broadcast_to(value, len(q)) for value in (OMEGA, damping, smoothing)])
    return np.asarray(bound_function(q.shape[1]).map(len(q))(q.T, qd.T, numbers)).ravel()


@pytest.mark.parametrize("coordinates", [1, 2])
@pytest.mark.parametrize("smoothing", [1e-9, 0.01])
@pytest.mark.parametrize("largest", [0.0097, 0.99])
def test_bound_is_one_and_nearly_tight(coordinates, smoothing, largest):
    random = np.random.default_rng(coordinates)
    count = 5000
    q = random.normal(size=(count, coordinates)) * random.uniform(0, 1, (count, 1))
    qd = OMEGA * random.normal(size=(count, coordinates)) * random.uniform(0, 1, (count, 1))
    damping = random.uniform(0.0, largest, count)
    exact = residual_supremum(q, qd, frequency=OMEGA, damping=damping)
    bound = bounds(q, qd, damping, smoothing)
    looseness = np.minimum(np.exp(np.pi * damping / np.sqrt(1 - damping**2)), 2.1)
    assert np.all(bound >= exact * (1 - 1e-12))
    swirl = 2 ** (1 / 8) if coordinates == 2 else 1.0  # of the eighth-power mean on a circle
    assert np.all(bound <= np.hypot(exact * looseness * swirl, np.sqrt(2) * smoothing) * (1 + 1e-9))


@given(pairs, pairs, st.floats(0.0, 0.5), st.sampled_from([1, 2]))
def test_bound_is_the_eighth_power_mean_of_the_singular_values(displacement, velocity, damping, coordinates):
    q, qd = np.array(displacement)[:coordinates], OMEGA * np.array(velocity)[:coordinates]
    axes = np.linalg.svd(np.column_stack((q, (qd / OMEGA + damping * q) / (1 + damping))), compute_uv=False)
    mean = np.linalg.norm(axes, 8)
    assert bounds(q[None], qd[None], damping, 1e-9)[0] == pytest.approx(mean, rel=1e-9, abs=1e-8)
    assert mean <= 2 ** (1 / 8) * axes[0] * (1 + 1e-12)


@pytest.mark.parametrize("coordinates", [1, 2])
def test_bound_is_smooth_at_rest_and_on_a_circle(coordinates):
    """Finite first and second derivatives, of the size the smoothing sets, where the plain half axis has corners."""
    q, qd = ca.SX.sym("q", coordinates), ca.SX.sym("qd", coordinates)
    bound = residual_bound(q, qd, frequency=OMEGA, damping=0.0067, smoothing=0.01)
    slope = ca.Function("slope", [q, qd], [bound, ca.gradient(bound, q), ca.hessian(bound, ca.vertcat(q, qd))[0]])
    value, gradient, bend = slope(np.zeros(coordinates), np.zeros(coordinates))
    assert float(value) == pytest.approx(0.01)
    np.testing.assert_array_equal(np.asarray(gradient), 0.0)
    assert np.all(np.isfinite(bend.full())) and np.max(np.abs(bend.full())) < 101.0
    if coordinates == 2:
        _, gradient, bend = slope(np.array((0.5, 0.0)), np.array((0.0, 0.5 * OMEGA)))
        assert np.all(np.isfinite(gradient.full())) and np.all(np.isfinite(bend.full()))


@pytest.mark.parametrize("damping", [0.0, 0.00673])
def test_the_paraboloid_changes_the_residual_of_a_few_millimetres_by_less_than_one_percent(damping):
    """The modal mass on its paraboloid, the cup at rest, at a wall height of 3 mm (C_1 = 1.5231); twelve at once."""
    stiff, reach = (OMEGA**2 / 9.80665) ** 2, 0.003 / 1.5231

    def slope(_t: float, states: np.ndarray) -> np.ndarray:
        q, qd = states.reshape(2, 2, -1)
        bias = stiff * np.sum(qd * qd, axis=0) * q + OMEGA**2 * q
        bias += 2 * damping * OMEGA * (qd + stiff * np.sum(q * qd, axis=0) * q)
        # (1 + stiff q q^T)^-1 by Sherman and Morrison
        bias -= stiff * np.sum(q * bias, axis=0) / (1 + stiff * np.sum(q * q, axis=0)) * q
        return np.concatenate((qd, -bias)).ravel()

    random, begun = np.random.default_rng(7), []
    for _ in range(12):
        state = random.normal(size=4) * (1, 1, OMEGA, OMEGA)
        state *= reach / float(residual_supremum(state[:2], state[2:], frequency=OMEGA, damping=damping))
        begun.append(state)
    run = solve_ivp(slope, (0, 2.0), np.array(begun).T.ravel(), rtol=1e-8, atol=1e-12, t_eval=np.linspace(0, 2.0, 4000))
    farthest = np.max(np.linalg.norm(run.y.reshape(4, 12, -1)[:2], axis=0), axis=1)
    assert np.max(np.abs(farthest / reach - 1)) < 0.01
