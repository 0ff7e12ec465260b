"""Send a motion to a ROS 2 joint_trajectory_controller, and log what /joint_states say of it.

    nospill export out/tea --format joint-trajectory -o tea.json
    python play_jtc.py tea.json run.csv --controller /joint_trajectory_controller
    nospill executed run.csv --plan out/tea

With control_msgs at hand it is a goal of FollowJointTrajectory, whose path tolerance stops a motion that is not
followed; without, a message on the controller's topic, which has none. The arm must stand at the first point, or
`--lead 4 s` lets the controller make a quintic of its own to it in that time, which nothing has checked for obstacles.
"""

# pyright: reportMissingImports=false

from __future__ import annotations

import argparse
import json
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
from builtin_interfaces.msg import Duration
from rclpy.node import Node
from rows import AT_START, require_start, write_log
from sensor_msgs.msg import JointState
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

REST = 0.5
"""s at rest before and after the motion, of the record."""
PATIENCE = 10.0
"""s, for which an answer is waited for."""
COLUMNS = ("positions", "velocities", "accelerations")


def message_of(path: Path, lead: float) -> JointTrajectory:
    """The message of a file of nospill's, its points `lead` s later."""
    table = json.loads(path.read_text(encoding="utf-8"))["msg"]
    points = []
    for item in table["points"]:
        at = item["time_from_start"]["sec"] + 1e-9 * item["time_from_start"]["nanosec"] + lead
        since = Duration(sec=int(at), nanosec=round(1e9 * (at - int(at))))
        points.append(JointTrajectoryPoint(**{name: item[name] for name in COLUMNS}, time_from_start=since))
    return JointTrajectory(joint_names=table["joint_names"], points=points)


class Player(Node):
    """Knows where the arm is, sends a message, and keeps what the joints did."""

    def __init__(self, controller: str) -> None:
        """Listen to the joints, and get ready to send to a controller's name."""
        super().__init__("nospill_player")
        self.controller = controller
        self.states: list[JointState] = []
        self.create_subscription(JointState, "/joint_states", self.states.append, 100)
        self.topic = self.create_publisher(JointTrajectory, f"{controller}/joint_trajectory", 1)

    def wait(self, ready: Any, what: str, seconds: float = PATIENCE) -> None:
        """Until something is so; what it waits for in vain is named."""
        end = time.monotonic() + seconds
        while not ready():
            if time.monotonic() > end:
                raise SystemExit(f"{what}: not within {seconds:g} s")
            rclpy.spin_once(self, timeout_sec=0.01)

    def spin(self, seconds: float) -> None:
        """Keep what comes for a time."""
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            rclpy.spin_once(self, timeout_sec=0.01)

    def position(self, state: JointState, joints: list[str]) -> np.ndarray:
        """Of the joints in the message's order, rad."""
        names = list(state.name)
        return np.array([state.position[names.index(name)] for name in joints])

    def stands_at(self, goal: np.ndarray, joints: list[str]) -> bool:
        """Whether the last state is at a place."""
        return bool(self.states) and np.max(np.abs(self.position(self.states[-1], joints) - goal)) < AT_START

    def run(self, message: JointTrajectory, out: Path, *, lead: float, tolerance: float) -> None:
        """Check the start, hold, send, follow to the end, write the log."""
        joints = list(message.joint_names)
        self.wait(lambda: any(set(joints) <= set(own.name) for own in self.states), "/joint_states with these joints")
        first = np.array(message.points[0].positions)
        require_start(self.position(self.states[-1], joints), first, may_move=lead > 0.0, option="--lead 4")
        last, goal = message.points[-1].time_from_start, np.array(message.points[-1].positions)
        self.spin(REST)
        self.states.clear()
        self.send(message, tolerance)
        arrived = partial(self.stands_at, goal, joints)
        self.wait(arrived, "the last point", last.sec + 1e-9 * last.nanosec + PATIENCE)
        self.spin(REST)
        stamps = [own.header.stamp.sec + 1e-9 * own.header.stamp.nanosec for own in self.states]
        asked = np.full(len(joints), np.nan)
        log = [(t, self.position(own, joints), asked) for t, own in zip(stamps, self.states, strict=True)]
        write_log(out, log, len(joints))
        print(f"{out}: {len(log)} states of {len(message.points)} points")

    def send(self, message: JointTrajectory, tolerance: float) -> None:
        """As a goal where there is its type, else on the topic."""
        try:
            from control_msgs.action import FollowJointTrajectory
            from control_msgs.msg import JointTolerance
        except ModuleNotFoundError:
            print("no control_msgs: sent on the topic, where no path tolerance stops a motion that is not followed")
            self.wait(self.topic.get_subscription_count, f"who listens on {self.topic.topic_name}")
            self.topic.publish(message)
            return
        from rclpy.action import ActionClient

        client = ActionClient(self, FollowJointTrajectory, f"{self.controller}/follow_joint_trajectory")
        if not client.wait_for_server(timeout_sec=PATIENCE):
            raise SystemExit(f"{self.controller}/follow_joint_trajectory: no such action within 10 s")
        allowed = [JointTolerance(name=name, position=tolerance) for name in message.joint_names]
        done = client.send_goal_async(FollowJointTrajectory.Goal(trajectory=message, path_tolerance=allowed))
        self.wait(done.done, "an answer to the goal")
        if not done.result().accepted:
            raise SystemExit("the controller refuses the goal; its own log says why")


def main() -> None:
    """Connect and run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("motion", type=Path, help="a .json of --format joint-trajectory")
    parser.add_argument("log", type=Path)
    parser.add_argument("--controller", default="/joint_trajectory_controller")
    parser.add_argument("--lead", type=float, default=0.0, help="s in which the controller goes to the first point")
    parser.add_argument("--tolerance", type=float, default=0.1, help="rad behind the command at which it stops")
    options = parser.parse_args()
    rclpy.init()
    try:
        message = message_of(options.motion, options.lead)
        Player(options.controller).run(message, options.log, lead=options.lead, tolerance=options.tolerance)
    finally:
        rclpy.shutdown()


if __name__ == "__main__":
    main()
