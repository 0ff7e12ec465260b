"""What late joints leave in the liquids after the end, as sums over a motion that are linear in the joints' speeds.

A joint that is late by d stands d q' behind. That moves the place of a liquid by -d J q' and turns it by -d J_w q'; in
apparent gravity G the liquid, of frequency w, answers to both until the end T, and swings on with the displacement and
the quadrature

    -d int (sin psi, cos psi) / w  (e + k (e . x) z) . [(J q')'' + G x J_w q'] dt,    psi(t) = int_t^T w dt,

e a direction in which it swings, carried back from the end: a liquid does not turn with its cup. Along the axis z a
jolt changes the stiffness k of a liquid that stands x beside it. By parts the derivatives go to what stands before
J q', and with the place, e, x, psi and G of one motion held, a sum over the nodes is left, of gains times speeds. Where
the sums of every joint vanish, no combination of late joints leaves anything.
"""

from __future__ import annotations

import numpy as np

from nospill.laws.scene_parameters import structure_of
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.scene import Scene
from nospill.transcription.layout import layout_of
from nospill.transcription.running_sums import SUMS
from nospill.transcription.stages import Stages

_COST = 0.3
"""s, of the square of a limit. It only has to be dear: what is left in the sums then is a hundredth of that."""
_LEAST_GRAVITY = 0.3
"""Of gravity: the least along the axis of a cup that its frequency is taken for."""


def late_sums(scene: Scene, motion: Stages) -> np.ndarray:
    """Gains (n, `SUMS`, N), s^0.5/(rad/s), of each joint's speed at the nodes: the squares of its sums are a cost, s.

    Only the slowest modes count: faster ones answer less, and to the jerks. Of liquids of several frequencies, for all
    together, the sums that are largest.

    Args:
        scene: of the problem, whose joints may be late.
        motion: on its grid, of which everything but the speeds is held.
    """
    assert scene.tracking is not None
    structure, h = structure_of(scene), motion.interval
    layout, swung = layout_of(structure), motion.table[:-1, layout_of(structure).displacement]
    q, qd = (motion.table[:-1, layout.joint_derivative(order)] for order in range(2))
    _, rotation, jacobian = kinematics(scene.robot).poses_and_jacobians(q, tool=scene.tray.tool)
    linear, turning = jacobian[:, :3].transpose(0, 2, 1), jacobian[:, 3:].transpose(0, 2, 1)  # (N, n, 3)
    gravity = np.gradient(np.einsum("kji,kj->ki", linear, qd), h, axis=0)
    gravity[:, 2] += scene.gravity
    axis = rotation[:, :, 2]
    pressing = np.maximum(np.einsum("ki,ki->k", axis, gravity) / scene.gravity, _LEAST_GRAVITY)
    later = h * np.arange(len(q), 0, -1)
    rows = [np.zeros((len(q), len(scene.robot.joints)))]
    for cargo, item, own in zip(scene.cargo, structure.objects, structure.slosh_slices, strict=True):
        if cargo.filling is None or cargo.filling.lid:
            continue
        limit = scene.motion.residual_fraction * cargo.filling.max_slosh_height
        for mode, part in zip(cargo.filling.modes.oscillators, item.oscillator_slices, strict=False):
            if mode.number > 1:
                continue
            sides = np.array([_side(cargo.yaw, name) for name in mode.directions])
            beside = np.einsum("kij,kj->ki", rotation, swung[:, own][:, part] @ sides)
            place = rotation @ np.append(cargo.position, cargo.seat + mode.height)
            moved = linear + np.cross(turning, place[:, None])
            leaning = np.cross(gravity[:, None], turning)
            frequency = mode.frequency * np.sqrt(pressing)
            phase = np.cumsum(h * frequency[::-1])[::-1]
            size = -h * abs(mode.surface_gain) / limit * np.exp(-mode.damping * mode.frequency * later) / frequency
            for side in sides:
                at_end = rotation[-1] @ side
                along = at_end - axis * (axis @ at_end)[:, None]
                along += mode.stiffness * axis * np.einsum("ki,ki->k", along, beside)[:, None]
                for answer in (np.sin(phase), np.cos(phase)):
                    weight = (size * answer)[:, None] * along
                    ahead = np.pad(weight, ((1, 1), (0, 0)), mode="reflect", reflect_type="odd")
                    bend = ahead[2:] - 2.0 * weight + ahead[:-2]
                    rows.append(np.einsum("ki,kji->kj", bend / h**2, moved) + np.einsum("ki,kji->kj", weight, leaning))
    of_joints = np.array(rows).transpose(2, 0, 1) * (np.sqrt(_COST) * scene.tracking.latest / 2.0)[:, None, None]
    _, size, shape = np.linalg.svd(of_joints, full_matrices=False)
    gains = np.zeros((of_joints.shape[0], SUMS, len(q)))
    most = min(SUMS, size.shape[1])
    gains[:, :most] = size[:, :most, None] * shape[:, :most]
    return gains


def _side(yaw: float, name: str) -> np.ndarray:
    """Direction "x" or "y" of a container that is turned on the tray, (3,) in tray axes."""
    turn = yaw + (np.pi / 2 if name == "y" else 0.0)
    return np.array([np.cos(turn), np.sin(turn), 0.0])
