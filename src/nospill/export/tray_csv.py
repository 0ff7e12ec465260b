"""Poses of the tray for a receiver that solves the arm's inverse kinematics itself.

Columns t;x;y;z;qx;qy;qz;qw: s, m, and the quaternion that turns tray axes into those of the frame. Comments above them
state the frame and the joint positions of the first row, which say on which branch the receiver has to be. Reading
solves the inverse kinematics from there, row by row: the joints, not the poses alone, are what is judged, so that joint
limits are among the rows of the certificate. Arms with more than six joints are refused, because poses leave their
joints open.

Frames: "world", in which the path is written and gravity points along -z; "base_link", the root of the arm, the same
unless its base was moved; "base", the controller's own, where it is known (Universal Robots: base_link turned by
180 deg about z).
"""

from __future__ import annotations

import functools
from pathlib import Path

import numpy as np

from nospill.core.attitudes import matrices
from nospill.core.files import atomic_text
from nospill.errors import ModelError, PlanFolderError, ScenarioError
from nospill.export.base import Exporter, checked_samples, finite_row, numbers, require_joints, text_of
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.robots.description.urdf import base_pose
from nospill.robots.description.urdf_tree import rotation_of
from nospill.robots.joint_paths.search import solve_joints
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.scene import Scene

HEADER = "t;x;y;z;qx;qy;qz;qw"
MOST_JOINTS = 6
LARGEST_STEP = 0.5
"""rad; between two rows, no joint of a motion moves as far: the inverse kinematics has left its branch."""
LENGTH_TOLERANCE = 1e-9
"""By how much the length of a quaternion may differ from 1."""

WORLD, ROOT, CONTROLLER = FRAMES = ("world", "base_link", "base")
_FRAME = "# frame: "
_START = "# joints at the first row, rad: "


def _world_pose(scene: Scene, frame: str) -> tuple[np.ndarray, np.ndarray]:
    """Origin (3,), m, and axes (3, 3) of a frame in the world."""
    if frame == WORLD:
        return np.zeros(3), np.eye(3)
    origin, axes = base_pose(scene.robot.urdf)
    turn = scene.robot.controller_base_turn if frame == CONTROLLER else 0.0
    return origin, axes @ rotation_of((0.0, 0.0, turn or 0.0))


def _about(scene: Scene, frame: str) -> str:
    """The frame in words."""
    known = scene.robot.base_frame
    text = {
        WORLD: "in which the path is written and gravity points along -z; the arm's root stands in it",
        ROOT: "the root of the arm",
        CONTROLLER: "the controller's own base",
    }[frame]
    origin, axes = base_pose(scene.robot.urdf)
    moved = bool(np.any(origin) or np.any(axes != np.eye(3)))
    placed = (" moved" if moved else " unmoved") if frame == WORLD else ""
    return f"{frame}, {text}{placed}" + (f". The root is {known}" if known else "")


def _frame_reason(scene: Scene, frame: str) -> str | None:
    if frame == CONTROLLER and scene.robot.controller_base_turn is None:
        return f"the controller's base frame of robot {scene.robot.name!r} is not known; use --frame {ROOT} or {WORLD}"
    return None


def _reason_against(scene: Scene, rate: float) -> str | None:
    joints = len(scene.robot.joints)
    if joints > MOST_JOINTS:
        return f"poses of the tray do not say how an arm of {joints} joints reaches them; use a format of joints"
    return None


def _write(samples: JointSamples, scene: Scene, path: Path, frame: str) -> None:
    reason = _reason_against(scene, samples.rate) or _frame_reason(scene, frame)
    if reason is not None:
        raise ScenarioError(reason)
    from scipy.spatial.transform import Rotation  # slow to load

    tray, robot = scene.tray, scene.robot
    position, rotation = kinematics(robot).poses(samples.position, tool=tray.tool)
    origin, axes = _world_pose(scene, frame)
    position, rotation = (position - origin) @ axes, axes.T @ rotation
    quaternion = Rotation.from_matrix(rotation).as_quat()
    # q and -q are one attitude: a receiver that interpolates wants neighbours on the same side.
    turned = np.sum(quaternion[1:] * quaternion[:-1], axis=1) < 0.0
    quaternion[1:][np.cumsum(turned) % 2 == 1] *= -1.0
    start = "; ".join(
        f"{name} = {numbers(value)}" for name, value in zip(robot.joints, samples.position[:1].T, strict=True)
    )
    lines = [
        f"# tray of {scene.name}, written by nospill for {robot.name}: t in s, origin in m, quaternion x, y, z, w",
        f"{_FRAME}{_about(scene, frame)}",
        f"{_START}{start}",
        HEADER,
        *(numbers(row, ";") for row in np.column_stack([samples.t, position, quaternion])),
    ]
    atomic_text(path, "\n".join([*lines, ""]))


