"""A glass on a foot of twice its radius swings like a plain cup and stands twice as firmly."""

import copy

import nospill as ns
from nospill.scenario import scene_from_table

table = copy.deepcopy(dict(ns.load("pp-two-cups").source))
plain = {**table["cargo"][0], "at": [0, 0]}
footed = {**plain, "shape": "footed-glass", "foot_radius": "70 mm"}
table["cargo"] = [footed]
footed_scene = scene_from_table(table, name="footed")
table["cargo"] = [plain]
plain_scene = scene_from_table(table, name="plain")

modes = [scene.cargo[0].filling.modes for scene in (plain_scene, footed_scene)]
assert modes[0].oscillators[0].frequency == modes[1].oscillators[0].frequency

plan = ns.plan(footed_scene)
assert plan.certificate.ok
tip = {row.subject: row.worst_value for row in plan.certificate.rows if row.constraint == "tip"}
tip_of_plain = {
    row.subject: row.worst_value for row in ns.certify(plan.trajectory, plain_scene).rows if row.constraint == "tip"
}
name = plain["name"]
assert abs(tip_of_plain[name] - 2 * tip[name]) < 1e-6
print(f"tip: {100 * tip[name]:.0f} % with the foot, {100 * tip_of_plain[name]:.0f} % without, in the same motion")
