"""Steps of Newton's method on the pose of a tool, compiled: the gap between two poses and the shortest way across it.

With the gap e, the translation and the rotation vector that lead from the pose reached to the one wanted, in base axes,
the step is dq = J^T (J J^T + d I)^-1 e. Where a combination of the joints is held, e and J have a row more.
"""

from __future__ import annotations

import casadi as ca

from nospill.compiled import codegen
from nospill.compiled.kept import kept
from nospill.core.frames import SX
from nospill.robots.kinematics.chain import ChainExpressions
from nospill.robots.kinematics.forward import SHARED, Kinematics

DAMPING = 1e-12
"""Added to J J^T (m^2 and rad^2): keeps the step finite at a singularity and costs no accuracy elsewhere, since the
residual decides.
"""

_OF_COLUMNS: codegen.Shared = dict.fromkeys(("gap", "prediction", "correction", "continuation"), codegen.LAST)
_NO_TURN = 1e-9
"""Sine of a rotation below which its axis is lost."""


@kept(maxsize=32)
def step_functions(arm: Kinematics, *, held: bool) -> codegen.Functions:
    """Functions of columns of an arm, with the pose (12,) as position and rotation row by row.

    Args:
        arm: the arm.
        held: whether a combination of the joints is held: `aim` is then its direction (n,), and the value that it shall
            have; an input without rows otherwise.

    Returns:
        gap: (q, pose, shared) -> gap (6,).
        prediction: (q, way (6,), aim, shared) -> shortest changes of the joints (n,) that lead along a way of the tool.
        correction: (q, pose, aim, shared) -> norm of the gap with what is held, and the step (n,).
        continuation: (q, way, pose, aim, shared) -> the changes of the joints (n, 3): `prediction`, and two corrections
            behind it.
    """
    made, _, _ = codegen.functions(
        "newton", (*arm.stood, held), lambda: (_build(arm, held), None), of_columns=_OF_COLUMNS
    )
    return made


def _build(arm: Kinematics, held: bool) -> codegen.Functions:
    q, shared = SX.sym("q", arm.n), SX.sym("shared", SHARED)
    pose, way, aim = SX.sym("pose", 12), SX.sym("way", 6), SX.sym("aim", arm.n + 1 if held else 0)
    # Each is built once and then called: expressions of a call are copied, which takes a quarter of the time.
    motion = arm.expressions(q, shared)
    rows = ca.vertcat(motion.jacobian, aim[: arm.n].T) if held else motion.jacobian
    missing = aim[arm.n :] - aim[: arm.n].T @ q if held else SX(0, 1)
    gap = ca.Function("gap", [q, pose, shared], [ca.densify(_pose_gap(pose, motion))], {"cse": True})
    across = ca.densify(_least_norm(rows, ca.vertcat(way, missing)))
    prediction = ca.Function("prediction", [q, way, aim, shared], [across], {"cse": True})

    between = gap(q, pose, shared)
    size = ca.norm_2(ca.vertcat(between, missing))
    correction = [size, prediction(q, between, aim, shared)]
    changes, at = [prediction(q, way, aim, shared)], q
    for _ in range(2):
        at = at + changes[-1]
        changes.append(prediction(at, gap(at, pose, shared), aim, shared))
    outputs = {
        "correction": ([q, pose, aim, shared], correction),
        "continuation": ([q, way, pose, aim, shared], changes),
    }
    return {"gap": gap, "prediction": prediction} | {
        name: ca.Function(name, inputs, [ca.densify(ca.vertcat(*parts))], {"cse": True})
        for name, (inputs, parts) in outputs.items()
    }


def _pose_gap(wanted: SX, motion: ChainExpressions) -> SX:
    """Translation and rotation vector (6, 1) from a motion's pose to a wanted one, base axes, m and rad."""
    turn = ca.reshape(wanted[3:], 3, 3).T @ motion.rotation.T
    sine = 0.5 * ca.vertcat(turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1])
    size, cosine = ca.norm_2(sine), 0.5 * (ca.trace(turn) - 1.0)
    lost = size < _NO_TURN
    vector = sine * ca.if_else(lost, 1.0, ca.atan2(size, cosine) / ca.fmax(size, _NO_TURN))
    # at half a turn the sine vanishes though the gap does not; the turn is 2 a a^T - I there, with a its axis
    outer = 0.5 * (turn + SX.eye(3))
    first = ca.logic_and(outer[0, 0] >= outer[1, 1], outer[0, 0] >= outer[2, 2])
    column = ca.if_else(first, outer[:, 0], ca.if_else(outer[1, 1] >= outer[2, 2], outer[:, 1], outer[:, 2]))
    half_turn = ca.pi * column / ca.sqrt(ca.fmax(ca.mmax(ca.diag(outer)), _NO_TURN))
    vector = ca.if_else(ca.logic_and(lost, cosine < 0.0), half_turn, vector)
    return ca.vertcat(wanted[:3] - motion.position, vector)


def _least_norm(jacobian: SX, gap: SX) -> SX:
    """The shortest changes of the joints (n, 1) whose first-order effect is a gap (k, 1)."""
    gram = ca.densify(jacobian @ jacobian.T + DAMPING * SX.eye(jacobian.size1()))
    diagonal, upper, order = ca.ldl(gram)
    return jacobian.T @ ca.ldl_solve(gap, diagonal, upper, order)
