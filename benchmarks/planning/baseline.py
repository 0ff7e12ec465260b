"""The published transcription, written out plainly: what the planner is measured against.

    python -m benchmarks.planning.baseline liquid | rigid

Multiple shooting with RK4 on N = 150 intervals through `Function.map`, everything unscaled, free horizon T, IPOPT with
MUMPS and CasADi's own derivatives [D3]. The functions of one instant are written in SX, all but the splines, which
CasADi has in MX only: in MX throughout an iteration takes 2.3 times as long. Nothing of the package's optimal control
problem is used, only the data of a scene: path, numbers of the cups, limits of the arm and its kinematics.

liquid (Eq. 6): level tray. s = 1 and no displacement of the liquid at 0.8 T, every later node again at rest at s = 1
    (redundant equalities, as published), a fifth of the height allowed there; cost T + 1e-2 mean(u^2) over the horizon.
rigid (Eq. 11): the tray tilts, rest to rest; cost T + 1e-5 mean(u^2) of each of the three jerks.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

import nospill as ns
from nospill.paths.path import PRESETS
from nospill.robots.joint_paths.search import joint_paths
from nospill.scene.scene import Scene
from nospill.scene.sloshing.modes import STANDARD_GRAVITY as G

MX = ca.MX
SX = ca.SX

INTERVALS = 150
ENDED = 0.8
"""Fraction of the horizon at which the liquid motion has ended."""
LIQUID_JERK_WEIGHT = 1e-2
RIGID_JERK_WEIGHT = 1e-5
LIQUID_FIRST_HORIZONS, RIGID_FIRST_HORIZON = (2.5, 3.0, 4.0), 2.0
"""s; of the straight-line guess. The unscaled problems are touchy: of the liquid one the quickest answer counts."""

LIQUID_ITERATIONS = 700
"""Where the liquid baseline is stopped: the number of iterations is chaotic, and some guesses lead nowhere."""


@dataclass(frozen=True)
class Baseline:
    """What a run of the baseline gave.

    Attributes:
        duration: end time t_e of the motion, s. iterations: of IPOPT. status: its return status.
        build_time, solve_time: s. processor_time: of both, s.
    """

    duration: float
    iterations: int
    status: str
    build_time: float
    solve_time: float
    processor_time: float


def path_function(yaw_end: float = np.pi) -> Any:
    """(s) -> (4, 1): position (m) on the published arc and yaw (rad), a B-spline of degree 4."""
    s = MX.sym("s")
    knots = np.concatenate([np.full(4, -0.001), np.linspace(0, 1, 8), np.full(4, 1.001)])
    points = PRESETS["arc"]()
    spline = ca.Function.bspline("arc", [knots.tolist()], points.ravel().tolist(), [4], 3)
    return ca.Function("path", [s], [ca.vertcat(spline(s), yaw_end * s)])


Motion = tuple[SX, SX, SX]
"""Place, first and second time derivative of (x, y, z, yaw), each (4, 1)."""


def of_the_path(name: str, states: int, controls: int, write: Callable[[SX, SX, Motion], list[SX]]) -> Any:
    """(x, u) -> what `write` makes of x, u and the motion along the path in SX; x = [s, s', s'', ...]."""
    x, u, place, slope, bend = (SX.sym(*of) for of in (("x", states), ("u", controls), ("p", 4), ("d", 4), ("b", 4)))
    motion = place, slope * x[1], bend * x[1] ** 2 + slope * x[2]
    inner = ca.Function("inner", [x, u, place, slope, bend], write(x, u, motion), {"cse": True})
    path, symbol = path_function(), MX.sym("s")
    first = ca.jacobian(path(symbol), symbol)
    derivatives = ca.Function("derivatives", [symbol], [path(symbol), first, ca.jacobian(first, symbol)])
    state, control = MX.sym("x", states), MX.sym("u", controls)
    values = inner(state, control, *derivatives(state[0]))
    return ca.Function(name, [state, control], values if isinstance(values, tuple) else [values])


def runge_kutta(rate: Any, states: int, controls: int) -> Any:
    """(x, u, h) -> x after h seconds of constant u."""
    x, u, h = MX.sym("x", states), MX.sym("u", controls), MX.sym("h")
    k1 = rate(x, u)
    k2 = rate(x + h / 2 * k1, u)
    k3 = rate(x + h / 2 * k2, u)
    k4 = rate(x + h * k3, u)
    return ca.Function("step", [x, u, h], [x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)])


