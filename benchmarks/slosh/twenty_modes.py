"""Twenty modes of every liquid, written out a second time and integrated by another method, on certified plans.

    python -m benchmarks.slosh.twenty_modes                 plan the published tasks at full fidelity, print the table
    python -m benchmarks.slosh.twenty_modes mixed-tray      some of the examples
    python -m benchmarks.slosh.twenty_modes --modes 2       planned and judged with so many modes instead

The formulas are those of linear potential flow (docs/slosh-model.md); the first mode slides on its paraboloid. What a
turn excites in a box is that of `turned_boxes`, added as if it stood in the highest corner. The
motion of the tray is that of its exported poses, the integrator SciPy's DOP853; of the package's own physics nothing
is used but what a scenario states.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline, make_interp_spline
from scipy.special import jnp_zeros

from benchmarks.slosh.turned_boxes import TurningModes, turned
from nospill.motion.trajectory import Trajectory
from nospill.planning.planner import plan
from nospill.plans.plan import Plan
from nospill.scenario import read_scenario
from nospill.scene.cargo import Cargo
from nospill.scene.scene import FULL_MODES, Scene
from nospill.scene.variants import variants_by_object

EXAMPLES = (
    "matrix-liquid",
    "matrix-liquid-still",
    "matrix-liquid-soft-end",
    "matrix-rigid",
    "pp-two-cups",
    "matrix-liquid-tilt",
    "matrix-liquid-tilt-all-limits",
    "matrix-liquid-tilt-robust",
    "mixed-tray",
)
"""Those of the published tasks and their variations."""
GRAVITY = 9.80665
AFTER = 20.0
"""s; how long the liquids are watched after the end."""
_GRID = 2000.0


@dataclass(frozen=True)
class TrayMotion:
    """How a tray moves: t (m,) s; rows (m, 9) angular velocity and acceleration and specific force in its own axes."""

    t: np.ndarray
    rows: np.ndarray


@dataclass(frozen=True)
class Side:
    """Modes along one direction, arrays (n,).

    `missing` is the height per lean that they leave out, m; `laminar` the laminar damping ratio of the first.
    """

    frequency: np.ndarray
    stiffness: np.ndarray
    curvature: np.ndarray
    height: np.ndarray
    damping: np.ndarray
    gain: np.ndarray
    missing: float
    laminar: float


def tray_motion(record: Trajectory) -> TrayMotion:
    """Of the poses in a record, between them by splines of the fifth degree."""
    x, y, z, w = record.tray_quaternion.T
    turned = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    rotation = make_interp_spline(record.t, np.moveaxis(turned, 2, 0), k=5)
    place = make_interp_spline(record.t, record.tray_position, k=5)
    t = np.linspace(record.t[0], record.t[-1], round((record.t[-1] - record.t[0]) * _GRID) + 1)
    back = np.swapaxes(rotation(t), 1, 2)
    found = []
    for order in (1, 2):  # the part of R'R'' that is symmetric is the square of the first
        rate = back @ rotation(t, order)
        found += [(rate[:, row, column] - rate[:, column, row]) / 2 for row, column in ((2, 1), (0, 2), (1, 0))]
    felt = place(t, 2) + np.array([0.0, 0.0, GRAVITY])
    force = np.einsum("mij,mj->mi", back, felt)
    return TrayMotion(t, np.column_stack([*found, force]))


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
        float(laminar[0]),
    )


def sides_of(cargo: Cargo, count: int) -> tuple[Side, Side]:
    """Along x and along y, of a cylinder or a box."""
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
    omega, force = body[:3], body[6:]
    turning = _cross(omega)
    frame = np.hstack([_cross(body[3:6]) + turning @ turning, 2 * turning])
    x, y, xd, yd = state.reshape(4, -1)
    none = np.zeros_like(x)
    moves = [(x, y, xd, yd)] if coupled else [(x, none, xd, none), (none, y, none, yd)]
    found = []
    for modes, (u, v, ud, vd) in zip(sides, moves, strict=False):
        curvature = modes.curvature
        squared, sliding = u * u + v * v, curvature * (u * ud + v * vd)
        place = u, v, modes.height + curvature * squared / 2
        felt = force[:, None] + frame @ np.array([*place, ud, vd, sliding])
        axial = force[2] - (omega[0] ** 2 + omega[1] ** 2) * modes.height
        down = curvature * (felt[2] + curvature * (ud * ud + vd * vd)) + (modes.stiffness - curvature) * axial
        slip = curvature * sliding
        friction = 2 * modes.damping * modes.frequency
        pull = [felt[0] + down * u + friction * (ud + slip * u), felt[1] + down * v + friction * (vd + slip * v)]
        if not coupled:  # across it the box holds
            pull[1 - len(found)] = none
        along = curvature**2 * (u * pull[0] + v * pull[1]) / (1 + curvature**2 * squared)
        found.append((along * u - pull[0], along * v - pull[1]))
    return np.concatenate([xd, yd, found[0][0], found[-1][1]])


def _cross(vector: np.ndarray) -> np.ndarray:
    """(3, 3): the product with it."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def reached(tray: TrayMotion, cargo: Cargo, *, after: float = AFTER, error: float = 1e-9) -> tuple[float, float]:
    """Greatest height of a liquid along a motion, and `after` s from its end, m, with twenty modes.

    Args:
        tray: how it moves.
        cargo: the liquid.
        after: s.
        error: relative, of a step; a hundredth of that in m.
    """
    sides, coupled = sides_of(cargo, FULL_MODES), cargo.shape == "cylinder"
    cos, sin = np.cos(cargo.yaw), np.sin(cargo.yaw)
    turn = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    omega, alpha, force = (tray.rows[:, first : first + 3] for first in (0, 3, 6))
    arm = np.append(cargo.position, 0.0)
    force = force + np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
    body = CubicSpline(tray.t, np.hstack([part @ turn.T for part in (omega, alpha, force)]))
    rest = np.array([0, 0, 0, 0, 0, 0, 0, 0, GRAVITY])
    settings = {"method": "DOP853", "rtol": error, "atol": error / 100}
    span = (tray.t[0], tray.t[-1])
    start = np.zeros(4 * FULL_MODES)
    moving = solve_ivp(
        lambda t, z: accelerations(sides, coupled, body(t), z), span, start, t_eval=tray.t, max_step=4e-3, **settings
    ).y
    later = np.arange(0.0, after, 1e-3)
    added = np.zeros(len(tray.t)), np.zeros(len(later))
    if not coupled:
        assert cargo.filling is not None
        slowest = min((item for item in sides), key=lambda item: item.frequency[0])
        stated = min(cargo.oscillators, key=lambda mode: mode.frequency).damping
        added = turned(
            TurningModes.of(cargo, stated / slowest.laminar), cargo.filling.liquid_height, body, tray.t, later
        )
    free = solve_ivp(
        lambda _, z: accelerations(sides, coupled, rest, z), (0, after), moving[:, -1], t_eval=later, **settings
    ).y
    now = body(tray.t)
    omega, alpha, force = now[:, :3], now[:, 3:6], now[:, 6:]
    assert cargo.filling is not None
    top = np.array([0.0, 0.0, cargo.filling.liquid_height])
    surface = force + np.cross(alpha, top) + np.cross(omega, np.cross(omega, top))

    def crest(states: np.ndarray, lean: np.ndarray, turning: np.ndarray) -> float:
        displacement = states.reshape(4, FULL_MODES, -1)[:2]
        eta = [own.gain @ q - own.missing * axis for own, q, axis in zip(sides, displacement, lean, strict=True)]
        return float(np.max(np.hypot(*eta) if coupled else np.abs(eta[0]) + np.abs(eta[1]) + turning))

    return crest(moving, surface[:, :2].T / surface[:, 2], added[0]), crest(free, np.zeros((2, 1)), added[1])


