"""An arm of your own, from its URDF: two cups on the teaching arm beside this script."""

from pathlib import Path

import nospill as ns

urdf = Path(__file__).with_name("teaching-arm.urdf")
scene = ns.load("pp-two-cups").changed(
    {
        "robot": ns.Robot(urdf=str(urdf), tip="flange", limits=ns.JointLimits(acceleration="15 rad/s^2")),
        "path": ns.LinePath(start=["0.55 m", "-0.3 m", "0.7 m"], end=["0.55 m", "0.3 m", "0.9 m"]),
    }
)

plan = ns.plan(scene)
print(plan.message)
for warning in plan.warnings:
    print(f"warning: {warning.text}")
print(f"largest joint speeds, rad/s: {abs(plan.trajectory.joint_speed).max(axis=0).round(2)}")
plan.plot("path").savefig("own_arm.png", dpi=100)
