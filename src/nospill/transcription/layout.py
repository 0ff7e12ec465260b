"""Which entry of a stage means what."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from nospill.core.frames import SX
from nospill.laws.sample import coordinate_count
from nospill.laws.structure import Freedom, Structure

IntegratorChain = tuple[SX, SX, SX]
"""Value, rate and acceleration."""


@dataclass(frozen=True, slots=True)
class Layout:
    """Sizes and slices of a stage's variables.

    State: chains (s; where free, theta_x and theta_y, the offset from the path along the base's x, y and z, the yaw
    relative to the path's; then the self-motion of a seven-joint arm; each value, rate, acceleration), interval length,
    slosh displacements, slosh velocities.
    Control: jerks, slosh accelerations at both points, joint positions and their time derivatives at the node, and
    last, where the arm is kept regular, the determinant of its Jacobian.

    Attributes:
        freedom: of the tray; says which chains there are.
        redundant: 1 with seven joints, 0 with six.
        coordinates: number of slosh coordinates.
        joints: number of joints.
        orders: of the joints' derivatives that are variables: 1 for positions and speeds, 2 with accelerations, 3 with
            jerks.
        regular: 1 where the determinant is a variable, 0 otherwise.
    """

    freedom: Freedom
    redundant: int
    coordinates: int
    joints: int
    orders: int
    regular: int = 0

    @property
    def chains(self) -> int:
        """How many jerk-driven chains there are: first those that move the tray."""
        return self.freedom.chains + self.redundant

    @property
    def interval(self) -> int:
        """Index of the interval length in the state."""
        return 3 * self.chains

    @property
    def displacement(self) -> slice:
        """Slosh displacements in the state."""
        start = self.interval + 1
        return slice(start, start + self.coordinates)

    @property
    def velocity(self) -> slice:
        """Slosh velocities in the state."""
        start = self.displacement.stop
        return slice(start, start + self.coordinates)

    @property
    def states(self) -> int:
        """Size of the state."""
        return self.interval + 1 + 2 * self.coordinates

    @property
    def jerks(self) -> slice:
        """Jerks in the stage vector (state, then control)."""
        return slice(self.states, self.states + self.chains)

    def acceleration(self, point: int) -> slice:
        """Slosh accelerations at collocation point 0 or 1 in the stage vector."""
        start = self.jerks.stop + point * self.coordinates
        return slice(start, start + self.coordinates)

    @property
    def joint_position(self) -> slice:
        """Joint positions in the stage vector."""
        start = self.acceleration(1).stop
        return slice(start, start + self.joints)

    @property
    def joint_speed(self) -> slice:
        """Joint speeds in the stage vector."""
        return self.joint_derivative(1)

    def joint_derivative(self, order: int) -> slice:
        """The joints' time derivative of order 0 to `orders` in the stage vector."""
        start = self.joint_position.start + order * self.joints
        return slice(start, start + self.joints)

    @property
    def size(self) -> int:
        """Size of the stage vector."""
        return self.joint_derivative(self.orders).stop + self.regular

    def chain(self, stage: SX, index: int) -> IntegratorChain:
        """One chain of a stage vector."""
        value, rate, acceleration = ca.vertsplit(stage[3 * index : 3 * index + 3])
        return value, rate, acceleration


def layout_of(structure: Structure) -> Layout:
    """The layout of a structure."""
    lifted = {"acceleration": 2, "torque": 2, "jerk": 3}
    return Layout(
        freedom=structure.freedom,
        redundant=int(structure.redundant),
        coordinates=coordinate_count(structure),
        joints=len(structure.joints),
        orders=3 if structure.lagged else max((lifted[name] for name in structure.joint_limits), default=1),
        regular=int(structure.regular),
    )
