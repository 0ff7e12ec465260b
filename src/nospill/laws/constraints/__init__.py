"""The constraints, as one visible table: a new one is a file here and a line below."""

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import cast

from nospill.laws.constraints.apparent_gravity import ApparentGravity
from nospill.laws.constraints.base import Constraint as Constraint
from nospill.laws.constraints.base import EvaluationPoint, Role
from nospill.laws.constraints.clearance import Clearance
from nospill.laws.constraints.corridor import Corridor
from nospill.laws.constraints.jerk import OffsetJerk, PathJerk, TiltJerk, YawJerk
from nospill.laws.constraints.joint_acceleration import JointAcceleration
from nospill.laws.constraints.joint_jerk import JointJerk
from nospill.laws.constraints.joint_position import JointPosition
from nospill.laws.constraints.joint_speed import JointSpeed
from nospill.laws.constraints.joint_torque import JointTorque
from nospill.laws.constraints.lift import Lift
from nospill.laws.constraints.residual_height import EndDisplacement, ResidualHeight
from nospill.laws.constraints.slip import Slip
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.constraints.supplied import with_supplied
from nospill.laws.constraints.tilt import Tilt
from nospill.laws.constraints.tip import Tip
from nospill.laws.constraints.tray_rates import TrayAcceleration, TraySpeed
from nospill.laws.constraints.trough import Trough
from nospill.laws.constraints.twist import Twist
from nospill.laws.constraints.via import PassedPlace
from nospill.laws.structure import Structure
from nospill.scene.scene import Scene

CONSTRAINTS: tuple[Constraint, ...] = (
    SloshHeight(),
    Trough(),
    ResidualHeight(),
    EndDisplacement(),
    ApparentGravity(),
    Lift(),
    Slip(),
    Tip(),
    Twist(),
    JointPosition(),
    JointSpeed(),
    JointAcceleration(),
    JointJerk(),
    JointTorque(),
    Tilt(),
    TraySpeed(),
    TrayAcceleration(),
    PathJerk(),
    TiltJerk(),
    Corridor(),
    OffsetJerk(),
    YawJerk(),
    PassedPlace(),
)
"""Every constraint that the optimiser and the judge evaluate by its expressions, in the order of the certificate."""

OF_BODIES: tuple[Constraint, ...] = (Clearance(),)
"""Constraints on pairs of bodies, which optimiser and judge evaluate in ways of their own; their rows come after the
others."""

BY_NAME: Mapping[str, Constraint] = MappingProxyType({item.name: item for item in (*CONSTRAINTS, *OF_BODIES)})
"""All of the table by name, as rows and reasons carry it."""


def constraints_of(whole: Scene | Structure) -> tuple[Constraint, ...]:
    """Every constraint of a scene, or of a structure: those of the table, then those given from Python."""
    return (*CONSTRAINTS, *cast(tuple[Constraint, ...], whole.constraints))


def by_name(scene: Scene) -> Mapping[str, Constraint]:
    """The same of a scene by name, those of bodies among them."""
    given = cast(tuple[Constraint, ...], scene.constraints)
    return {**BY_NAME, **{item.name: item for item in given}} if given else BY_NAME


def constrained(scene: Scene, constraints: Iterable[object] | None) -> Scene:
    """The scene with constraints of the user's own classes in the place of those it has; None leaves it as it is.

    Raises:
        ScenarioError: one of them is no constraint, has the name of another or is about nothing in the scene.
    """
    return with_supplied(scene, constraints, BY_NAME)


LIQUID_NAMES = frozenset(item.name for item in CONSTRAINTS if item.role is Role.LIQUID)
"""Names of those on liquids."""

OBJECT_NAMES = LIQUID_NAMES | {item.name for item in CONSTRAINTS if item.role is Role.CONTACT}
"""Names of those on objects."""

DEVIATION_JERK_NAMES = frozenset({TiltJerk.name, OffsetJerk.name, YawJerk.name})
"""Names of those on the jerks by which the tray deviates from its path."""

END_NAMES = frozenset(item.name for item in CONSTRAINTS if item.evaluated_at is EvaluationPoint.END)
"""Names of those on the final state."""