# The liquid on a level tray.


def level_cup_acceleration(place: np.ndarray, position: SX, rate: SX, change: SX) -> SX:
    """Acceleration (3, 1) of a point of the level tray, world axes; `place` (2,) on the tray."""
    c, s = ca.cos(position[3]), ca.sin(position[3])
    x, y = c * place[0] - s * place[1], s * place[0] + c * place[1]
    turn, spin = change[3], rate[3]
    return change[:3] + ca.vertcat(-turn * y - spin**2 * x, turn * x - spin**2 * y, 0)


def sloshing(mode: Any, q: SX, qd: SX, acceleration: SX) -> SX:
    """Second derivative (2, 1) of the modal displacement in world-parallel axes [D3; alpha = 0]."""
    p, omega, zeta = mode.frequency**2 / G, mode.frequency, mode.damping
    force = (
        -(p**2) * ca.dot(qd, qd) * q
        - omega**2 * q
        - 2 * zeta * omega * (qd + p**2 * ca.dot(q, qd) * q)
        - p * acceleration[2] * q
        - acceleration[:2]
    )
    return ca.solve(SX.eye(2) + p**2 * q @ q.T, force)


def level_rate(scene: Scene) -> Any:
    """(x, u) -> rate of x; x = [s, s', s'', then (q, q') of every cup], u = s'''."""

    def write(x: SX, u: SX, motion: Motion) -> list[SX]:
        rates = [x[1], x[2], u]
        for index, cargo in enumerate(scene.cargo):
            assert cargo.filling is not None
            q, qd = x[3 + 4 * index : 5 + 4 * index], x[5 + 4 * index : 7 + 4 * index]
            at_cup = level_cup_acceleration(cargo.position, *motion)
            rates += [qd, sloshing(cargo.filling.modes.oscillators[0], q, qd, at_cup)]
        return [ca.vertcat(*rates)]

    return of_the_path("rate", 3 + 4 * len(scene.cargo), 1, write)


def waiter_rows(cargo: Any, acceleration: SX, spin_change: SX) -> SX:
    """Lift, slip, tip, twist of one object, (5, 1), each >= 0; acceleration less gravity in tray axes (3, 1)."""
    mass, friction = cargo.total.mass, cargo.planned_friction
    radius = cargo.container.footprint.radius
    press = mass * acceleration[2]
    tangential = mass**2 * (acceleration[0] ** 2 + acceleration[1] ** 2)
    moment = cargo.total.inertia[2, 2] * spin_change
    hold = 2 / 3 * friction * radius * press
    return ca.vertcat(
        press,
        (friction * press) ** 2 - tangential,
        (radius / cargo.total.centre[2] * press) ** 2 - tangential,
        hold - moment,
        hold + moment,
    )


def level_rows(scene: Scene) -> Any:
    """(x) -> waiter rows (>= 0), squared heights (m^2), joint positions (rad), joint speeds (rad/s)."""

    def write(x: SX, _: SX, motion: Motion) -> list[SX]:
        waiter, heights = [], []
        for index, cargo in enumerate(scene.cargo):
            assert cargo.filling is not None
            mode, q = cargo.filling.modes.oscillators[0], x[3 + 4 * index : 5 + 4 * index]
            at_cup = level_cup_acceleration(cargo.position, *motion)
            waiter.append(waiter_rows(cargo, at_cup + ca.vertcat(0, 0, G), motion[2][3]))
            heights.append(mode.surface_gain**2 * ca.dot(q, q))
        return [ca.vertcat(*waiter), ca.vertcat(*heights)]

    states = 3 + 4 * len(scene.cargo)
    of_cups = of_the_path("cups", states, 0, write)
    x, table, s = MX.sym("x", states), joint_table(scene), MX.sym("s")
    slope = ca.Function("slope", [s], [ca.jacobian(table(s), s)])
    return ca.Function("rows", [x], [*of_cups(x, MX(0, 1)), table(x[0]), slope(x[0]) * x[1]])


