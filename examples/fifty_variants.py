"""Fifty variants in a loop, warm: the shortest duration over the friction of the tray."""

import matplotlib.pyplot as plt
import numpy as np

import nospill as ns

scene = ns.load("pp-two-cups")
planner = ns.Planner()  # starts each plan from the one before where the structure of the scene is the same
frictions = np.linspace(0.10, 0.60, 50)
plans = [planner.plan(scene.changed({"tray.friction": float(friction)})) for friction in frictions]

certified = np.array([plan.certificate.ok for plan in plans])
duration = np.array([plan.duration for plan in plans])
print(f"{certified.sum()} of {len(plans)} are certified, {duration.min():.3f} to {duration.max():.3f} s")

figure, axes = plt.subplots(figsize=(6.4, 3.6), layout="constrained")
axes.plot(frictions[certified], duration[certified], ".-")
axes.set(xlabel="friction coefficient of the tray", ylabel="shortest duration, s", title="Two cups on fifty trays")
figure.savefig("fifty_variants.png", dpi=100)
