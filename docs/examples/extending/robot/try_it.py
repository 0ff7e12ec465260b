"""The new arm carries a cup along a line; its limits are judged joint by joint."""

import copy

import nospill as ns
from nospill.scenario import scene_from_table

table = copy.deepcopy(dict(ns.load("pp-two-cups").source))
table["robot"] = {"model": "teaching-arm"}
table["path"] = {"type": "line", "start": [0.5, -0.3, 0.7], "end": [0.5, 0.3, 0.9]}
plan = ns.plan(scene_from_table(table, name="teaching"))
assert plan.certificate.ok
speeds = {row.subject: row.use for row in plan.certificate.rows if row.constraint == "joint speed"}
assert list(speeds) == ["waist", "shoulder", "elbow", "forearm", "wrist", "hand"]
fastest = max(speeds, key=lambda joint: speeds[joint])
print(f"certified: {plan.duration:.3f} s; {fastest} uses {100 * speeds[fastest]:.0f} % of its speed")