def joint_table(scene: Scene) -> Any:
    """(s) -> q (n, 1), rad, of the level tray: a spline through the inverse kinematics."""
    found = joint_paths(scene.robot, scene.path, tool=scene.tray.tool, samples=101)[0]
    return ca.interpolant("joints", "bspline", [found.s.tolist()], np.round(found.q, 9).ravel().tolist())


def quickest_liquid(scene: Scene | None = None, *, print_level: int = 0) -> Baseline:
    """Eq. 6 from several first horizons: the answer that took least time; the last where none converged."""
    found = [solve_liquid(scene, first_horizon=first, print_level=print_level) for first in LIQUID_FIRST_HORIZONS]
    converged = [item for item in found if item.status == "Solve_Succeeded"]
    return min(converged or found[-1:], key=lambda item: item.build_time + item.solve_time)


def solve_liquid(scene: Scene | None = None, *, first_horizon: float, print_level: int = 0) -> Baseline:
    """Eq. 6 as published, from a straight line in a first horizon, s."""
    scene = scene or ns.load("matrix-liquid")
    began = _clocks()
    cups, robot, limit = len(scene.cargo), scene.robot, scene.motion.path_jerk_limit
    states, ended = 3 + 4 * cups, round(ENDED * INTERVALS)
    step = runge_kutta(level_rate(scene), states, 1).map(INTERVALS)
    rows = level_rows(scene).map(INTERVALS + 1)

    problem = ca.Opti()
    horizon = problem.variable()
    x, u = problem.variable(states, INTERVALS + 1), problem.variable(1, INTERVALS)
    problem.minimize(horizon + LIQUID_JERK_WEIGHT * ca.sumsqr(u) / INTERVALS)
    interval = ca.repmat(horizon / INTERVALS, 1, INTERVALS)
    problem.subject_to(x[:, 1:] == step(x[:, :-1], u, interval))
    problem.subject_to(x[:, 0] == 0)
    problem.subject_to(ca.vec(x[0, ended:]) == 1)
    problem.subject_to(ca.vec(x[1:3, ended:]) == 0)
    for index in range(cups):
        problem.subject_to(x[3 + 4 * index : 5 + 4 * index, ended] == 0)
    waiter, heights, joints, speeds = rows(x)
    problem.subject_to(ca.vec(waiter) >= 0)
    for index, cargo in enumerate(scene.cargo):
        assert cargo.filling is not None
        allowed = cargo.filling.max_slosh_height
        problem.subject_to(ca.vec(heights[index, :ended]) <= allowed**2)
        problem.subject_to(ca.vec(heights[index, ended:]) <= (scene.motion.residual_fraction * allowed) ** 2)
    for joint in range(len(robot.joints)):
        problem.subject_to(problem.bounded(robot.lower[joint], ca.vec(joints[joint, :]), robot.upper[joint]))
        speed = robot.max_speed[joint]
        problem.subject_to(problem.bounded(-speed, ca.vec(speeds[joint, :]), speed))
    problem.subject_to(problem.bounded(-limit, u, limit))
    problem.subject_to(problem.bounded(0.1, horizon, 20))
    problem.subject_to(problem.bounded(0, x[0, :], 1))

    guess = np.zeros((states, INTERVALS + 1))
    guess[0] = np.minimum(np.arange(INTERVALS + 1) / ended, 1.0)
    problem.set_initial(x, guess)
    problem.set_initial(horizon, first_horizon)
    return _solved(problem, horizon, ENDED, began, print_level, LIQUID_ITERATIONS)


# Rigid objects on a tilting tray.


def tilting_tray(x: SX, motion: Motion) -> tuple[SX, SX, SX]:
    """R (3, 3), omega and alpha (3, 1) of the tray, in world axes.

    x = [s, s', s'', theta_x, .., theta_y, ..]; R = Rz(yaw) Ry(theta_y) Rx(theta_x) [D3, Eq. 11]. omega and alpha follow
    from R' R^T.
    """
    place, rate, change = motion
    yaw, tilt_x, tilt_y = place[3], x[3], x[6]
    axis_y = ca.vertcat(-ca.sin(yaw), ca.cos(yaw), 0)
    axis_x = ca.vertcat(ca.cos(yaw) * ca.cos(tilt_y), ca.sin(yaw) * ca.cos(tilt_y), -ca.sin(tilt_y))
    omega = ca.vertcat(0, 0, rate[3]) + axis_y * x[7] + axis_x * x[4]
    alpha = (
        ca.vertcat(0, 0, change[3])
        + axis_y * x[8]
        + axis_x * x[5]
        + ca.cross(ca.vertcat(0, 0, rate[3]), axis_y) * x[7]
        + ca.cross(ca.vertcat(0, 0, rate[3]) + axis_y * x[7], axis_x) * x[4]
    )
    return about_z(yaw) @ about_y(tilt_y) @ about_x(tilt_x), omega, alpha


