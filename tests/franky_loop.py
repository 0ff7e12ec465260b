"""An arm of franky-sim, which nobody here wrote: its position servo and MuJoCo, cycle by cycle, without clocks."""

from __future__ import annotations

from importlib import import_module

import numpy as np

from nospill.execution.log import JointLog
from nospill.plans.plan import Plan
from nospill.plans.played import planned_samples

_HOLD, _TAIL = 300, 900
"""Cycles of 1 ms before and after a motion."""


def played(plan: Plan) -> JointLog:
    """The log of a plan, asked for at 1 kHz; its command is beside what the joints do."""
    asked = np.pad(planned_samples(plan, 1000.0).position, ((_HOLD, _TAIL), (0, 0)), mode="edge")
    simulator = import_module("franky_sim.mujoco_simulator").MujocoSimulator()
    robot = simulator.add_robot(initial_q=asked[0])
    simulator.init()
    simulator.start()
    done = []
    for position in asked:
        done.append(robot.inner_state.q)
        robot.joint_position_control(position)
        simulator.step()
    simulator.cleanup()
    t = np.arange(len(asked)) * 1e-3
    return JointLog("franky-sim", t, plan.scene.robot.joints, np.array(done), command=asked)
