"""Arrays of a plan, and a figure of one's own: joint acceleration, slosh height and friction at any time."""

import matplotlib.pyplot as plt
import numpy as np

import nospill as ns

plan = ns.plan("pp-two-cups")
t = np.linspace(0.0, plan.duration, 1001)  # any times: the trajectory is a function
acceleration = plan.trajectory(t, order=2)  # (1001, 6), rad/s^2
height = plan.history("slosh height", "left")
slip = plan.history("slip", "left")

figure, axes = plt.subplots(3, 1, figsize=(6.4, 6.4), sharex=True, layout="constrained")
axes[0].plot(t, acceleration, label=plan.scene.robot.joints)
axes[0].set_ylabel("joint acceleration, rad/s²")
axes[0].legend(ncols=3, fontsize="x-small")
axes[1].plot(height.t, 1e3 * height.demand)
axes[1].plot(height.t, 1e3 * height.limit, "k--")
axes[1].set_ylabel("slosh height, mm")
axes[2].plot(slip.t, 100.0 * slip.use)
axes[2].set(ylabel="use of friction, %", xlabel="t, s")
figure.savefig("arrays_and_plot.png", dpi=100)

plan.plot("joints").savefig("joints.png", dpi=100)  # or a figure of the package
print(f"crest {1e3 * height.demand.max():.2f} mm at t = {height.t[height.demand.argmax()]:.3f} s")
