"""The node of examples/players in the real rclpy: what is certified goes on, what is not comes out timed anew."""

# pyright: reportMissingImports=false

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nospill as ns
from tests.waiting import wait_until

rclpy = pytest.importorskip("rclpy", reason="rclpy is not installed: pip install ros-rclpy ros-trajectory-msgs")
SCRIPT = Path(__file__).parents[2] / "examples" / "players" / "judge_and_retime_node.py"
START = [0.0, -1.4, 1.6, np.pi / 2 - 0.2, -np.pi / 2, 0.0]
"""rad, of a UR5e whose tray is level."""
CUP = {"name": "c", "shape": "cylinder", "radius": "35 mm", "height": "100 mm", "liquid": "water",
       "liquid_height": "60 mm", "max_slosh_height": "15 mm", "empty_mass": "50 g", "at": [0, 0]}  # fmt: skip


@pytest.fixture(scope="module")
def node() -> Any:
    spec = importlib.util.spec_from_file_location("judge_and_retime_node", SCRIPT)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def scene() -> ns.Scene:
    return ns.load(
        {
            "robot": {"model": "ur5e", "limits": {"acceleration": 10.0}},
            "tray": {"size": ["200 mm", "150 mm"], "friction": 0.5, "offset": "80 mm"},
            "cargo": [CUP],
            "path": {"type": "line", "start": ["0.4 m", "-0.2 m", "0.4 m"], "end": ["0.4 m", "0.2 m", "0.4 m"]},
            "planning": {"slosh_modes": 2},
        }
    )


def swept(node: Any, names: list[str], duration: float) -> Any:
    """A quintic of one joint from rest to rest, its joints listed in another order."""
    from builtin_interfaces.msg import Duration
    from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

    u = np.linspace(0.0, 1.0, 21)
    way, rate = 10 * u**3 - 15 * u**4 + 6 * u**5, (30 * u**2 - 60 * u**3 + 30 * u**4) / duration
    points = []
    for at, x, v in zip(duration * u, way, rate, strict=True):
        q = [value + (0.8 * x if index == 0 else 0.0) for index, value in enumerate(START)]
        speed = [0.8 * v, 0.0, 0.0, 0.0, 0.0, 0.0]
        now = Duration(sec=int(at), nanosec=round(1e9 * (at - int(at))))
        points.append(JointTrajectoryPoint(positions=q[::-1], velocities=speed[::-1], time_from_start=now))
    return JointTrajectory(joint_names=names[::-1], points=points)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning")  # of a parser that rclpy brings along
@pytest.mark.parametrize(("duration", "changed"), [(8.0, False), (0.6, True)])
def test_what_is_published_is_certified(node: Any, scene: ns.Scene, duration: float, changed: bool) -> None:
    from trajectory_msgs.msg import JointTrajectory

    sent, received = swept(node, list(scene.robot.joints), duration), []
    rclpy.init()
    try:
        judge = node.JudgeAndRetime(scene, "/planned", "/timed")
        other = rclpy.create_node("planner_and_controller")
        publisher = other.create_publisher(JointTrajectory, "/planned", 1)
        other.create_subscription(JointTrajectory, "/timed", received.append, 1)
        executor = rclpy.executors.SingleThreadedExecutor()
        executor.add_node(judge)
        executor.add_node(other)

        def spin(pause: float) -> None:
            executor.spin_once(timeout_sec=pause)

        counts = (publisher.get_subscription_count, judge.out.get_subscription_count)
        wait_until(lambda: all(count() for count in counts), "the topics are connected", pause=spin)
        publisher.publish(sent)
        wait_until(lambda: received, "a trajectory is published", pause=spin)
    finally:
        rclpy.shutdown()
    (message,) = received
    arrays = node.arrays_of(message)
    assert (message != sent) == changed
    assert ns.judge(arrays, scene, receiver="jtc").certificate.ok
    assert ns.judge(node.arrays_of(sent), scene, receiver="jtc").certificate.ok != changed