def uses(found: Plan) -> tuple[float, float]:
    """Largest use of a limit along the motion and after its end, of every liquid in each of its variants."""
    tray, scene = tray_motion(found.trajectory), found.scene
    largest = [0.0, 0.0]
    for family in variants_by_object(scene):
        for cargo in {id(item.cargo): item.cargo for item in family}.values():
            if cargo.filling is None:
                continue
            limit = cargo.filling.max_slosh_height
            limits = (limit, scene.motion.residual_fraction * limit)
            parts = [height / own for height, own in zip(reached(tray, cargo), limits, strict=True)]
            largest = [max(pair) for pair in zip(largest, parts, strict=True)]
    return largest[0], largest[1]


def full(name: str, modes: int) -> Scene:
    """An example at full fidelity with so many modes."""
    return read_scenario(name, settings=["fidelity=full", f"planning.slosh_modes={modes}"])


def main(arguments: Sequence[str] | None = None) -> None:
    """Plan, integrate and print a line for each example."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("examples", nargs="*", default=EXAMPLES)
    parser.add_argument("--modes", type=int, default=FULL_MODES, help="that are planned and judged")
    chosen = parser.parse_args(arguments)
    print("| example | status | duration | processor time | height | after the end |\n|---|---|---|---|---|---|")
    for name in chosen.examples:
        began = time.process_time()
        found = plan(full(name, chosen.modes))
        spent = time.process_time() - began
        height, residual = (f"{100 * use:.2f} %" for use in uses(found))
        cells = (f"`{name}`", found.status, f"{found.duration:.4f} s", f"{spent:.1f} s", height, residual)
        print(f"| {' | '.join(cells)} |", flush=True)


if __name__ == "__main__":
    main()
