"""A goal of control_msgs/action/FollowJointTrajectory as YAML, as `ros2 action send_goal --stdin` takes it.

The trajectory is the message of `joint_trajectory`. A goal also has tolerances, which a message on a topic has not: a
controller that finds a joint farther from the trajectory than the path tolerance stops and says so. They follow from
how the joints are known to lag; without a table [controller] they are left to the controller's own.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from nospill.core.files import atomic_text
from nospill.errors import PlanFolderError, ScenarioError
from nospill.export.base import Exporter, number, text_of
from nospill.export.joint_trajectory import about_lines, message_lines, yaml_table
from nospill.export.message import OPTIONS, RECEIVER, Addressed, message_samples
from nospill.motion.control import followed, settled_after
from nospill.motion.interpolation import QUINTIC_HERMITE, JointSamples
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene

GOAL_TYPE = "control_msgs/action/FollowJointTrajectory"
ACTION = "/joint_trajectory_controller/follow_joint_trajectory"
SUFFIX = ".goal.yaml"
_FACTOR = 2.0
"""Path tolerance over the distance that the stated delay and lag put a joint behind its command."""
LEAST_TOLERANCE = 2e-3
"""rad; of the path, and of the goal: what is left at rest."""
_FINENESS = 4
"""Instants per sample at which the distance is looked at."""


def path_tolerances(samples: JointSamples, controller: Controller) -> np.ndarray:
    """How far each joint may be from its command, (n,), rad.

    The controller's own tolerance where it is stated; else twice the largest distance of a joint that follows its
    command with the stated delay and lag.
    """
    if controller.tracking_tolerance is not None:
        return controller.tracking_tolerance
    command = QUINTIC_HERMITE.motion(samples)
    start, stop = float(samples.t[0]), float(samples.t[-1])
    done = followed(command, controller, start, stop)
    t = np.linspace(start, stop + settled_after(controller), _FINENESS * len(samples.t))
    behind = np.abs(done(t - controller.latest) - command(t))
    return np.maximum(_FACTOR * np.max(behind, axis=0), LEAST_TOLERANCE)


def _tolerance_lines(samples: JointSamples, scene: Scene, sent: Addressed) -> list[str]:
    if scene.controller is None:
        return []
    names = sent.names(scene)
    path = path_tolerances(samples, scene.controller)
    goal = np.full(len(names), LEAST_TOLERANCE)
    late = round(1e9 * settled_after(scene.controller))
    return [
        f"path_tolerance: {_tolerances(names, path)}",
        f"goal_tolerance: {_tolerances(names, goal)}",
        f"goal_time_tolerance: {json.dumps({'sec': late // 10**9, 'nanosec': late % 10**9})}",
    ]


def _tolerances(names: list[str], values: np.ndarray) -> str:
    """Of positions; speeds and accelerations are not checked."""
    entries = (
        f'{{"name": {json.dumps(name)}, "position": {number(value)}, "velocity": -1.0, "acceleration": -1.0}}'
        for name, value in zip(names, np.round(values, 6), strict=True)
    )
    return f"[{', '.join(entries)}]"


def _write(samples: JointSamples, scene: Scene, path: Path, sent: Addressed) -> None:
    if not path.name.endswith((".yaml", ".yml")):
        raise ScenarioError(f"{path}: a goal is written as .yaml or .yml; name the file so")
    lines = [
        *about_lines(GOAL_TYPE, samples, scene),
        f"# ros2 action send_goal --stdin {sent.topic or ACTION} {GOAL_TYPE} < this file",
        "trajectory:",
        *(f"  {line}" for line in message_lines(samples, scene, sent)),
        *_tolerance_lines(samples, scene, sent),
        "",
    ]
    atomic_text(path, "\n".join(lines))


def _read(path: Path, scene: Scene, sent: Addressed) -> JointSamples:
    table = yaml_table(text_of(path), path)
    if "trajectory" not in table:
        raise PlanFolderError(f"{path}: not a goal {GOAL_TYPE}: trajectory is missing; write it again")
    _require_tolerances(table, scene, sent, path)
    return message_samples(table, scene, path, sent)


def _require_tolerances(table: dict[str, Any], scene: Scene, sent: Addressed, path: Path) -> None:
    """Refuse tolerances that are not one for each joint: a controller refuses the goal for them."""
    for key in ("path_tolerance", "goal_tolerance"):
        entries = table.get(key, [])
        named = [entry.get("name") for entry in entries if isinstance(entry, dict)] if isinstance(entries, list) else 0
        if named not in ([], sent.names(scene)):
            raise PlanFolderError(f"{path}, {key}: is not one entry for each joint; write it again with nospill export")


def action_goal_exporter(prefix: str = "", topic: str = "", lead: float = 0.0, begins: float = 0.0) -> Exporter:
    """The goal as it is sent.

    Raises:
        ScenarioError: see `message.Addressed`.
    """
    sent = Addressed(prefix, lead, topic, begins)
    return Exporter(
        name="action-goal",
        suffixes=(SUFFIX,),
        title="FollowJointTrajectory goal as YAML, with path and goal tolerances from [controller]",
        receiver=RECEIVER,
        interpolation=QUINTIC_HERMITE,
        reason_against=lambda scene, rate: None,
        write=lambda samples, scene, path: _write(samples, scene, path, sent),
        read=lambda path, scene: _read(path, scene, sent),
        uneven=True,
        options=OPTIONS,
        with_options=action_goal_exporter,
        beginning=lambda begins: action_goal_exporter(prefix, topic, lead, begins),
    )


ACTION_GOAL = action_goal_exporter()
"""A goal of the controller's action."""
