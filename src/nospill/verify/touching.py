"""What touches an obstacle, found by MuJoCo: its own kinematics of the arm's URDF chain, its own collision detection.

The arm, the tray and what stands on it are bodies on hinges, the obstacles stand still; joint samples are set one after
the other, a millisecond apart, and the engine says which geometries overlap. Nothing of `nospill.collisions` is used.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from nospill.core.shapes import Shape, polyhedron
from nospill.robots.capsules import placed_capsules
from nospill.robots.kinematics.frames import arm_chain
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.scene.tray import TRAY_THICKNESS
from nospill.verify.engine import mujoco, quiet

_MOVES, _STANDS = 'contype="1" conaffinity="0"', 'contype="0" conaffinity="1"'
_EVERYWHERE = 'size="50 50 1"'
_ROUND = 32


@dataclass(frozen=True, slots=True)
class Touch:
    """Two bodies that overlap.

    Attributes:
        body: link, "tray" or object.
        obstacle: what it runs into.
        depth: greatest, m.
        at_s: when that is, s on the clock of the joints.
        from_s: when they overlap first.
    """

    body: str
    obstacle: str
    depth: float
    at_s: float
    from_s: float


def touches(scene: Scene, t: np.ndarray, q: np.ndarray) -> tuple[Touch, ...]:
    """What touches an obstacle at some instants; nothing where the scene has none.

    Args:
        scene: with the obstacles.
        t: (m,) s.
        q: (m, n) joint positions, rad.

    Raises:
        MissingExtraError: MuJoCo is not installed.
    """
    if not scene.obstacles:
        return ()
    engine = mujoco()
    with quiet(engine):
        model = engine.MjModel.from_xml_string(_text(scene))
        data = engine.MjData(model)
        names = [model.geom(index).name.partition(":")[0] for index in range(model.ngeom)]
        moving = model.geom_contype == 1
        found: dict[tuple[str, str], Touch] = {}
        for now, joints in zip(t, arm_chain(scene.robot).angles(q), strict=True):
            data.qpos[:] = joints
            engine.mj_fwdPosition(model, data)
            for index in range(data.ncon):
                contact = data.contact[index]
                if contact.dist >= 0.0:
                    continue
                first, second = sorted((int(geom) for geom in contact.geom), key=lambda geom: not moving[geom])
                key = names[first], names[second]
                known = found.get(key)
                if known is None or -contact.dist > known.depth:
                    began = float(now) if known is None else known.from_s
                    found[key] = Touch(*key, depth=-float(contact.dist), at_s=float(now), from_s=began)
    return tuple(sorted(found.values(), key=lambda touch: touch.from_s))


def _text(scene: Scene) -> str:
    """The arm as a chain of hinges, with its load on the last, and the obstacles."""
    robot = scene.robot
    chain = arm_chain(robot)
    capsules = placed_capsules(robot)
    assets: list[str] = []
    inner = _load(scene, chain.flange_position, chain.flange_rotation, assets)
    for number in range(len(chain.bodies), 0, -1):
        body = chain.bodies[number - 1]
        geometry = "".join(
            f'<geom name="{item.link}:{index}" {_MOVES} {_capsule(item.ends, item.radius)}/>'
            for index, item in enumerate(capsules)
            if item.joint == number
        )
        inner = (
            f'<body {_pose(body.position, body.rotation)}><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>'
            f'<joint type="hinge" axis="0 0 1"/>{geometry}{inner}</body>'
        )
    around = "".join(
        f'<geom name="{item.name}:0" {_STANDS} {_pose(item.position, item.rotation)} '
        f"{_geometry(item.shape, f'obstacle-{item.name}', assets)}/>"
        for item in scene.obstacles
    )
    return (
        f'<mujoco><compiler angle="radian"/><option gravity="0 0 0"/><size memory="64M"/>'
        f"<asset>{''.join(assets)}</asset><worldbody>{around}{inner}</worldbody></mujoco>"
    )


def _load(scene: Scene, flange: np.ndarray, axes: np.ndarray, assets: list[str]) -> str:
    """Tray and objects on a body that is the tray frame."""
    tool = scene.tray.tool
    length, width = scene.tray.size / 2
    board = (
        f'<geom name="tray:0" {_MOVES} type="box" size="{length:.17g} {width:.17g} {TRAY_THICKNESS / 2:.17g}" '
        f'pos="0 0 {-TRAY_THICKNESS / 2:.17g}"/>'
    )
    objects = "".join(
        f'<geom name="{item.name}:0" {_MOVES} type="mesh" mesh="cargo-{item.name}" '
        f"{_pose(item.place, Rotation.from_euler('z', item.yaw).as_matrix())}/>"
        for item in scene.cargo
    )
    assets += [_outside(item) for item in scene.cargo]
    return f"<body {_pose(flange + axes @ tool.position, axes @ tool.rotation)}>{board}{objects}</body>"


def _outside(item: Cargo) -> str:
    """The outside of an object as a mesh, of which the engine takes the hull."""
    outline = item.container.outline
    corners = np.concatenate(
        [np.column_stack([share * outline, np.full(len(outline), at)]) for share, at in item.container.outside]
    )
    return _mesh(f"cargo-{item.name}", corners)


def _mesh(name: str, corners: np.ndarray) -> str:
    # the frame that the corners are given in is kept, not the engine's principal axes: geoms refer to it
    numbers = " ".join(f"{value:.17g}" for value in corners.ravel())
    return f'<mesh name="{name}" vertex="{numbers}"/>'


def _geometry(shape: Shape, name: str, assets: list[str]) -> str:
    if shape.kind == "box":
        return f'type="box" size="{" ".join(f"{side / 2:.17g}" for side in shape.sizes)}"'
    if shape.kind == "sphere":
        return f'type="sphere" size="{shape.sizes[0]:.17g}"'
    if shape.kind in ("cylinder", "capsule"):
        radius, height = shape.sizes
        half = height / 2 - (radius if shape.kind == "capsule" else 0.0)
        if half <= 0.0:
            return f'type="sphere" size="{radius:.17g}"'
        return f'type="{shape.kind}" size="{radius:.17g} {half:.17g}"'
    if shape.kind == "halfspace":
        return f'type="plane" {_EVERYWHERE}'
    assets.append(_mesh(name, polyhedron(shape, _ROUND)))
    return f'type="mesh" mesh="{name}"'


def _capsule(ends: np.ndarray, radius: float) -> str:
    if np.linalg.norm(ends[1] - ends[0]) < 1e-6:
        return f'type="sphere" size="{radius:.17g}" pos="{_row(ends[0])}"'
    return f'type="capsule" size="{radius:.17g}" fromto="{_row(ends[0])} {_row(ends[1])}"'


def _pose(position: np.ndarray, rotation: np.ndarray) -> str:
    x, y, z, w = Rotation.from_matrix(rotation).as_quat()
    return f'pos="{_row(position)}" quat="{_row(np.array([w, x, y, z]))}"'


def _row(values: np.ndarray) -> str:
    return " ".join(f"{value:.17g}" for value in values)
