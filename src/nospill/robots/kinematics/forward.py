"""Forward kinematics of an arm: one CasADi expression from its URDF, for laws and for samples (compiled).

The tool is the frame carried by the flange (here the tray, see `Tool`); by default it is the flange itself. All results
are in the robot's base frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, Protocol

import casadi as ca
import numpy as np

from nospill.compiled import codegen
from nospill.core.batches import evaluate
from nospill.errors import ScenarioError
from nospill.robots.description.urdf import without_place
from nospill.robots.description.urdf_tree import read_tree, rotation_of
from nospill.robots.kinematics.bodies import BodyChain, chain_bodies
from nospill.robots.kinematics.chain import ChainExpressions, chain_expressions
from nospill.robots.tool import FLANGE, Tool

_OF_COLUMNS = dict.fromkeys(("pose", "jacobian", "pose_and_jacobian", "motion"), codegen.LAST)


@dataclass(frozen=True, slots=True)
class ToolMotions:
    """Motion of the tool frame at m samples, in base axes.

    Attributes:
        position: (m, 3) origin, m.
        rotation: (m, 3, 3), tool axes to base axes.
        velocity, acceleration: (m, 3) first and second time derivative of the origin (classical, not spatial),
            m/s and m/s^2.
        angular_velocity, angular_acceleration: (m, 3), rad/s and rad/s^2.
    """

    position: np.ndarray
    rotation: np.ndarray
    velocity: np.ndarray
    acceleration: np.ndarray
    angular_velocity: np.ndarray
    angular_acceleration: np.ndarray

    def seen_from(self, place: np.ndarray) -> ToolMotions:
        """The same motion in axes in which the base stands at a place: (4,) x, y, z in m and yaw in rad."""
        if not np.any(place):
            return self
        turn = about_vertical(place)
        return ToolMotions(
            position=self.position @ turn.T + place[:3],
            rotation=turn @ self.rotation,
            velocity=self.velocity @ turn.T,
            acceleration=self.acceleration @ turn.T,
            angular_velocity=self.angular_velocity @ turn.T,
            angular_acceleration=self.angular_acceleration @ turn.T,
        )


def about_vertical(place: np.ndarray) -> np.ndarray:
    """The turn (3, 3) by the yaw of a place (4,) x, y, z, yaw."""
    return rotation_of((0.0, 0.0, float(place[3])))


class Kinematics:
    """Forward kinematics of one chain. Get it from `kinematics(robot)`, which keeps one per chain.

    Attributes:
        n: number of moving joints.
    """

    def __init__(self, urdf: str, joints: tuple[str, ...], tip: str) -> None:
        """Read the URDF text.

        Args:
            urdf: URDF text without xacro.
            joints: names of the moving joints in the order of q; every other joint stays at zero.
            tip: the flange link.

        Raises:
            ScenarioError: the text is no URDF, or a joint or the tip is not in it.
        """
        self.n = len(joints)
        self._chain = urdf, joints, tip
        _chain(*self._chain)
        stood, self._place = without_place(urdf)
        self._stood = stood, joints, tip

    @cached_property
    def _symbolic(self) -> dict[str, Any]:
        """Functions of q and tool for expressions."""
        (q, rate, change, tool), motion = self._motion(*self._chain)
        velocities = [motion.velocity, motion.angular_velocity]
        accelerations = [motion.acceleration, motion.angular_acceleration]
        return {
            "pose": _function("pose", [q, tool], [motion.position, motion.rotation]),
            "jacobian": _function("jacobian", [q, tool], [motion.jacobian]),
            "twist": _function("twist", [q, rate, tool], velocities),
            "twist_change": _function("twist_change", [q, rate, change, tool], [ca.vertcat(*accelerations)]),
        }

    @cached_property
    def sampled(self) -> codegen.Functions:
        """Functions of columns, of one flat column each: a call on m samples returns one column per sample.

        The base stands in the origin, so that an arm finds them compiled wherever it stands.
        """
        found, _, _ = codegen.functions(
            "arm", self._stood, self._build, of_columns=dict.fromkeys(_OF_COLUMNS, codegen.LAST)
        )
        return found

    def _build(self) -> tuple[codegen.Functions, None]:
        (q, rate, rate_change, tool), motion = self._motion(*self._stood)
        pose, jacobian = [motion.position, ca.vec(motion.rotation.T)], ca.vec(motion.jacobian.T)
        rates = [motion.velocity, motion.angular_velocity, motion.acceleration, motion.angular_acceleration]
        outputs = {
            "pose": ([q, tool], pose),
            "jacobian": ([q, tool], [jacobian]),
            "pose_and_jacobian": ([q, tool], [*pose, jacobian]),
            "motion": ([q, rate, rate_change, tool], [*pose, *rates]),
        }
        assert outputs.keys() == _OF_COLUMNS.keys()
        return {name: _function(name, inputs, [ca.vertcat(*flat)]) for name, (inputs, flat) in outputs.items()}, None

    def _motion(
        self, urdf: str, joints: tuple[str, ...], tip: str
    ) -> tuple[tuple[ca.SX, ca.SX, ca.SX, ca.SX], ChainExpressions]:
        """Symbols of q, its two derivatives and the tool, and the expressions of them."""
        q, rate, change = (ca.SX.sym(name, self.n) for name in ("q", "qd", "qdd"))
        tool = ca.SX.sym("tool", 4)
        return (q, rate, change, tool), chain_expressions(_chain(urdf, joints, tip), q, rate, change, tool=tool)

    def pose(self, q: ca.SX, *, tool: ca.SX | np.ndarray = FLANGE.row) -> tuple[ca.SX, ca.SX]:
        """Return the tool's position (3,), m, and rotation (3, 3), tool to base axes, as expressions of q (n,), rad."""
        position, rotation = self._symbolic["pose"](q, tool)
        return position, rotation

    def jacobian(self, q: ca.SX) -> ca.SX:
        """Return the geometric Jacobian (6, n) of the flange in base axes, linear rows first, as an expression."""
        return self._symbolic["jacobian"](q, FLANGE.row)

    def twist(self, q: ca.SX, qd: ca.SX, *, tool: ca.SX | np.ndarray = FLANGE.row) -> tuple[ca.SX, ca.SX]:
        """Return velocity (3,) of the tool's origin, m/s, and angular velocity (3,), rad/s, for q, qd (n,)."""
        velocity, angular_velocity = self._symbolic["twist"](q, qd, tool)
        return velocity, angular_velocity

    def poses(self, q: np.ndarray, *, tool: Tool = FLANGE) -> tuple[np.ndarray, np.ndarray]:
        """Return positions (m, 3), m, and rotations (m, 3, 3) of the tool at m samples.

        Args:
            q: (m, n) joint positions, rad.
            tool: frame carried by the flange.
        """
        flat = self._call("pose", q, tool=tool.row)
        return self._placed(flat[:, :3], flat[:, 3:].reshape(-1, 3, 3))

    def jacobians(self, q: np.ndarray, *, tool: Tool = FLANGE) -> np.ndarray:
        """Return the geometric Jacobians (m, 6, n) of the tool at m samples, base axes.

        Rows 0 to 2 give the velocity of the tool's origin (m/s), rows 3 to 5 its angular velocity (rad/s), per joint
        speed (rad/s).

        Args:
            q: (m, n) joint positions, rad.
            tool: frame carried by the flange.
        """
        return self._turned(self._call("jacobian", q, tool=tool.row))

    def poses_and_jacobians(self, q: np.ndarray, *, tool: Tool = FLANGE) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return `poses` and `jacobians` from one evaluation: (m, 3), (m, 3, 3), (m, 6, n)."""
        flat = self._call("pose_and_jacobian", q, tool=tool.row)
        return *self._placed(flat[:, :3], flat[:, 3:12].reshape(-1, 3, 3)), self._turned(flat[:, 12:])

    def motions(
        self,
        q: np.ndarray,
        qd: np.ndarray,
        qdd: np.ndarray,
        *,
        tool: Tool = FLANGE,
    ) -> ToolMotions:
        """Return pose, velocity and acceleration of the tool at m samples.

        Args:
            q: (m, n) joint positions, rad.
            qd: (m, n) joint speeds, rad/s.
            qdd: (m, n) joint accelerations, rad/s^2.
            tool: frame carried by the flange.
        """
        flat = self._call("motion", q, qd, qdd, tool=tool.row)
        return ToolMotions(
            position=flat[:, :3],
            rotation=flat[:, 3:12].reshape(-1, 3, 3),
            velocity=flat[:, 12:15],
            angular_velocity=flat[:, 15:18],
            acceleration=flat[:, 18:21],
            angular_acceleration=flat[:, 21:24],
        ).seen_from(self._place)

    def twist_change(self, q: ca.SX, qd: ca.SX, qdd: ca.SX, *, tool: ca.SX) -> ca.SX:
        """Return acceleration of the tool's origin, m/s^2, and angular acceleration, rad/s^2, (6, 1) for (n,) each."""
        change: ca.SX = self._symbolic["twist_change"](q, qd, qdd, tool)
        return change

    def _placed(self, position: np.ndarray, rotation: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions (m, 3) and rotations (m, 3, 3) where the base stands."""
        if not np.any(self._place):
            return position, rotation
        turn = about_vertical(self._place)
        return position @ turn.T + self._place[:3], turn @ rotation

    def _turned(self, flat: np.ndarray) -> np.ndarray:
        """Jacobians (m, 6, n), from rows (m, 6 n), where the base stands."""
        jacobians = flat.reshape(-1, 6, self.n)
        if not self._place[3]:
            return jacobians
        return (about_vertical(self._place) @ jacobians.reshape(-1, 2, 3, self.n)).reshape(-1, 6, self.n)

    def _call(self, name: str, *samples: np.ndarray, tool: np.ndarray) -> np.ndarray:
        """Evaluate on (m, n) arrays, one sample per row; the tool (x, y, z, yaw) is the same for all."""
        count, function = len(samples[0]), self.sampled[name]
        for array in samples:
            if np.shape(array) != (count, self.n):
                raise ValueError(f"joint samples have shape {np.shape(array)}, expected ({count}, {self.n})")
        if count == 0:
            return np.zeros((0, function.size1_out(0)))
        columns = [np.asarray(array, dtype=float).T for array in samples]
        return np.ascontiguousarray(evaluate(function, columns, tool).T)


class ArmChain(Protocol):
    """What forward kinematics needs to know of an arm; a `Robot` is one."""

    @property
    def urdf(self) -> str:
        """URDF text without xacro."""
        ...

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the moving joints, base to tip."""
        ...

    @property
    def tip(self) -> str:
        """The flange link."""
        ...


def kinematics(robot: ArmChain) -> Kinematics:
    """Return the forward kinematics of an arm; built once per chain.

    Raises:
        ScenarioError: the URDF cannot be read, or a joint or the tip is not in it.
    """
    return _kinematics(robot.urdf, robot.joints, robot.tip)


_kinematics = lru_cache(maxsize=32)(Kinematics)


def _chain(urdf: str, joints: tuple[str, ...], tip: str) -> BodyChain:
    tree = read_tree(urdf)
    if tip not in tree.links:
        raise ScenarioError(
            f"robot description: tip {tip!r} is no link; there are {', '.join(sorted(tree.links)[:12])}"
        )
    chain = chain_bodies(tree, joints, tip)
    if len(chain.bodies) != len(joints):
        known = ", ".join(joint.name for joint in tree.joints)
        raise ScenarioError(
            f"robot description: not all of the joints {', '.join(joints)} lead to {tip!r}; there are {known}"
        )
    return chain


def _function(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> Any:
    return ca.Function(name, inputs, [ca.densify(out) for out in outputs], {"cse": True})
