"""Twenty modes of every liquid, written out a second time and integrated by another method, against the judge.

The formulas are those of linear potential flow (docs/slosh-model.md); the first mode slides on its paraboloid.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline
from scipy.special import jnp_zeros

from nospill.judge.after_end import free_heights, residual_height
from nospill.judge.certificate import Judgement, judge_motion
from nospill.judge.full_model import full_scene, with_full_model
from nospill.judge.verdict import Row
from nospill.judge.wording import full_model_note
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.slosh.residual import free_states
from nospill.planning.candidate import exported
from nospill.planning.planner import plan
from nospill.planning.search import found_motion
from nospill.plans.log import Log
from nospill.robots.joint_paths.search import joint_paths, preferred_path
from nospill.scenario import read_scenario
from nospill.scene.cargo import Cargo
from nospill.scene.scene import FULL_MODES
from nospill.transcription.task import Task

GRAVITY = 9.80665
HEIGHT, RESIDUAL = "slosh height", "residual height"


@dataclass(frozen=True)
class Side:
    """Modes along one direction, arrays (n,); the last number is the height per lean that they leave out, m."""

    frequency: np.ndarray
    stiffness: np.ndarray
    curvature: np.ndarray
    height: np.ndarray
    damping: np.ndarray
    gain: np.ndarray
    missing: float


def side(wave: np.ndarray, gain: np.ndarray, layers: np.ndarray, *, reach: float, cargo: Cargo, slowest=None) -> Side:
    """Of wave numbers, gains and ratios of wetted layers; `slowest` is the laminar damping of the stated ratio."""
    assert cargo.filling is not None
    depth, viscosity = cargo.filling.liquid_height, cargo.filling.liquid.kinematic_viscosity
    stiffness = wave * np.tanh(wave * depth)
    frequency = np.sqrt(GRAVITY * stiffness)
    laminar = np.sqrt(viscosity / (2 * frequency)) * layers / 2 + 2 * viscosity * wave**2 / frequency
    stated = min(cargo.oscillators, key=lambda mode: mode.frequency).damping
    damping = np.minimum(stated * laminar / (laminar[0] if slowest is None else slowest), 0.99)
    first = np.arange(len(wave)) == 0
    return Side(
        frequency,
        stiffness,
        np.where(first, stiffness, 0.0),
        depth - 2 / wave * np.tanh(wave * depth / 2),
        damping,
        gain,
        reach - float(np.sum(gain / stiffness)),
    )


def sides_of(cargo: Cargo, count: int) -> tuple[Side, Side]:
    """Along x and along y."""
    assert cargo.filling is not None
    depth, container = cargo.filling.liquid_height, cargo.container
    if cargo.shape == "cylinder":
        radius = container.radius  # pyright: ignore[reportAttributeAccessIssue]
        root = jnp_zeros(1, count)
        wave = root / radius
        gain = 2 * root * np.tanh(wave * depth) / (root**2 - 1)
        bottom = 2 * root * (1 - depth / radius) / np.sinh(2 * wave * depth)
        one = side(wave, gain, ((root**2 + 1) / (root**2 - 1) + bottom) / radius, reach=radius, cargo=cargo)
        return one, one
    lengths = (container.length, container.width)  # pyright: ignore[reportAttributeAccessIssue]
    found = []
    for along, across in (lengths, lengths[::-1]):
        half_waves = (2 * np.arange(1, count + 1) - 1) * np.pi
        wave = half_waves / along
        layers = 2 / across + 2 / along + 2 * wave * (1 - 2 * depth / along) / np.sinh(2 * wave * depth)
        found.append((wave, 4 * np.tanh(wave * depth) / half_waves, layers, along / 2))
    longer = int(np.argmax(lengths))
    wave, _, layers, _ = found[longer]
    frequency = np.sqrt(GRAVITY * wave[0] * np.tanh(wave[0] * depth))
    viscosity = cargo.filling.liquid.kinematic_viscosity
    slowest = np.sqrt(viscosity / (2 * frequency)) * layers[0] / 2 + 2 * viscosity * wave[0] ** 2 / frequency
    x, y = (side(*parts[:3], reach=parts[3], cargo=cargo, slowest=slowest) for parts in found)
    return x, y


def accelerations(sides: tuple[Side, Side], coupled: bool, body: np.ndarray, state: np.ndarray) -> np.ndarray:
    """(4 n,) rates of x, y and their rates; coupled: a mode moves in both directions at once, as in a round cup."""
    omega, alpha, force = body[:3], body[3:6], body[6:]
    x, y, xd, yd = state.reshape(4, -1)
    none = np.zeros_like(x)
    moves = [(x, y, xd, yd)] * 2 if coupled else [(x, none, xd, none), (none, y, none, yd)]
    found = []
    for modes, (u, v, ud, vd) in zip(sides, moves, strict=True):
        curvature = modes.curvature
        place = np.stack([u, v, modes.height + curvature * (u * u + v * v) / 2])
        speed = np.stack([ud, vd, curvature * (u * ud + v * vd)])
        felt = force[:, None] + np.cross(alpha, place, axis=0) + 2 * np.cross(omega, speed, axis=0)
        felt = felt + np.cross(omega, np.cross(omega, place, axis=0), axis=0)
        axial = force[2] - (omega[0] ** 2 + omega[1] ** 2) * modes.height
        down = curvature * (felt[2] + curvature * (ud * ud + vd * vd)) + (modes.stiffness - curvature) * axial
        slip = curvature**2 * (u * ud + v * vd)
        friction = 2 * modes.damping * modes.frequency
        pull = [felt[0] + down * u + friction * (ud + slip * u), felt[1] + down * v + friction * (vd + slip * v)]
        if not coupled:
            pull = [pull[axis] * (modes is sides[axis]) for axis in range(2)] if sides[0] is not sides[1] else pull
        along = curvature**2 * (u * pull[0] + v * pull[1]) / (1 + curvature**2 * (u * u + v * v))
        found.append((-(pull[0] - along * u), -(pull[1] - along * v)))
    return np.concatenate([xd, yd, found[0][0], found[1][1]])


def reached(judgement: Judgement, cargo: Cargo, *, after: float) -> tuple[float, float]:
    """Greatest height along the judged motion, and `after` s from its end, m, by DOP853."""
    played, sides = judgement.replay, sides_of(cargo, FULL_MODES)
    coupled = cargo.shape == "cylinder"
    cos, sin = np.cos(cargo.yaw), np.sin(cargo.yaw)
    turn = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    omega, alpha, force = (played.body[first : first + 3].T for first in (0, 3, 6))
    arm = np.append(cargo.position, 0.0)
    force = force + np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
    body = CubicSpline(played.t, np.hstack([part @ turn.T for part in (omega, alpha, force)]))
    rest = np.array([0, 0, 0, 0, 0, 0, 0, 0, GRAVITY])
    settings = {"method": "DOP853", "rtol": 1e-9, "atol": 1e-11}
    span = (played.t[0], played.t[-1])
    start = np.zeros(4 * FULL_MODES)
    moving = solve_ivp(
        lambda t, z: accelerations(sides, coupled, body(t), z), span, start, t_eval=played.t, max_step=4e-3, **settings
    ).y
    later = np.arange(0.0, after, 1e-3)
    free = solve_ivp(
        lambda _, z: accelerations(sides, coupled, rest, z), (0, after), moving[:, -1], t_eval=later, **settings
    ).y
    now = body(played.t)
    omega, alpha, force = now[:, :3], now[:, 3:6], now[:, 6:]
    assert cargo.filling is not None
    top = np.array([0.0, 0.0, cargo.filling.liquid_height])
    surface = force + np.cross(alpha, top) + np.cross(omega, np.cross(omega, top))

    def crest(states: np.ndarray, lean: np.ndarray) -> float:
        displacement = states.reshape(4, FULL_MODES, -1)[:2]
        eta = [own.gain @ q - own.missing * axis for own, q, axis in zip(sides, displacement, lean, strict=True)]
        return float(np.max(np.hypot(*eta) if coupled else np.abs(eta[0]) + np.abs(eta[1])))

    return crest(moving, surface[:, :2].T / surface[:, 2]), crest(free, np.zeros((2, 1)))


def row(judgement: Judgement, constraint: str, subject: str) -> Row:
    rows = (row for row in judgement.certificate.rows if (row.constraint, row.subject) == (constraint, subject))
    return next(rows)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "subject", "tilt"),
    [("mixed-tray", "cup", (0.0, 0.0)), ("mixed-tray", "box", (0.2, -0.15)), ("mixed-tray", "mug", (0.2, -0.15))],
)
def test_heights_of_a_smooth_motion(smooth_motion, name: str, subject: str, tilt: tuple[float, float]) -> None:
    motion = smooth_motion(name, stretch=0.9, tilt=tilt)
    scene = full_scene(motion.scene)
    judgement = judge_motion(motion.trajectory, scene)
    cargo = next(item for item in scene.cargo if item.name == subject)
    height, residual = reached(judgement, cargo, after=2.0)
    found, limit = row(judgement, HEIGHT, subject), row(judgement, RESIDUAL, subject).limit
    assert found.worst_value == pytest.approx(height, rel=2e-4)
    # A bound for all time; the paraboloid of the first mode, which swings on with it here, is left out there.
    assert residual <= row(judgement, RESIDUAL, subject).worst_value + 5e-3 * limit


@pytest.mark.slow
def test_a_certified_plan_keeps_its_limits_with_twenty_modes(changed_scene) -> None:
    scene = changed_scene("pp-two-cups", {"planning.slosh_modes": FULL_MODES, "fidelity": "full"})
    found = plan(replace(scene, cargo=scene.cargo[:1]))
    assert found.status == "certified" and found.judgement is not None
    assert found.trajectory.slosh["left"].displacement.shape[1] == 2 * FULL_MODES
    for cargo in found.scene.cargo:
        height, residual = reached(found.judgement, cargo, after=2.0)
        for constraint, ours in ((HEIGHT, height), (RESIDUAL, residual)):
            judged = row(found.judgement, constraint, cargo.name)
            assert ours <= 1.005 * judged.limit
            assert ours <= judged.worst_value + 5e-3 * judged.limit
        assert height == pytest.approx(row(found.judgement, HEIGHT, cargo.name).worst_value, rel=5e-4)


@pytest.mark.slow
def test_what_one_mode_allows_twenty_refuse() -> None:
    """The fastest motion for one mode excites the others, which the optimiser did not see."""
    scene = full_scene(read_scenario("matrix-liquid-tilt"))
    scene = replace(scene, cargo=scene.cargo[:1])
    paths = joint_paths(scene.robot, scene.path, tool=scene.tray.tool)
    path = preferred_path(paths, scene.robot, scene.start_near)
    trajectory = exported(found_motion(Task.of(scene.with_one_mode()), path, Log(None, 300.0)))
    blind, seeing = (judge_motion(trajectory, item) for item in (scene.with_one_mode(), scene))
    names = (HEIGHT, RESIDUAL)
    assert all(row(blind, name, "c1").use < 1.003 for name in names)
    assert all(row(seeing, name, "c1").use > 1.03 for name in names) and not seeing.certificate.ok


def test_modes_are_those_the_scenario_states(changed_scene) -> None:
    counts = [
        structure_of(scene).objects[0].modes
        for scene in (
            read_scenario("matrix-liquid-tilt"),
            changed_scene("matrix-liquid-tilt", {"planning.slosh_modes": 3}),
            read_scenario("matrix-liquid"),
            changed_scene("matrix-liquid", {"planning.slosh_modes": 2}),
        )
    ]
    assert counts == [1, 3, 1, 2]


@pytest.mark.parametrize("index", [0, 2])
def test_residual_played_on_bounds_the_free_motion(index: int) -> None:
    """Of random ends: never below the highest surface of a minute, never above the sum of the modes' bounds."""
    scene = full_scene(read_scenario("mixed-tray"))
    item, numbers = structure_of(scene).objects[index], numbers_of(scene).objects[index]
    axes = [mode for mode, own in zip(numbers.oscillators, item.oscillators, strict=True) for _ in own]
    frequency, damping, gain = (
        np.array([getattr(mode, name) for mode in axes]) for name in ("frequency", "damping", "surface_gain")
    )
    random = np.random.default_rng(7)
    for _ in range(3):
        amplitude = 1e-3 / (1 + np.arange(len(axes)) // 2) ** 1.5
        q, qd = random.normal(size=(2, len(axes))) * amplitude
        value = residual_height(item, numbers, q, qd * frequency, 1e-4)
        later, _ = free_states(frequency, damping, q, qd * frequency, np.arange(0.0, 60.0, 1e-3))
        highest = free_heights(item, numbers, later).max()
        assert highest <= 1.003 * value
        assert value <= 1.1 * highest
        assert value <= 1.03 * np.sum(gain * np.hypot(np.abs(q), np.abs(qd) + damping * np.abs(q)))


def test_free_states_are_a_motion() -> None:
    """Rates are the derivative of displacements, and both start as given."""
    random = np.random.default_rng(2)
    frequency, damping = random.uniform(20, 120, 6), random.uniform(0, 0.3, 6)
    q, qd = random.normal(size=(2, 6)) * [[1e-3], [0.05]]
    t = np.arange(0.0, 0.2, 1e-5)
    displacement, rate = free_states(frequency, damping, q, qd, t)
    np.testing.assert_allclose(displacement[0], q, atol=1e-15)
    np.testing.assert_allclose(rate[0], qd, atol=1e-14)
    np.testing.assert_allclose(np.gradient(displacement, t, axis=0)[1:-1], rate[1:-1], atol=1e-6)


@pytest.mark.slow
def test_full_model_beside_a_published_certificate(smooth_motion: Callable) -> None:
    """The same rows as a verdict at full fidelity, which `ok` does not depend on."""
    motion = smooth_motion("matrix-liquid", cargo=2, stretch=0.6)
    judgement = judge_motion(motion.trajectory, motion.scene)
    certificate = with_full_model(judgement.certificate, motion.trajectory, motion.scene)
    assert certificate.published and certificate.ok == judgement.certificate.ok
    assert certificate.rows == judgement.certificate.rows
    assert certificate.full_model is not None
    assert {item.constraint for item in certificate.full_model} >= {HEIGHT}
    heights = [item for item in certificate.full_model if item.constraint == HEIGHT]
    for item in heights:
        cargo = next(own for own in full_scene(motion.scene).cargo if own.name == item.subject)
        assert item.worst_value == pytest.approx(reached(judgement, cargo, after=0.01)[0], rel=1e-3)
    worst = max(heights, key=lambda item: item.use)
    note = full_model_note(certificate)
    assert f'{1e3 * worst.worst_value:.3g} mm in "{worst.subject}"' in note and "over its limit" in note
    assert with_full_model(certificate, motion.trajectory, motion.scene) is certificate


def test_full_model_looks_at_solids_too(smooth_motion: Callable) -> None:
    """Slip and twist draw on the same friction there: without liquids too, a published plan may slide."""
    motion = smooth_motion("matrix-rigid", stretch=0.4)
    published = judge_motion(motion.trajectory, motion.scene).certificate
    full = judge_motion(motion.trajectory, full_scene(motion.scene)).certificate
    found = with_full_model(published, motion.trajectory, motion.scene).full_model
    contact = ("lift", "slip", "tip", "twist")
    assert found and found == tuple(row for row in full.rows if row.constraint in contact and not row.ok)
    assert "slips" in full_model_note(replace(published, full_model=found))
    assert with_full_model(full, motion.trajectory, full_scene(motion.scene)).full_model == ()


def test_twenty_modes_beside_a_certificate_with_one(smooth_motion: Callable) -> None:
    tilting = smooth_motion("mixed-tray", stretch=0.8)
    one = judge_motion(tilting.trajectory, tilting.scene).certificate
    assert full_model_note(one) == ""  # nobody has looked
    noted = with_full_model(one, tilting.trajectory, tilting.scene)
    assert noted.ok == one.ok and noted.full_model and "20 modes of each liquid see" in full_model_note(noted)
    assert with_full_model(one, tilting.trajectory, full_scene(tilting.scene)).full_model == ()


def test_words_of_a_verdict(smooth_motion: Callable) -> None:
    for name, expected in (("matrix-liquid", "certified as published"), ("mixed-tray", "certified")):
        motion = smooth_motion(name, stretch=1.3)
        certificate = judge_motion(motion.trajectory, motion.scene).certificate
        assert certificate.word == expected
        assert replace(certificate, ok=False).word == "not certified"
        assert certificate.to_dict()["published"] == (name == "matrix-liquid")
