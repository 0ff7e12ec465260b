"""Past an obstacle: the branch of the arm that is free of it, and what a wider clearance costs."""

import nospill as ns

scene = ns.load("cups-past-a-column")
for clearance in ("10 mm", "30 mm"):
    plan = ns.plan(scene.changed({"obstacle.column.clearance": clearance}))
    nearest = min(
        (row for row in plan.certificate.rows if row.constraint == "clearance"), key=lambda row: row.worst_margin
    )
    print(f"{clearance} of clearance: {plan.duration:.3f} s, {plan.status}")
    print(f"  {plan.report.branch}; nearest: {nearest.subject}, {1e3 * nearest.worst_value:.0f} mm")
    print(f"  {plan.limiting_text}")

plan.plot("distances").savefig("around_an_obstacle.png", dpi=100)
