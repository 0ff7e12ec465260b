"""Judge the motion of another planner: ruckig's jerk-limited profile along a line that a UR5e carries three cups on."""

import matplotlib.pyplot as plt
import numpy as np
import ruckig
from scipy.interpolate import CubicSpline

import nospill as ns

scene = ns.load("coffee-to-go").changed({"motion.tilt": "fixed"})
plan = ns.plan(scene)
s, rows = np.unique(plan.trajectory.s, return_index=True)
line = CubicSpline(s, plan.trajectory.joint_position[rows])  # the joints along the line, of any inverse kinematics
turn = np.abs(line(np.linspace(0.0, 1.0, 400), 1))  # rad per unit of s

motions = [("nospill", plan.duration, plan.certificate)]
for acceleration in (10.0, 3.0, 1.5):  # rad/s^2, of the fastest joint; no planner of arms asks what a cup bears
    profile = ruckig.InputParameter(1)
    profile.current_position, profile.target_position = [0.0], [1.0]
    profile.max_velocity = [float(np.min(scene.robot.max_speed / turn.max(axis=0)))]
    profile.max_acceleration = [acceleration / float(turn.max())]
    profile.max_jerk = [10.0 * profile.max_acceleration[0]]
    trajectory = ruckig.Trajectory(1)
    ruckig.Ruckig(1).calculate(profile, trajectory)
    t = np.linspace(0.0, trajectory.duration, 250)
    progress = np.array([trajectory.at_time(time)[0][0] for time in t])
    np.savez("motion.npz", t=t, q=line(progress), joint_names=scene.robot.joints)
    judged = ns.judge("motion.npz", scene, receiver="cubic")
    motions.append((f"ruckig, {acceleration:g} rad/s²", trajectory.duration, judged.certificate))

for name, duration, certificate in motions:
    worst = certificate.worst
    print(
        f"{name}: {duration:.3f} s, {certificate.word}; {worst.constraint} of {worst.subject} {100 * worst.use:.0f} %"
    )

figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
for name, duration, certificate in motions:
    uses = {row.constraint: 100 * row.use for row in certificate.worst_rows()}
    shown = ("slosh height", "residual height", "slip", "tip", "joint speed")
    axes.plot(shown, [uses[constraint] for constraint in shown], "o-", label=f"{name}: {duration:.2f} s")
axes.axhline(100.0, color="black", linestyle="--")
axes.set_yscale("log", base=2)
axes.set_yticks([25, 50, 100, 200, 400], ["25", "50", "100", "200", "400"])
axes.set_ylabel("use of the limit, %")
axes.legend()
figure.savefig("judge_a_planners_motion.png", dpi=100)