def closed_chain(scene: Scene) -> Any:
    """(place, rate, tilt, tilt rate) -> q, q' of the arm, in closed form (spherical wrist, lengths of the Smart SiX).

    place and rate are (x, y, z, yaw) of the tray and their time derivatives, tilt is (theta_x, theta_y). The branch is
    that of the level tray's joint table.
    """
    place, rate = ca.SX.sym("place", 4), ca.SX.sym("rate", 4)
    tilt, tilt_rate = ca.SX.sym("tilt", 2), ca.SX.sym("tilt_rate", 2)
    table = np.array(joint_table(scene)(ca.DM(np.linspace(0, 1, 101)).T))
    near = table[:, 50]
    rotation = about_z(place[3]) @ about_y(tilt[1]) @ about_x(tilt[0])
    wrist = place[:3] - (float(scene.tray.tool.position[2]) + 0.095) * rotation[:, 2]
    q1 = -ca.atan2(wrist[1], wrist[0])
    out, up = ca.sqrt(wrist[0] ** 2 + wrist[1] ** 2) - 0.150, wrist[2] - 0.450
    upper, fore, bend = 0.590, float(np.hypot(0.130, 0.64707)), float(np.arctan2(0.130, 0.64707))
    elbow = ca.acos((out**2 + up**2 - upper**2 - fore**2) / (2 * upper * fore))
    elbow *= float(np.sign(-near[2] - bend))
    q2 = ca.atan2(out, up) - ca.atan2(fore * ca.sin(elbow), upper + fore * ca.cos(elbow))
    forearm = q2 + elbow + bend
    turn = (about_z(-q1) @ about_y(forearm)).T @ rotation @ about_z(-scene.tray.tool.yaw)
    side = float(np.sign(near[4]))
    q5 = side * ca.acos(turn[2, 2])
    q4 = _angle_near(near[3], -side * turn[1, 2], side * turn[0, 2])
    q6 = _angle_near(near[5], -side * turn[2, 1], -side * turn[2, 0])
    q = ca.vertcat(q1, q2, q2 - forearm, q4, q5, q6)
    speed = ca.jtimes(q, ca.vertcat(place, tilt), ca.vertcat(rate, tilt_rate))
    return ca.Function("arm", [place, rate, tilt, tilt_rate], [q, speed], {"cse": True})


def _angle_near(middle: float, sine: ca.SX, cosine: ca.SX) -> ca.SX:
    """The angle of (cosine, sine) within half a turn of `middle`."""
    c, s = float(np.cos(middle)), float(np.sin(middle))
    return middle + ca.atan2(c * sine - s * cosine, c * cosine + s * sine)


def tilting_rows(scene: Scene) -> Any:
    """(x) -> waiter rows (>= 0), joint positions (rad), joint speeds (rad/s)."""
    arm = closed_chain(scene)

    def write(x: SX, _: SX, motion: Motion) -> list[SX]:
        rotation, omega, alpha = tilting_tray(x, motion)
        body_omega, body_alpha = rotation.T @ omega, rotation.T @ alpha
        at_tray = rotation.T @ (motion[2][:3] + ca.vertcat(0, 0, G))
        waiter = []
        for cargo in scene.cargo:
            lever = ca.DM(np.append(cargo.position, cargo.total.centre[2]))
            at_object = at_tray + ca.cross(body_alpha, lever) + ca.cross(body_omega, ca.cross(body_omega, lever))
            waiter.append(waiter_rows(cargo, at_object, body_alpha[2]))
        joints, speeds = arm(motion[0], motion[1], ca.vertcat(x[3], x[6]), ca.vertcat(x[4], x[7]))
        return [ca.vertcat(*waiter), joints, speeds]

    x = MX.sym("x", 9)
    return ca.Function("rows", [x], of_the_path("objects", 9, 0, write)(x, MX(0, 1)))


