"""Forward kinematics of an arm: one CasADi expression from its URDF, for laws and for samples (compiled).

The tool is the frame carried by the flange (here the tray, see `Tool`); by default it is the flange itself. All results
are in the robot's base frame.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import casadi as ca
import numpy as np

from nospill.compiled import codegen
from nospill.compiled.kept import kept
from nospill.core.batches import evaluate
from nospill.errors import ScenarioError
from nospill.robots.description.urdf import without_place
from nospill.robots.description.urdf_tree import read_tree
from nospill.robots.kinematics.bodies import BodyChain, chain_bodies
from nospill.robots.kinematics.chain import ChainExpressions, chain_expressions, with_base_at
from nospill.robots.tool import FLANGE, TOOL_NUMBERS, Tool

SHARED = TOOL_NUMBERS + 4
"""Numbers of a tool and of the place of a base."""
_OF_COLUMNS: codegen.Shared = dict.fromkeys(("pose", "jacobian", "pose_and_jacobian", "motion"), codegen.LAST)


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


class Kinematics:
    """Forward kinematics of one chain. Get it from `kinematics(robot)`, which keeps one per chain.

    Attributes:
        n: number of moving joints.
        coupled: whether a joint of the chain follows another one.
        stood: the chain with its base in the origin: URDF text, joints and tip.
    """

    def __init__(self, urdf: str, joints: tuple[str, ...], tip: str) -> None:
        """Read the URDF text.

        Args:
            urdf: URDF text without xacro.
            joints: names of the moving joints in the order of q; what follows them moves with them, every other joint
                stays at zero.
            tip: the flange link.

        Raises:
            ScenarioError: the text is no URDF, or a joint or the tip is not in it.
        """
        self.n = len(joints)
        self._chain = _chain(urdf, joints, tip)
        self.coupled = self._chain.coupled
        stood, self._place = without_place(urdf)
        self.stood = stood, joints, tip

    @cached_property
    def _symbolic(self) -> dict[str, Any]:
        """Functions of q and tool for expressions."""
        q, rate, change = (ca.SX.sym(name, self.n) for name in ("q", "qd", "qdd"))
        tool = ca.SX.sym("tool", TOOL_NUMBERS)
        motion = chain_expressions(self._chain, q, rate, change, tool=tool)
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
        """Functions of columns, of one flat column each: a call on m samples returns one column per sample."""
        found, _, _ = codegen.functions("arm", self.stood, self._build, of_columns=_OF_COLUMNS)
        return found

    def _build(self) -> tuple[codegen.Functions, None]:
        q, rate, change = (ca.SX.sym(name, self.n) for name in ("q", "qd", "qdd"))
        shared = ca.SX.sym("shared", SHARED)
        motion = self.expressions(q, shared, rate=rate, change=change)
        pose, jacobian = [motion.position, ca.vec(motion.rotation.T)], ca.vec(motion.jacobian.T)
        rates = [motion.velocity, motion.angular_velocity, motion.acceleration, motion.angular_acceleration]
        outputs = {
            "pose": ([q, shared], pose),
            "jacobian": ([q, shared], [jacobian]),
            "pose_and_jacobian": ([q, shared], [*pose, jacobian]),
            "motion": ([q, rate, change, shared], [*pose, *rates]),
        }
        assert outputs.keys() == _OF_COLUMNS.keys()
        return {name: _function(name, inputs, [ca.vertcat(*flat)]) for name, (inputs, flat) in outputs.items()}, None

    def expressions(
        self, q: ca.SX, shared: ca.SX, *, rate: ca.SX | None = None, change: ca.SX | None = None
    ) -> ChainExpressions:
        """The motion of a tool where the base stands, the place a number: the same for an arm wherever that is.

        Args:
            q: (n, 1) joint positions, rad.
            shared: (`SHARED`, 1) symbols for `shared_of` a tool.
            rate: (n, 1) joint speeds, rad/s; at rest when left out.
            change: (n, 1) joint accelerations, rad/s^2; likewise.
        """
        none, tool = ca.SX.zeros(self.n), shared[:TOOL_NUMBERS]
        rate, change = (none if given is None else given for given in (rate, change))
        return with_base_at(chain_expressions(_chain(*self.stood), q, rate, change, tool=tool), shared[TOOL_NUMBERS:])

    def shared_of(self, tool: Tool) -> np.ndarray:
        """What functions of samples have in common, (`SHARED`,): the tool, and the place of the base."""
        return np.concatenate([tool.row, self._place])

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
        flat = self._call("pose", q, tool=tool)
        return flat[:, :3], flat[:, 3:].reshape(-1, 3, 3)

    def jacobians(self, q: np.ndarray, *, tool: Tool = FLANGE) -> np.ndarray:
        """Return the geometric Jacobians (m, 6, n) of the tool at m samples, base axes.

        Rows 0 to 2 give the velocity of the tool's origin (m/s), rows 3 to 5 its angular velocity (rad/s), per joint
        speed (rad/s).

        Args:
            q: (m, n) joint positions, rad.
            tool: frame carried by the flange.
        """
        return self._call("jacobian", q, tool=tool).reshape(-1, 6, self.n)

    def poses_and_jacobians(self, q: np.ndarray, *, tool: Tool = FLANGE) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return `poses` and `jacobians` from one evaluation: (m, 3), (m, 3, 3), (m, 6, n)."""
        flat = self._call("pose_and_jacobian", q, tool=tool)
        return flat[:, :3], flat[:, 3:12].reshape(-1, 3, 3), flat[:, 12:].reshape(-1, 6, self.n)

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
        flat = self._call("motion", q, qd, qdd, tool=tool)
        return ToolMotions(
            position=flat[:, :3],
            rotation=flat[:, 3:12].reshape(-1, 3, 3),
            velocity=flat[:, 12:15],
            angular_velocity=flat[:, 15:18],
            acceleration=flat[:, 18:21],
            angular_acceleration=flat[:, 21:24],
        )

    def twist_change(self, q: ca.SX, qd: ca.SX, qdd: ca.SX, *, tool: ca.SX) -> ca.SX:
        """Return acceleration of the tool's origin, m/s^2, and angular acceleration, rad/s^2, (6, 1) for (n,) each."""
        change: ca.SX = self._symbolic["twist_change"](q, qd, qdd, tool)
        return change

    def _call(self, name: str, *samples: np.ndarray, tool: Tool) -> np.ndarray:
        """Evaluate on (m, n) arrays, one sample per row; the tool is the same for all."""
        count, function = len(samples[0]), self.sampled[name]
        for array in samples:
            if np.shape(array) != (count, self.n):
                raise ValueError(f"joint samples have shape {np.shape(array)}, expected ({count}, {self.n})")
        if count == 0:
            return np.zeros((0, function.size1_out(0)))
        columns = [np.asarray(array, dtype=float).T for array in samples]
        return np.ascontiguousarray(evaluate(function, columns, self.shared_of(tool)).T)


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


_kinematics = kept(maxsize=32)(Kinematics)


def _chain(urdf: str, joints: tuple[str, ...], tip: str) -> BodyChain:
    tree = read_tree(urdf)
    if tip not in tree.links:
        raise ScenarioError(
            f"robot description: tip {tip!r} is no link; there are {', '.join(sorted(tree.links)[:12])}"
        )
    chain = chain_bodies(tree, joints, tip)
    if {body.joint for body in chain.bodies} != set(range(len(joints))):
        known = ", ".join(joint.name for joint in tree.joints)
        raise ScenarioError(
            f"robot description: not all of the joints {', '.join(joints)} lead to {tip!r}; there are {known}"
        )
    return chain


def _function(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> Any:
    return ca.Function(name, inputs, [ca.densify(out) for out in outputs], {"cse": True})
