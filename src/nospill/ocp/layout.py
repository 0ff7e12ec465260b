"""Which entry of a stage means what."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from nospill.frames import SX
from nospill.numbers import Structure
from nospill.sample import coordinate_count

Chain = tuple[SX, SX, SX]
"""Value, rate and acceleration."""


@dataclass(frozen=True, slots=True)
class Layout:
    """Sizes and slices of a stage's variables.

    State: chains (s, then theta_x and theta_y where free; each value, rate, acceleration), interval length, slosh
        displacements, slosh velocities. Control: jerks, slosh accelerations at both points, joint positions and
        speeds at the node.
    """

    chains: int
    coordinates: int
    joints: int

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
        start = self.joint_position.stop
        return slice(start, start + self.joints)

    @property
    def size(self) -> int:
        """Size of the stage vector."""
        return self.joint_speed.stop

    def chain(self, stage: SX, index: int) -> Chain:
        """One chain of a stage vector."""
        value, rate, acceleration = ca.vertsplit(stage[3 * index : 3 * index + 3])
        return value, rate, acceleration


def layout_of(structure: Structure) -> Layout:
    """The layout of a structure."""
    return Layout(
        chains=3 if structure.tilt_free else 1,
        coordinates=coordinate_count(structure),
        joints=len(structure.joints),
    )
