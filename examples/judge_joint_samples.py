"""Judge joint samples of any origin: is this slowed motion calm enough, and this hurried one?"""

import matplotlib.pyplot as plt
import numpy as np

import nospill as ns

scene = ns.load("pp-two-cups")
plan = ns.plan(scene)

figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
for speed in (0.5, 0.8, 1.0, 1.1):
    t = np.arange(0.0, plan.trajectory.t[-1] / speed, 0.002)
    q = plan.trajectory(speed * t)  # any array (m, 6), rad: of another planner, a spreadsheet, a teach pendant
    certificate = ns.certify_joints(t, q, scene)
    worst = certificate.worst
    print(
        f"{100 * speed:.0f} % speed: {certificate.word}; {worst.constraint} of {worst.subject} {100 * worst.use:.1f} %"
    )
    rows = {f"{row.constraint} of {row.subject}": 100 * row.use for row in certificate.rows if row.subject == "left"}
    axes.plot(list(rows), list(rows.values()), "o", label=f"{100 * speed:.0f} % speed")
axes.axhline(100.0, color="black", linestyle="--")
axes.set_ylabel("use of the limit, %")
axes.tick_params("x", rotation=30)
axes.legend()
figure.savefig("judge_joint_samples.png", dpi=100)
