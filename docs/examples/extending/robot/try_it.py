"""The new arm carries a cup along a line; its limits are judged joint by joint."""

import nospill as ns

line = ns.LinePath(start=[0.55, -0.3, 0.9], end=[0.55, 0.3, 1.1])
scene = ns.load("pp-two-cups").changed({"robot": ns.Robot(model="teaching-arm"), "path": line})
plan = ns.plan(scene)
assert plan.certificate.ok
speeds = {row.subject: row.use for row in plan.certificate.rows if row.constraint == "joint speed"}
assert list(speeds) == ["waist", "shoulder", "elbow", "forearm", "wrist", "hand"]
fastest = max(speeds, key=lambda joint: speeds[joint])
print(f"certified: {plan.duration:.3f} s; {fastest} uses {100 * speeds[fastest]:.0f} % of its speed")
