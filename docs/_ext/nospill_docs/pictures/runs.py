"""Picture of a simulated run: what an arm with a lag makes of a plan, and what a camera would see of it."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from nospill.execution.executed import executed
from nospill.execution.log import JointLog
from nospill.motion.control import followed
from nospill.plans.plan import Plan
from nospill.plots.executed import executed_figure
from nospill.scene.controller import Controller
from nospill.simulation.motion_file import Heights
from nospill_docs.pictures.paper import WIDTH

READS = ("../src/nospill/execution/executed.py", "../src/nospill/plots/executed.py", "../src/nospill/motion/control.py")
"""What its pictures read, from docs/."""
_DELAY, _LAG = 0.008, 0.015
_CAMERA = 1.0 / 60.0


def run_of_a_late_arm(plan: Plan) -> Figure:
    """A plan, its log from joints with a delay and a lag, and the height of its first cup with noise, 20 % higher."""
    generator = np.random.default_rng(0)
    joints = plan.scene.robot.joints
    late = Controller(np.full(len(joints), _DELAY), np.full(len(joints), _LAG), compensate=False)
    length = float(plan.trajectory.t[-1])
    t = np.arange(0.0, length + 1.0, 0.002)
    done = followed(plan.trajectory.motion, late, 0.0, length)(t - 0.3)
    log = JointLog("simulated", t, joints, done + 1e-5 * generator.standard_normal(done.shape))
    bare = executed(log, plan.scene, plan=plan)
    shown = np.arange(-0.2, length + 0.6, _CAMERA)
    height = np.interp(shown, bare.judgement.replay.t, bare.heights["c1"], left=0.0)
    seen = Heights(shown, 1.2 * height + 4e-4 * generator.standard_normal(len(shown)))
    figure = executed_figure(executed(log, plan.scene, plan=plan, measured={"c1": seen}))
    figure.set_size_inches(WIDTH, 5.6)
    return figure