def _read(path: Path, scene: Scene) -> JointSamples:
    reason = _reason_against(scene, 0.0)
    if reason is not None:
        raise PlanFolderError(f"{path}: {reason}")
    lines = text_of(path).rstrip().splitlines()
    start, frame = _start(lines, scene, path), _frame(lines, scene, path)
    if HEADER not in lines:
        raise PlanFolderError(f"{path}: not a file of tray poses: the line {HEADER} is missing")
    first = lines.index(HEADER) + 1
    columns = HEADER.count(";") + 1
    body = enumerate(lines[first:], first + 1)
    rows = [finite_row(line.split(";"), columns, f"{path}, line {number}") for number, line in body]
    table = np.array(rows).reshape(-1, columns)
    lengths = np.linalg.norm(table[:, 4:], axis=1)
    wrong = np.flatnonzero(np.abs(lengths - 1.0) > LENGTH_TOLERANCE)
    if len(wrong):
        row = int(wrong[0])
        raise PlanFolderError(
            f"{path}, line {first + row + 1}: the quaternion has length {lengths[row]:.9g}, 1 is needed"
        )
    origin, axes = _world_pose(scene, frame)
    joints = _solve_joints(origin + table[:, 1:4] @ axes.T, axes @ matrices(table[:, 4:]), start, scene, path)
    return checked_samples(JointSamples(table[:, 0], joints), path)


def _frame(lines: list[str], scene: Scene, path: Path) -> str:
    """The frame that the comment states; the world's where it states none, as in older files."""
    stated = [line.removeprefix(_FRAME).partition(",")[0] for line in lines if line.startswith(_FRAME)]
    frame = stated[0] if stated else WORLD
    if frame not in FRAMES or _frame_reason(scene, frame) is not None:
        raise PlanFolderError(f"{path}: frame {frame[:40]!r} is not one of those known for this arm")
    return frame


def _start(lines: list[str], scene: Scene, path: Path) -> np.ndarray:
    """Joint positions that the comment states, (n,)."""
    stated = [line.removeprefix(_START).split("; ") for line in lines if line.startswith(_START)]
    pairs = [part.partition(" = ") for part in stated[0]] if stated else []
    require_joints([name for name, _, _ in pairs] or None, scene, path)
    return np.array(finite_row([value for _, _, value in pairs], len(pairs), f"{path}, joints at the first row"))


def _solve_joints(
    positions: np.ndarray, rotations: np.ndarray, start: np.ndarray, scene: Scene, path: Path
) -> np.ndarray:
    """Joints (m, n) that carry the tray through the poses, each solved from the one before."""
    tray = scene.tray
    joints = np.empty((len(positions), len(start)))
    guess, before = start, start
    for row in range(len(positions)):
        try:
            joints[row] = solve_joints(
                scene.robot,
                positions[row : row + 1],
                rotations[row : row + 1],
                guess[None],
                tool=tray.tool,
            )
        except ModelError as error:
            raise PlanFolderError(f"{path}, row {row + 1}: the arm does not reach this pose of the tray") from error
        if np.max(np.abs(joints[row] - before)) > LARGEST_STEP:
            raise PlanFolderError(f"{path}, row {row + 1}: the arm would have to jump to this pose of the tray")
        guess, before = 2.0 * joints[row] - before, joints[row]
    return joints


def tray_csv_exporter(frame: str = WORLD) -> Exporter:
    """The poses in a frame.

    Raises:
        ScenarioError: there is no such frame.
    """
    if frame not in FRAMES:
        raise ScenarioError(f"tray-csv: no frame {frame!r}; there are {', '.join(FRAMES)}")
    return Exporter(
        name="tray-csv",
        suffixes=(".tray.csv",),
        title="poses of the tray: t;x;y;z;qx;qy;qz;qw in s and m, in a frame of choice (--frame)",
        receiver="a controller with inverse kinematics: joints for each pose, then under position control "
        "(quintic spline)",
        interpolation=QUINTIC_SPLINE,
        reason_against=lambda scene, rate: _reason_against(scene, rate) or _frame_reason(scene, frame),
        write=functools.partial(_write, frame=frame),
        read=_read,
        options=("frame",),
        with_options=tray_csv_exporter,
    )


TRAY_CSV = tray_csv_exporter()
"""Poses of the tray."""
