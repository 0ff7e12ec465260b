"""A ROS 2 node between a planner and its controller: judges every JointTrajectory on a topic, and times it anew.

    python judge_and_retime_node.py SCENARIO --listen /planned --publish /arm_controller/joint_trajectory

A trajectory that is certified as it is goes on unchanged; of another one the path is kept and timed anew, as fast as
the scenario allows; where no timing is certified, nothing is published and the reason is logged. The first plan
compiles what it needs, which takes seconds. It moves no arm by itself: who listens on the published topic does.
"""

# pyright: reportMissingImports=false

from __future__ import annotations

import argparse
from contextlib import suppress

import numpy as np
import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

import nospill as ns

RATE = 125.0
"""Points a second of what is published; each has position, speed and acceleration."""


def arrays_of(message: JointTrajectory) -> dict[str, np.ndarray]:
    """The points of a message by the names that `ns.judge` knows."""
    points = message.points
    found = {
        "joint_names": np.array(message.joint_names),
        "t": np.array([item.time_from_start.sec + 1e-9 * item.time_from_start.nanosec for item in points]),
        "q": np.array([item.positions for item in points]),
    }
    for name, of in (("qd", "velocities"), ("qdd", "accelerations")):
        if all(len(getattr(item, of)) for item in points):
            found[name] = np.array([getattr(item, of) for item in points])
    return found


def message_of(plan: ns.Plan) -> JointTrajectory:
    """A plan as a message."""
    motion = plan.trajectory
    t = np.linspace(0.0, plan.duration, int(np.ceil(plan.duration * RATE)) + 1)
    columns = [motion(t, order) for order in range(3)]
    columns[1][[0, -1]] = 0.0
    points = [
        JointTrajectoryPoint(
            positions=q.tolist(),
            velocities=v.tolist(),
            accelerations=a.tolist(),
            time_from_start=Duration(sec=int(at), nanosec=round(1e9 * (at - int(at)))),
        )
        for at, q, v, a in zip(t, *columns, strict=True)
    ]
    return JointTrajectory(joint_names=list(motion.joints), points=points)


class JudgeAndRetime(Node):
    """Listens, judges, times anew, publishes."""

    def __init__(self, scene: ns.Scene, listen: str, publish: str) -> None:
        """Judge by a scene what comes on `listen`."""
        super().__init__("nospill_judge")
        self.scene = scene
        self.out = self.create_publisher(JointTrajectory, publish, 1)
        self.create_subscription(JointTrajectory, listen, self.on_trajectory, 1)

    def on_trajectory(self, message: JointTrajectory) -> None:
        """Publish the message, or its path timed anew, or nothing."""
        try:
            arrays = arrays_of(message)
            judged = ns.judge(arrays, self.scene, receiver="jtc")
            if judged.certificate.ok:
                self.get_logger().info(f"certified as planned: {arrays['t'][-1]:.3f} s")
                self.out.publish(message)
                return
            codes = ", ".join(f"{item['code']} of {item['subject']}" for item in judged.failures())
            self.get_logger().warning(f"not certified: {codes}")
            order = [message.joint_names.index(name) for name in self.scene.robot.joints]
            plan = ns.retime(arrays["q"][:, order], self.scene)
        except ns.NospillError as error:
            self.get_logger().error(str(error))
            return
        self.get_logger().info(plan.message)
        timed = message_of(plan)
        if plan.certificate.ok and ns.judge(arrays_of(timed), self.scene, receiver="jtc").certificate.ok:
            self.out.publish(timed)


def main() -> None:
    """Run until it is stopped."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenario", help="what stands on the tray, and the limits: a file or an example")
    parser.add_argument("--listen", default="/planned")
    parser.add_argument("--publish", default="/joint_trajectory")
    options = parser.parse_args()
    rclpy.init()
    with suppress(KeyboardInterrupt):
        rclpy.spin(JudgeAndRetime(ns.load(options.scenario), options.listen, options.publish))


if __name__ == "__main__":
    main()
