"""The player for a joint_trajectory_controller in the real rclpy, against a node that plays what it receives."""

# pyright: reportMissingImports=false

from __future__ import annotations

import importlib.util
import sys
import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nospill.execution.reading import read_log
from nospill.motion.interpolation import QUINTIC_HERMITE, JointSamples
from nospill.plans.handover import exporter_named
from nospill.scenario import read_scenario

rclpy = pytest.importorskip("rclpy", reason="rclpy is not installed: pip install ros-rclpy ros-trajectory-msgs")
pytest.importorskip("sensor_msgs", reason="sensor_msgs is not installed: pip install ros-sensor-msgs")

FOLDER = Path(__file__).parents[2] / "examples" / "players"
_PERIOD = 0.01


@pytest.fixture
def script(monkeypatch: pytest.MonkeyPatch) -> Any:
    monkeypatch.syspath_prepend(str(FOLDER))
    spec = importlib.util.spec_from_file_location("play_jtc", FOLDER / "play_jtc.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules.pop("rows", None)
    spec.loader.exec_module(module)
    return module


class Controller(threading.Thread):
    """Stands at a place, says so on /joint_states, and plays a message by quintics from when it came."""

    def __init__(self, names: list[str], q: np.ndarray) -> None:
        super().__init__(daemon=True)
        from sensor_msgs.msg import JointState
        from trajectory_msgs.msg import JointTrajectory

        self.node = rclpy.create_node("stand_in_controller")
        self.names, self.q, self.done, self.received = names, q, threading.Event(), []
        self.out = self.node.create_publisher(JointState, "/joint_states", 100)
        self.node.create_subscription(JointTrajectory, "/jtc/joint_trajectory", self.received.append, 1)
        self.executor = rclpy.executors.SingleThreadedExecutor()
        self.executor.add_node(self.node)

    def run(self) -> None:
        from builtin_interfaces.msg import Time
        from sensor_msgs.msg import JointState

        cycle, begun, lasts, motion = 0, 0, 0.0, None
        while not self.done.wait(_PERIOD):
            self.executor.spin_once(timeout_sec=0.0)
            if self.received and motion is None:
                points, begun = self.received[0].points, cycle
                t = np.array([own.time_from_start.sec + 1e-9 * own.time_from_start.nanosec for own in points])
                columns = [[getattr(own, name) for own in points] for name in ("positions", "velocities")]
                columns.append([own.accelerations for own in points])
                lasts = t[-1]
                motion = QUINTIC_HERMITE.motion(JointSamples(t, *map(np.array, columns)))
            at = _PERIOD * (cycle - begun)
            q = self.q if motion is None else motion(np.array([min(at, lasts)]))[0]
            stamp = Time(sec=int(cycle * _PERIOD), nanosec=round(1e9 * ((cycle * _PERIOD) % 1.0)))
            state = JointState(name=self.names[::-1], position=list(q[::-1]))
            state.header.stamp = stamp
            self.out.publish(state)
            cycle += 1


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:module 'sre_:DeprecationWarning")  # of a parser that rclpy brings along
def test_a_motion_is_sent_and_its_log_is_of_what_the_joints_did(
    script: Any, samples: Callable[..., JointSamples], tmp_path: Path
) -> None:
    scene, sent = read_scenario("matrix-rigid"), samples(400)
    joints, q = list(scene.robot.joints), sent.position
    exporter_named("joint-trajectory").write(sent, scene, tmp_path / "tea.json")
    rclpy.init()
    controller = Controller(joints, q[0])
    controller.start()
    try:
        player = script.Player("/jtc")
        message = script.message_of(tmp_path / "tea.json", 0.0)
        player.run(message, tmp_path / "run.csv", lead=0.0, tolerance=0.1)
    finally:
        controller.done.set()
        controller.join()
        rclpy.shutdown()
    log = read_log(tmp_path / "run.csv", scene.robot)
    np.testing.assert_allclose(log.position[0], q[0], atol=1e-6)
    np.testing.assert_allclose(log.position[-1], q[-1], atol=1e-6)
    assert len(np.unique(np.round(log.position[:, 0], 6))) > 20
    assert len(message.points) == len(sent.t)