def solve_rigid(scene: Scene | None = None, *, print_level: int = 0) -> Baseline:
    """Eq. 11 as published."""
    scene = scene or ns.load("matrix-rigid")
    began = _clocks()
    robot, path_limit, tilt_limit = scene.robot, scene.motion.path_jerk_limit, scene.motion.tilt_jerk_limit
    state, control = SX.sym("x", 9), SX.sym("u", 3)
    chains = [ca.vertcat(state[3 * k + 1], state[3 * k + 2], control[k]) for k in range(3)]
    rate = ca.Function("rate", [state, control], [ca.vertcat(*chains)])
    step = runge_kutta(rate, 9, 3).map(INTERVALS)
    rows = tilting_rows(scene).map(INTERVALS + 1)

    problem = ca.Opti()
    horizon = problem.variable()
    x, u = problem.variable(9, INTERVALS + 1), problem.variable(3, INTERVALS)
    problem.minimize(horizon + RIGID_JERK_WEIGHT * ca.sumsqr(u) / INTERVALS)
    interval = ca.repmat(horizon / INTERVALS, 1, INTERVALS)
    problem.subject_to(x[:, 1:] == step(x[:, :-1], u, interval))
    problem.subject_to(x[:, 0] == 0)
    problem.subject_to(x[:, -1] == ca.DM([1, 0, 0, 0, 0, 0, 0, 0, 0]))
    waiter, joints, speeds = rows(x)
    problem.subject_to(ca.vec(waiter) >= 0)
    for joint in range(len(robot.joints)):
        problem.subject_to(problem.bounded(robot.lower[joint], joints[joint, :], robot.upper[joint]))
        speed = robot.max_speed[joint]
        problem.subject_to(problem.bounded(-speed, speeds[joint, :], speed))
    for row, limit in enumerate((path_limit, tilt_limit, tilt_limit)):
        problem.subject_to(problem.bounded(-limit, u[row, :], limit))
    problem.subject_to(problem.bounded(0.1, horizon, 20))
    problem.subject_to(problem.bounded(0, x[0, :], 1))

    guess = np.zeros((9, INTERVALS + 1))
    guess[0] = np.linspace(0, 1, INTERVALS + 1)
    problem.set_initial(x, guess)
    problem.set_initial(horizon, RIGID_FIRST_HORIZON)
    return _solved(problem, horizon, 1.0, began, print_level)


def _solved(
    problem: Any, horizon: MX, fraction: float, began: tuple[float, float], print_level: int, iterations: int = 3000
) -> Baseline:
    options = {"print_level": print_level, "sb": "yes", "max_iter": iterations}
    problem.solver("ipopt", {"print_time": False}, options)
    built = time.perf_counter()
    try:
        answer: Any = problem.solve()
    except RuntimeError:
        answer = problem.debug
    stats = problem.stats()
    return Baseline(
        duration=fraction * float(answer.value(horizon)),
        iterations=int(stats["iter_count"]),
        status=str(stats["return_status"]),
        build_time=built - began[0],
        solve_time=time.perf_counter() - built,
        processor_time=time.process_time() - began[1],
    )


def _clocks() -> tuple[float, float]:
    """Of the wall and of the processor, s."""
    return time.perf_counter(), time.process_time()


def about_z(angle: Any) -> Any:
    """Rz(angle), shape (3, 3), of MX or SX."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))


def about_y(angle: Any) -> Any:
    """Ry(angle), shape (3, 3), of MX or SX."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(c, 0, s), ca.horzcat(0, 1, 0), ca.horzcat(-s, 0, c))


def about_x(angle: Any) -> Any:
    """Rx(angle), shape (3, 3), of MX or SX."""
    c, s = ca.cos(angle), ca.sin(angle)
    return ca.vertcat(ca.horzcat(1, 0, 0), ca.horzcat(0, c, -s), ca.horzcat(0, s, c))


SOLVE = {"liquid": quickest_liquid, "rigid": solve_rigid}

if __name__ == "__main__":
    for name in sys.argv[1:] or SOLVE:
        print(name, SOLVE[name](print_level=5))
