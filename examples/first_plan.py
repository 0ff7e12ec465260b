"""A first plan: a bundled example, its duration, its certificate, and a plan folder."""

from pathlib import Path

import nospill as ns

scene = ns.load("pp-two-cups")  # the name of an example, a scenario file, or a dictionary
plan = ns.plan(scene)

print(f"{scene.name}: {plan.duration:.3f} s")
print(plan.text())  # certificate, warnings, what holds it back: what `nospill plan` prints
for row in plan.certificate.worst_rows()[:3]:
    print(f"{row.constraint} of {row.subject}: {100 * row.use:.1f} % of the limit at {row.at_s:.2f} s")

folder = Path("out/first-plan")
plan.save(folder)
print(f"written to {folder}: {', '.join(sorted(path.name for path in folder.iterdir()))}")
