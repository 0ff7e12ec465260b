"""A glass on a foot of twice its radius swings like a plain cup and stands twice as firmly."""

import nospill as ns

two_cups = ns.load("pp-two-cups")
plain_scene = two_cups.changed({"cargo.1": None, "cargo.0.at": [0, 0]})
footed_scene = plain_scene.changed({"cargo.0.shape": "footed-glass", "cargo.0.foot_radius": "70 mm"})

modes = [scene.cargo[0].filling.modes for scene in (plain_scene, footed_scene)]
assert modes[0].oscillators[0].frequency == modes[1].oscillators[0].frequency

plan = ns.plan(footed_scene)
assert plan.certificate.ok
tip = {row.subject: row.worst_value for row in plan.certificate.rows if row.constraint == "tip"}
tip_of_plain = {
    row.subject: row.worst_value for row in ns.certify(plan.trajectory, plain_scene).rows if row.constraint == "tip"
}
name = plain_scene.cargo[0].name
assert abs(tip_of_plain[name] - 2 * tip[name]) < 1e-6
print(f"tip: {100 * tip[name]:.0f} % with the foot, {100 * tip_of_plain[name]:.0f} % without, in the same motion")
