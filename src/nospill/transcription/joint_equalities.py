"""The joints carry the tray: pose and motion of the tray frame from the joints equal those from path and tilt.

Joint positions and their derivatives are variables of the node. Each order has six equations, and with seven joints a
seventh: the self-motion goes as its chain does. Accelerations are variables only where acceleration, torque or
jerk is limited, jerks only where they are. Where the arm is kept regular, the determinant of its Jacobian is a variable
with a bound.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import casadi as ca

from nospill.core.frames import SX
from nospill.laws.parameters import SceneNumbers
from nospill.laws.structure import Structure
from nospill.robots.kinematics.chain import about_z
from nospill.robots.kinematics.forward import kinematics
from nospill.robots.kinematics.regularity import determinant_expression
from nospill.robots.tool import TOOL_NUMBERS
from nospill.transcription.layout import IntegratorChain, Layout
from nospill.transcription.path_expression import PathPiece
from nospill.transcription.problem_numbers import ProblemNumbers
from nospill.transcription.tray_state import TrayState, tray_state


def joint_equalities(
    structure: Structure,
    numbers: SceneNumbers,
    own: ProblemNumbers,
    stage: SX,
    layout: Layout,
    chains: tuple[IntegratorChain, ...],
    piece: PathPiece,
    tray: TrayState,
) -> SX:
    """The equations (zero) of a node; `stage` (layout.size, 1) in physical units, `tray` as the chains have it.

    `piece` is the path's at the node.

    Half the antisymmetric part of R_d^T R is sin(angle) times the axis of the remaining turn, zero only where the
    attitudes agree (or differ by half a turn).
    """
    joints = [stage[layout.joint_derivative(order)] for order in range(layout.orders + 1)]
    if structure.by_joints:
        return ca.vertcat(*joints) - _along(piece.of_joints, chains[0], stage[layout.jerks], layout.orders)
    arm, place, yaw = kinematics(structure), numbers.base[:3], about_z(numbers.base[3])
    position, rotation = arm.pose(joints[0], tool=numbers.tool)
    velocity, omega = arm.twist(joints[0], joints[1], tool=numbers.tool)
    turn = tray.rotation.T @ yaw @ rotation
    equations = [
        place + yaw @ position - tray.position,
        ca.vertcat(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]) / 2,
        yaw @ velocity - tray.velocity,
        tray.rotation.T @ yaw @ omega - tray.motion.angular_velocity,
    ]
    if layout.orders > 1:
        change = _twist_change(structure)(*joints[:3], numbers.tool)
        equations.append(_turned(yaw, change) - ca.vertcat(*tray.acceleration(numbers.gravity)))
    if layout.orders > 2:
        jerk = _twist_jerk(structure)(*joints, numbers.tool)
        of_chains = _tray_jerk(structure, numbers, layout, chains, piece, stage[layout.jerks])
        equations.append(_turned(yaw, jerk) - of_chains)
    if layout.redundant:
        chain = (*chains[-1], stage[layout.jerks][-1])
        equations += [ca.dot(own.self_motion, joints[order]) - chain[order] for order in range(layout.orders + 1)]
    if layout.regular:
        equations.append(determinant_expression(structure, joints[0], own.self_motion) - stage[layout.size - 1])
    return ca.vertcat(*equations)


def _turned(rotation: SX, twist: SX) -> SX:
    """Linear and angular half (6, 1) in other axes."""
    return ca.vertcat(rotation @ twist[:3], rotation @ twist[3:])


@lru_cache(maxsize=16)
def _twist_change(structure: Structure) -> Any:
    """(q, qd, qdd, tool) -> time derivative (6, 1) of the tray's twist in axes of the arm."""
    arm = kinematics(structure)
    symbols = [SX.sym(name, arm.n) for name in ("q", "qd", "qdd")]
    tool = SX.sym("tool", TOOL_NUMBERS)
    return ca.Function("twist_change", [*symbols, tool], [arm.twist_change(*symbols, tool=tool)], {"cse": True})


@lru_cache(maxsize=16)
def _twist_jerk(structure: Structure) -> Any:
    """(q, qd, qdd, qddd, tool) -> second time derivative (6, 1) of the tray's twist in axes of the arm."""
    arm = kinematics(structure)
    symbols = [SX.sym(name, arm.n) for name in ("q", "qd", "qdd", "qddd")]
    tool = SX.sym("tool", TOOL_NUMBERS)
    change = _twist_change(structure)(*symbols[:3], tool)
    jerk = ca.jtimes(change, ca.vertcat(*symbols[:3]), ca.vertcat(*symbols[1:]))
    return ca.Function("twist_jerk", [*symbols, tool], [jerk], {"cse": True})


def _tray_jerk(
    structure: Structure,
    numbers: SceneNumbers,
    layout: Layout,
    chains: tuple[IntegratorChain, ...],
    piece: PathPiece,
    jerks: SX,
) -> SX:
    """Second time derivative (6, 1) of the tray's twist in base axes, right after the node: there the jerk jumps."""
    symbol = SX.sym("chains", 3 * layout.chains)
    moving = tuple(layout.chain(symbol, index) for index in range(layout.chains))
    tray = tray_state(piece, moving, freedom=structure.freedom, gravity=numbers.gravity)
    acceleration = ca.vertcat(*tray.acceleration(numbers.gravity))
    rates = [ca.vertcat(*chain[1:], jerks[index]) for index, chain in enumerate(chains)]
    jerk = ca.jtimes(acceleration, symbol, ca.vertcat(*rates))
    return ca.substitute(jerk, symbol, ca.vertcat(*[ca.vertcat(*chain) for chain in chains]))


def _along(piece: PathPiece, chain: IntegratorChain, jerk: SX, orders: int) -> SX:
    """Joints on a path of theirs and their time derivatives up to an order, one after the other, by the chain rule."""
    s, speed, acceleration = chain
    value, first, second = piece.at(s)
    rates = [value, first * speed, second * speed**2 + first * acceleration]
    if orders > 2:
        rates.append(piece.third(s) * speed**3 + 3 * second * speed * acceleration + first * jerk)
    return ca.vertcat(*rates[: orders + 1])
