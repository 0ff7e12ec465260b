"""The constraints, as one visible table: a new one is a file here and a line below."""

from nospill.constraints.apparent_gravity import ApparentGravity
from nospill.constraints.base import Constraint as Constraint
from nospill.constraints.jerk import PathJerk, TiltJerk
from nospill.constraints.joint_acceleration import JointAcceleration
from nospill.constraints.joint_jerk import JointJerk
from nospill.constraints.joint_position import JointPosition
from nospill.constraints.joint_speed import JointSpeed
from nospill.constraints.joint_torque import JointTorque
from nospill.constraints.lift import Lift
from nospill.constraints.residual_height import EndDisplacement, ResidualHeight
from nospill.constraints.slip import Slip
from nospill.constraints.slosh_height import SloshHeight
from nospill.constraints.tilt import Tilt
from nospill.constraints.tip import Tip
from nospill.constraints.twist import Twist

CONSTRAINTS: tuple[Constraint, ...] = (
    SloshHeight(),
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
    PathJerk(),
    TiltJerk(),
)
"""Every constraint, in the order of the certificate."""
